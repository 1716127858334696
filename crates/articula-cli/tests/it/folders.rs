//! Whole folders in one call: every readable file is converted, the others are listed.

use crate::program::{BVH, articula, fault, folder, human, json, word};
use serde_json::Value;
use std::path::Path;

/// Two motions, one broken file, and one that is not a motion.
fn motions(here: &Path) {
    let clips = here.join("clips");
    std::fs::create_dir_all(&clips).unwrap();
    std::fs::write(clips.join("b.bvh"), BVH).unwrap();
    std::fs::write(clips.join("a.bvh"), BVH).unwrap();
    std::fs::write(clips.join("broken.bvh"), "HIERARCHY\nROOT Hips\n{\n").unwrap();
    std::fs::write(clips.join("notes.txt"), "not read").unwrap();
    std::fs::write(clips.join(".hidden.bvh"), "not read").unwrap();
}

#[test]
fn one_broken_file_stops_none_of_the_others() {
    let here = folder("broken-among");
    motions(&here);
    let ran = articula(&here, &["convert", "clips", "out", "--to", "glb", "--json"]);
    assert_eq!(ran.status, 1, "{}", ran.err);
    let report: Value = serde_json::from_str(&ran.out).unwrap();
    let outs: Vec<_> = report["files"]
        .as_array()
        .unwrap()
        .iter()
        .map(|f| f["out"].clone())
        .collect();
    assert_eq!(outs, ["out/a.glb", "out/b.glb"], "sorted by name");
    assert_eq!(report["failed"].as_array().unwrap().len(), 1);
    assert_eq!(report["failed"][0]["in"], "clips/broken.bvh");
    let lines: Vec<&str> = ran.err.lines().collect();
    assert_eq!(lines.len(), 2, "{}", ran.err);
    assert!(
        lines[0].starts_with("error: clips/broken.bvh: end of file: "),
        "{}",
        lines[0]
    );
    assert_eq!(lines[1], "error: 1 of 3 files failed; the others are done");
    for name in ["out/a.glb", "out/b.glb"] {
        assert_eq!(json(&here, &["inspect", name])["clips"][0]["frames"], 4);
    }
    let words = ["convert", "clips", "out", "--to", "glb", "--force"];
    let text = articula(&here, &words);
    assert!(
        text.out.starts_with("out: 2 files written, 1 failed\n"),
        "{}",
        text.out
    );
}

#[test]
fn a_folder_may_be_named_with_a_separator_or_be_there() {
    let here = folder("folder-names");
    std::fs::write(here.join("a.bvh"), BVH).unwrap();
    std::fs::write(here.join("b.bvh"), BVH).unwrap();
    json(&here, &["convert", "a.bvh", "new/"]);
    assert!(here.join("new/a.glb").is_file(), "without --to: glb");
    json(&here, &["convert", "a.bvh", "b.bvh", "new", "--to", "bvh"]);
    assert!(here.join("new/a.bvh").is_file() && here.join("new/b.bvh").is_file());
    // Two files with the same stem keep their whole names.
    json(&here, &["convert", "new", "both"]);
    for name in ["a.bvh.glb", "a.glb.glb", "b.glb"] {
        assert!(here.join("both").join(name).is_file(), "{name}");
    }
}

#[test]
fn a_reduction_applies_to_every_file() {
    let here = folder("reduced-all");
    std::fs::copy(human(), here.join("a.glb")).unwrap();
    let report = json(&here, &["convert", "a.glb", "low/", "--loa", "loa(Low)"]);
    assert!(report["files"][0]["reduction"]["saved"].as_f64().unwrap() > 0.3);
}

#[test]
fn files_are_not_replaced_by_what_is_made_of_them() {
    let here = folder("own-folder");
    std::fs::create_dir_all(here.join("clips")).unwrap();
    std::fs::copy(human(), here.join("clips/a.glb")).unwrap();
    let before = std::fs::read(here.join("clips/a.glb")).unwrap();
    let words = ["convert", "clips", "clips", "--loa", "loa(Low)"];
    let ran = articula(&here, &words);
    assert_eq!(ran.status, 2);
    assert!(ran.err.contains("never replaced"), "{}", ran.err);
    assert_eq!(std::fs::read(here.join("clips/a.glb")).unwrap(), before);
}

#[test]
fn wrong_usage_of_folders_says_what_would_be_right() {
    let here = folder("folder-usage");
    motions(&here);
    std::fs::create_dir_all(here.join("empty")).unwrap();
    let human = word(human());
    let usage: &[(&[&str], &str)] = &[
        (&["convert", "clips", "all.glb"], "all/ --to glb"),
        (
            &["convert", human, "a.glb", "--to", "bvh"],
            "leave --to out",
        ),
        (&["convert", human, "a"], "end the name with /"),
    ];
    for (words, mend) in usage {
        let line = fault(&here, 2, words);
        assert!(line.contains(mend), "{words:?}: {line}");
    }
    let ran = articula(&here, &["convert", "clips", "out", "--to", "dae"]);
    assert_eq!(ran.status, 2);
    assert!(
        ran.err.contains("supported conversions: glb"),
        "{}",
        ran.err
    );
    let line = fault(&here, 1, &["convert", "empty", "out"]);
    assert!(line.contains("readable are .glb"), "{line}");
}
