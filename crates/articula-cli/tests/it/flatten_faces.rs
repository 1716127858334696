//! `flatten --motion`: parameters, captures and voices shown in 2D in one step.

use crate::program::{articula, fault, folder, json};
use serde_json::Value;
use std::path::Path;

/// A file of the repository.
fn asset(name: &str) -> String {
    format!("{}/../../assets/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// The jaw opens by half and closes in a second, the lower lip with it; the tongue, which the head does
/// not have, is raised.
fn talk(path: &Path) {
    let mask: Vec<&str> = (1..=68)
        .map(|fap| match fap {
            3 | 5 | 44 => "1",
            _ => "0",
        })
        .collect();
    let mut text = "2.1 talk 10 11\n".to_owned();
    for frame in 0..=10 {
        let open = 540 * (5 - i32::abs(frame - 5)) / 5;
        let (mask, lip) = (mask.join(" "), -open * 3 / 4);
        text.push_str(&format!("{mask}\n{frame} {open} {lip} {open}\n"));
    }
    std::fs::write(path, text).unwrap();
}

fn flatten(here: &Path, head: &str, out: &str, more: &[&str]) -> Value {
    let small = ["--triangles", "150", "--size", "96", "--fps", "10"];
    json(here, &[&["flatten", head, out], &small[..], more].concat())
}

#[test]
fn parameters_are_shown_as_by_a_conversion_before() {
    let here = folder("flatten-faces");
    talk(&here.join("talk.fap"));
    let head = asset("glb/ict_head_talk_554.glb");
    json(&here, &["convert", "talk.fap", "talk.glb", "--onto", &head]);
    for (direct, before, profile) in [
        ("a.svg", "b.svg", "smil"),
        ("c.svg", "d.svg", "player"),
        ("a.json", "b.json", "lottie"),
    ] {
        let profile = ["--profile", profile];
        let told = flatten(
            &here,
            &head,
            direct,
            &[&["--motion", "talk.fap"], &profile[..]].concat(),
        );
        assert_eq!(told["motion"]["name"], "talk");
        assert_eq!(told["motion"]["not_driven"][0]["fap"], 44);
        let warnings = told["warnings"].to_string();
        assert!(warnings.contains("FAP 44 raise_tongue_tip"), "{warnings}");
        flatten(&here, "talk.glb", before, &profile);
        let [direct, before] = [direct, before].map(|name| std::fs::read(here.join(name)).unwrap());
        assert!(direct == before, "{profile:?}: the files differ");
    }
    let told = json(
        &here,
        &[
            "flatten",
            &head,
            "a.html",
            "--triangles",
            "150",
            "--size",
            "96",
            "--motion",
            "talk.fap",
        ],
    );
    assert_eq!(
        (&told["profile"], &told["frames"]),
        (&"portrait".into(), &11.into())
    );
    assert!(
        told["motion"]["controls_moved"].as_u64().unwrap() >= 1,
        "{told}"
    );
}

#[test]
fn a_voice_moves_a_face_and_its_sound_is_told() {
    let here = folder("flatten-voice");
    let voice = asset("speech/librivox_austen_0880.wav");
    let head = asset("glb/ict_head_talk_554.glb");
    let spoken = ["--motion", &voice, "--profile", "still", "--at", "1"];
    let told = flatten(&here, &head, "a.svg", &spoken);
    assert!(
        told["motion"]["controls_moved"].as_u64().unwrap() >= 8,
        "{told}"
    );
    let warnings = told["warnings"].to_string();
    assert!(
        warnings.contains("has no sound; play it beside"),
        "{warnings}"
    );
    let page = [
        "flatten",
        &head,
        "a.html",
        "--triangles",
        "94",
        "--size",
        "64",
        "--views",
        "1",
        "--motion",
        &voice,
    ];
    let warnings = json(&here, &page)["warnings"].to_string();
    assert!(warnings.contains("--audio"), "{warnings}");
    let told = json(&here, &[&page[..], &["--audio", &voice]].concat());
    assert!(!told["warnings"].to_string().contains("sound"), "{told}");
}

#[test]
fn a_face_map_names_what_moves() {
    let here = folder("flatten-face-map");
    talk(&here.join("talk.fap"));
    let head = asset("glb/ict_head_talk_554.glb");
    let map = r#"{"name": "x", "controls": {"jawOpen": "mouthPucker"}}"#;
    std::fs::write(here.join("map.json"), map).unwrap();
    let motion = ["--motion", "talk.fap", "--profile", "still", "--at", "0.5"];
    flatten(&here, &head, "a.svg", &motion);
    flatten(
        &here,
        &head,
        "b.svg",
        &[&motion[..], &["--face-map", "map.json"]].concat(),
    );
    let read = |name: &str| std::fs::read(here.join(name)).unwrap();
    assert!(read("a.svg") != read("b.svg"));
}

#[test]
fn what_moves_no_face_is_refused() {
    let here = folder("flatten-faces-refused");
    talk(&here.join("talk.fap"));
    let head = asset("glb/ict_head_talk_554.glb");
    let line = fault(&here, 2, &["flatten", &head, "a.svg", "--motion", &head]);
    assert!(line.contains("no motion of a face; give a .fap"), "{line}");
    let line = fault(
        &here,
        1,
        &["flatten", &head, "a.svg", "--motion", "none.fap"],
    );
    assert!(line.contains("none.fap"), "{line}");
    let line = fault(
        &here,
        2,
        &["flatten", &head, "a.png", "--motion", "talk.fap"],
    );
    assert!(line.contains("--motion does not apply"), "{line}");
    let ran = articula(
        &here,
        &[
            "flatten", &head, "a.svg", "--motion", "talk.fap", "--clip", "talk",
        ],
    );
    assert!(ran.status == 2 && ran.err.contains("--clip"), "{}", ran.err);
}

#[test]
fn body_and_face_share_one_error() {
    let here = folder("lod-face");
    talk(&here.join("talk.fap"));
    json(&here, &["human", "h.glb", "--triangles", "2000"]);
    let lod = ["lod", "h.glb", "--clip", "walk", "--face", "talk.fap"];
    let fine = ["--parameter", "0.0005", "--distances", "2,60"];
    let told = json(&here, &[&lod[..], &fine].concat());
    let face = &told["face"];
    assert!(face["confidence"].as_f64().unwrap() > 0.5, "{face}");
    let number = |row: &Value, name: &str| row[name].as_f64().unwrap();
    let rows = face["rows"].as_array().unwrap();
    for (row, body) in rows.iter().zip(told["rows"].as_array().unwrap()) {
        let [body_px, face_px] = ["body_px", "face_px"].map(|name| number(row, name));
        let worst = body["face_px"]["worst_vertex"].as_f64().unwrap();
        assert!((body_px - worst).abs() < 1e-6, "{row}");
        assert!((number(row, "both_px") - body_px - face_px).abs() < 1e-5);
        assert_eq!(row["meets_target"], number(row, "both_px") <= 1.0);
    }
    // Near, the mouth moves; far away it does not matter.
    let kept = |row: &Value| row["parameters"].as_array().unwrap().len();
    assert!(kept(&rows[0]) > kept(&rows[1]), "{face}");
    let line = fault(
        &here,
        2,
        &[&lod[..], &["--method", "all", "--calibrate", "2"]].concat(),
    );
    assert!(line.contains("beside one method"), "{line}");
    let line = fault(&here, 2, &["lod", "h.glb", "--face", "h.glb"]);
    assert!(line.contains("expected a .fap"), "{line}");
}
