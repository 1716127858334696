//! `flatten` on the command line: files, numbers and refused input.

use crate::program::{articula, fault, folder, json, short, word};
use serde_json::Value;
use std::path::Path;

const SMALL: [&str; 8] = [
    "--clip",
    "walk",
    "--triangles",
    "200",
    "--size",
    "120",
    "--fps",
    "10",
];

fn flatten(here: &Path, out: &str, more: &[&str]) -> Value {
    let words = [&["flatten", word(short()), out], &SMALL[..], more].concat();
    json(here, &words)
}

#[test]
fn every_profile_writes_a_file_and_says_what_it_is() {
    let here = folder("flatten-profiles");
    for (profile, out, modality, start) in [
        ("smil", "a.svg", "vector/smil", "<svg"),
        ("flipbook", "b.svg", "vector/flipbook", "<svg"),
        ("player", "c.svg", "vector/player", "<svg"),
        ("player", "c.js", "vector/player", ""),
        ("lottie", "d.json", "vector/lottie", "{"),
        ("still", "e.svg", "vector/still", "<svg"),
        ("thesis", "f.svg", "vector/thesis", "<"),
    ] {
        let report = flatten(&here, out, &["--profile", profile]);
        let text = std::fs::read_to_string(here.join(out)).unwrap();
        assert!(text.starts_with(start), "{profile}: {}", &text[..40]);
        assert_eq!(report["profile"], profile);
        assert_eq!(report["bytes"]["raw"], text.len());
        assert_eq!(report["representation"]["modality"], modality);
        assert_eq!(report["representation"]["bytes"], text.len());
        let error = &report["error"];
        let number = |name: &str| error[name].as_f64().unwrap();
        let sorted = number("wrong_pixels_percent_depth_sort");
        assert!(number("wrong_pixels_percent") <= sorted, "{error}");
        let least = if profile == "thesis" { 0.8 } else { 0.93 };
        assert!(number("ssim") > least, "{profile}: {error}");
        assert!(number("position_rmse_px") < 0.6, "{profile}: {error}");
        let stray = error["stray_pixels_percent"].as_f64();
        let is_counted = !["player", "thesis"].contains(&profile);
        assert_eq!(stray.is_some(), is_counted, "{profile}");
        assert!(stray.is_none_or(|stray| stray < 1.0), "{profile}: {error}");
        assert!(report["triangles_drawn"].as_u64().unwrap() > 60);
        assert!(
            !report["representation"]["needs"]
                .as_array()
                .unwrap()
                .is_empty()
        );
    }
}

#[test]
fn a_moment_of_the_file_can_be_rendered_and_all_of_it() {
    let here = folder("flatten-frames");
    let report = flatten(&here, "walk.svg", &[]);
    let frames = report["frames"].as_u64().unwrap();
    json(
        &here,
        &["flatten", "frame", "walk.svg", "one.png", "--at", "0.3"],
    );
    let png = std::fs::read(here.join("one.png")).unwrap();
    let picture = articula::flat::Picture::decode(&png).unwrap();
    assert_eq!((picture.width(), picture.height()), (120, 120));
    json(
        &here,
        &["flatten", "frame", "walk.svg", "one.svg", "--at", "0.3"],
    );
    let still = std::fs::read_to_string(here.join("one.svg")).unwrap();
    assert!(!still.contains("<animate"));
    for out in ["walk.gif", "walk.webp", "pictures"] {
        let movie = json(&here, &["flatten", "movie", "walk.svg", out, "--fps", "10"]);
        // The last frame is the first one of the next cycle.
        assert_eq!(movie["frames"].as_u64().unwrap(), frames - 1, "{out}");
    }
    // Straight from the character: the same frames.
    let direct = flatten(&here, "direct.webp", &[]);
    let both = ["walk.webp", "direct.webp"].map(|name| std::fs::read(here.join(name)).unwrap());
    assert!(both[0] == both[1], "the movies differ");
    assert_eq!(direct["bytes"]["raw"], both[1].len());
    assert_eq!(direct["representation"]["modality"], "movie/webp");
    let start = |name: &str| std::fs::read(here.join(name)).unwrap()[..4].to_vec();
    assert_eq!(start("walk.gif"), b"GIF8");
    assert_eq!(start("walk.webp"), b"RIFF");
    let pictures = std::fs::read_dir(here.join("pictures")).unwrap().count();
    assert_eq!(pictures as u64, frames - 1);
}

#[test]
fn a_budget_is_kept_by_the_best_that_fits() {
    let here = folder("flatten-budget");
    let free = flatten(&here, "free.svg", &[]);
    let raw = |report: &Value| report["bytes"]["raw"].as_u64().unwrap();
    let budget = (raw(&free) * 2 / 3).to_string();
    let held = flatten(&here, "held.svg", &["--max-bytes", &budget]);
    assert!(raw(&held) <= raw(&free) * 2 / 3);
    let tried = held["tried"].as_array().unwrap();
    assert!(tried.len() > 1);
    let chosen = held["error"]["image_rmse_levels"].as_f64().unwrap();
    for trial in tried.iter().filter(|t| t["fits"] == true) {
        let other = trial["image_rmse_levels"].as_f64().unwrap();
        assert!(chosen <= other + 1e-9, "{trial}");
    }
    assert_eq!(held["bytes_over"], Value::Null);
}

#[test]
fn the_same_command_writes_the_same_bytes() {
    let here = folder("flatten-same");
    flatten(&here, "a.svg", &["--turn-deg", "90"]);
    flatten(&here, "b.svg", &["--turn-deg", "90"]);
    let read = |name: &str| std::fs::read(here.join(name)).unwrap();
    assert_eq!(read("a.svg"), read("b.svg"));
}

#[test]
fn wrong_words_and_files_are_told_in_one_line() {
    let here = folder("flatten-refused");
    let human = word(short());
    for (status, words, expected) in [
        (2, vec!["flatten", human, "a.bmp"], "name the file .svg"),
        (
            2,
            vec!["flatten", human, "a.svg", "--shading", "exact"],
            "--shading exact",
        ),
        (
            2,
            vec!["flatten", human, "a.svg", "--quality", "merge=9"],
            "--shading flat",
        ),
        (
            2,
            vec![
                "flatten",
                human,
                "a.svg",
                "--at",
                "99",
                "--profile",
                "still",
            ],
            "ends at",
        ),
        (2, vec!["flatten", human, "a.svg", "--clip", "fly"], "walk"),
        (1, vec!["flatten", "none.glb", "a.svg"], "none.glb"),
        (
            2,
            vec!["flatten", human, "a.html", "--views", "2"],
            "1, 3 or 5",
        ),
        (
            2,
            vec!["flatten", "frame", "a.svg", "a.gif"],
            ".png or .svg",
        ),
    ] {
        let line = fault(&here, status, &words);
        assert!(line.contains(expected), "{words:?}: {line}");
    }
    for (words, expected) in [
        (vec!["flatten"], "<FILE>"),
        (
            vec!["flatten", human, "a.svg", "--triangles", "100000"],
            "20000",
        ),
        (
            vec!["flatten", human, "a.svg", "--quality", "split=no"],
            "split: expected on or off",
        ),
        (
            vec!["flatten", human, "a.svg", "--profile", "flash"],
            "smil",
        ),
    ] {
        let ran = articula(&here, &words);
        assert_eq!(ran.status, 2, "{words:?}");
        assert!(ran.err.contains(expected), "{words:?}: {}", ran.err);
    }
    std::fs::write(here.join("other.svg"), "<svg><script>1</script></svg>").unwrap();
    let line = fault(&here, 1, &["flatten", "frame", "other.svg", "a.png"]);
    assert!(line.contains("other.svg"), "{line}");
    let help = articula(&here, &["flatten", "--help"]);
    assert!(help.out.contains("--turn-deg") && help.out.contains("frame"));
}
