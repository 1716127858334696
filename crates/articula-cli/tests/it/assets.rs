//! Assets on the command line: what is stored is played, and what does not belong is told.

use crate::program::{articula, fault, folder, json, short, word};
use crate::real::file;
use serde_json::Value;
use std::path::Path;

/// Fields that are times.
const TIMES: &[&str] = &[
    "first_frame_ms",
    "ready_ms",
    "ns_per_character",
    "characters_per_ms",
    "frame_ms",
    "wall_ms",
    "tick_ms",
];

/// A report without its times.
fn timeless(mut report: Value) -> Value {
    let fields = report.as_object_mut().unwrap();
    for time in TIMES {
        fields.remove(*time);
    }
    if let Some(frame) = fields.get_mut("frame").and_then(Value::as_object_mut) {
        frame.remove("ms");
    }
    report
}

/// Builds an asset of a file, cut first, and compares what commands say of both.
fn same_reports(name: &str, source: &Path, cut: &[&str], runs: &[&[&str]]) {
    let folders = ["source", "asset"].map(|of| folder(&format!("same-{name}-{of}")));
    // The name of the file is in the reports.
    json(
        &folders[0],
        &[&["convert", word(source), "a.glb"], cut].concat(),
    );
    let asset = folders[1].join("a.glb");
    let built = json(
        &folders[0],
        &[
            "build",
            "a.glb",
            word(&asset),
            "--levels",
            "5",
            "--compact-clips",
        ],
    );
    let parts = built["parts"].as_array().unwrap();
    assert!(
        parts.iter().all(|p| p["bytes"].as_u64() > Some(0)),
        "{parts:?}"
    );
    for words in runs {
        let [fresh, stored] = [&folders[0], &folders[1]].map(|at| timeless(json(at, words)));
        assert!(fresh == stored, "{name} {words:?}:\n{fresh}\n{stored}");
    }
}

const CROWD: &[&str] = &["crowd", "a.glb", "--count", "60", "--seconds", "0.1"];

#[test]
fn the_reference_human_plays_the_same_from_its_asset() {
    let with = |more: &[&'static str]| [CROWD, more].concat();
    let runs = [
        with(&["--mesh-levels", "1"]),
        with(&["--mesh-levels", "5"]),
        with(&["--level", "full"]),
        with(&["--level", "loa(Low)"]),
        with(&[
            "--clip",
            "walk",
            "--seed",
            "3",
            "--root-motion",
            "--mesh-levels",
            "1",
        ]),
        vec!["lod", "a.glb", "--method", "all", "--distances", "4,12"],
        vec![
            "lod",
            "a.glb",
            "--clip",
            "wave",
            "--method",
            "skin-px-tables",
            "--distances",
            "9",
        ],
    ];
    let runs: Vec<&[&str]> = runs.iter().map(Vec::as_slice).collect();
    same_reports("human", short(), &[], &runs);
}

#[test]
fn six_characters_play_the_same_from_their_assets() {
    // Part of the motions: the tables of a frame do not depend on those of others.
    let start: &[&str] = &["--trim", "..0.4"];
    let characters = [
        ("glb/CesiumMan.glb", start),
        ("glb/RiggedFigure.glb", &[]),
        ("glb/Fox.glb", start),
        ("glb/pab_arnaud.glb", &["--clip", "jog", "--trim", "..0.4"]),
        (
            "glb/Quaternius_single_knight_pack__KnightCharacter.glb",
            &["--clip", "HumanArmature|Run"],
        ),
        (
            "glb/Quaternius_platformer_game_pack__Character.glb",
            &["--clip", "CharacterArmature|Walk"],
        ),
    ];
    for (name, cut) in characters {
        let Some(path) = file(name) else { continue };
        let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
        let lod: &[&str] = &["lod", "a.glb", "--method", "thesis", "--distances", "9"];
        let crowd = [CROWD, &["--mesh-levels", "1"]].concat();
        same_reports(&stem, &path, cut, &[&crowd, lod]);
    }
}

#[test]
fn an_asset_has_the_levels_of_crowds_unless_others_are_asked_for() {
    let here = folder("usual-levels");
    let built = |words: &[&str]| json(&here, &[&["build"], words].concat());
    let count = |report: &Value| report["levels"].as_array().unwrap().len();
    let usual = built(&[word(short()), "usual.glb"]);
    assert!(count(&usual) > 6, "{}", usual["levels"]);
    let none = built(&[word(short()), "none.glb", "--levels", "1"]);
    assert_eq!(count(&none), 0);
    // A file keeps its levels.
    let again = built(&["usual.glb", "again.glb"]);
    assert_eq!(count(&again), 0, "no others are made");
    let crowd = |file: &str| {
        let words = ["crowd", file, "--count", "400", "--seconds", "0.1"];
        let report = json(&here, &words);
        let warned = report["warnings"].to_string().contains("all triangles");
        (report["frame"]["triangles"].as_f64().unwrap(), warned)
    };
    let (plain, asset) = (crowd(word(short())), crowd("usual.glb"));
    assert_eq!(asset, crowd("again.glb"));
    assert_eq!(plain, asset, "as of the file itself");
    let (triangles, warned) = crowd("none.glb");
    assert!(triangles > 1.5 * asset.0 && warned, "{triangles}");
    let alone = ["build", "none.glb", "x.glb", "--levels", "1", "--free-face"];
    let why = fault(&here, 2, &alone);
    assert!(why.contains("--free-face needs mesh levels"), "{why}");
}

#[test]
fn clips_are_stored_as_motion_streams_beside_their_keys() {
    let here = folder("compact");
    let words = ["build", word(short()), "a.glb", "--compact-clips=0.5"];
    let built = json(&here, &words);
    for clip in built["clips"].as_array().unwrap() {
        let compact = &clip["compact"];
        let number = |name: &str| compact[name].as_f64().unwrap();
        assert!(
            number("error_mm") <= 0.5 && number("decode_ms") > 0.0,
            "{clip}"
        );
        assert!(number("bytes") < 0.2 * number("keys_bytes"), "{clip}");
    }
    let found = json(&here, &["build", "--check", "a.glb"]);
    let parts = found["parts"].as_array().unwrap();
    let compact = parts.iter().find(|p| p["part"] == "compact-clips").unwrap();
    assert_eq!(compact["state"], "current");
    let inspected = json(&here, &["inspect", "a.glb"]);
    for (made, stored) in built["clips"]
        .as_array()
        .unwrap()
        .iter()
        .zip(inspected["clips"].as_array().unwrap())
    {
        // A head of 32 bytes comes before the stream.
        let expected = made["compact"]["bytes"].as_u64().unwrap() + 32;
        assert_eq!(stored["motion_tables"]["compact"], expected);
    }
    json(&here, &["build", word(short()), "plain.glb"]);
    let found = json(&here, &["build", "--check", "plain.glb"]);
    let parts = found["parts"].as_array().unwrap();
    let compact = parts.iter().find(|p| p["part"] == "compact-clips").unwrap();
    assert_eq!(compact["state"], "not-needed");
}

#[test]
fn a_check_says_what_is_missing_or_stale() {
    let here = folder("check");
    let build = |words: &[&str]| articula(&here, &[&["build", word(short())], words].concat());
    assert_eq!(build(&["whole.glb", "--levels", "3"]).status, 0);
    let found = json(&here, &["build", "--check", "whole.glb"]);
    assert_eq!(found["is_whole"], true, "{found}");
    assert_eq!(found["warnings"], Value::Array(Vec::new()));

    let out = [
        "part.glb",
        "--levels",
        "1",
        "--without",
        "pose-cache,contacts",
    ];
    assert_eq!(build(&out).status, 0);
    let ran = articula(&here, &["build", "--check", "part.glb", "--json"]);
    assert_eq!(ran.status, 1);
    assert!(ran.err.contains("is not whole"), "{}", ran.err);
    let found: Value = serde_json::from_str(&ran.out).unwrap();
    let state = |name: &str| {
        let mut parts = found["parts"].as_array().unwrap().iter();
        parts.find(|p| p["part"] == name).unwrap()["state"].clone()
    };
    assert_eq!(state("pose-cache"), "missing");
    assert_eq!(state("contacts"), "missing");
    assert_eq!(state("paired-levels"), "not-needed");
    assert_eq!(state("clips"), "current");

    // One byte in the middle of the last part.
    let mut glb = std::fs::read(here.join("whole.glb")).unwrap();
    let at = glb.len() - 40;
    glb[at] ^= 0x10;
    std::fs::write(here.join("whole.glb"), glb).unwrap();
    let ran = articula(&here, &["build", "--check", "whole.glb"]);
    assert_eq!(ran.status, 1);
    assert!(ran.out.contains("stale"), "{}", ran.out);
    assert!(ran.out.contains("have changed"), "{}", ran.out);

    let why = fault(&here, 1, &["build", "--check", "nothing.glb"]);
    assert!(why.contains("nothing.glb"), "{why}");
    let why = fault(&here, 2, &["build", "--check", "a.glb", "b.glb"]);
    assert!(why.contains("one file"), "{why}");
    let why = fault(&here, 2, &["build", "a.glb"]);
    assert!(why.contains("OUT.glb"), "{why}");
    let ran = articula(
        &here,
        &["build", "a.glb", "b.glb", "--without", "everything"],
    );
    assert_eq!(ran.status, 2);
    assert!(ran.err.contains("joint-levels"), "{}", ran.err);
}
