//! Digital items: `package`, `inspect ITEM/` and what other commands make of an item.

use crate::program::{articula, fault, folder, json, small, word};
use crate::real;

#[test]
fn a_character_is_packaged_inspected_and_assembled() {
    let Some(head) = real::file("glb/ict_head_talk_554.glb") else {
        return;
    };
    let Some(talk) = real::file("fap/speech_synthetic.fap") else {
        return;
    };
    let here = folder("item");
    std::fs::write(here.join("voice.wav"), b"RIFF").unwrap();
    // Part of its motions: a picture is drawn of each frame.
    let cut = ["convert", word(&head), "cut.glb", "--trim", "1..1.4"];
    json(&here, &cut);
    let head = here.join("cut.glb");
    let words = [
        "package",
        word(&head),
        "head",
        "--face",
        word(&talk),
        "--with",
        "voice.wav",
        "--levels",
        "2",
    ];
    let made = json(&here, &words);
    let manifest = &made["manifest"];
    let kinds: Vec<&str> = manifest["parts"]
        .as_array()
        .unwrap()
        .iter()
        .map(|p| p["kind"].as_str().unwrap())
        .collect();
    assert!(
        kinds.contains(&"mesh") && kinds.contains(&"face_motion"),
        "{kinds:?}"
    );
    assert_eq!(manifest["whole"][0]["mime"], "audio/wav");
    assert!(
        manifest["flat"].as_array().unwrap().len() == 2,
        "{}",
        manifest["flat"]
    );
    for entry in manifest["flat"].as_array().unwrap() {
        let svg = std::fs::read(here.join("head").join(entry["file"].as_str().unwrap())).unwrap();
        assert!(svg.starts_with(b"<svg"));
        assert_eq!(svg.len() as u64, entry["bytes"].as_u64().unwrap());
    }
    // A still is off by what the clip moves, so the animated form is preferred.
    let [moving, still] = [0, 1].map(|i| manifest["flat"][i]["error_px"].as_f64().unwrap());
    assert!(still > moving + 1.0, "{still}, {moving}");
    let found = json(&here, &["inspect", "head/"]);
    assert_eq!(found["manifest"], *manifest);
    assert_eq!(found["bytes"], made["bytes"]);
    let text = articula(&here, &["inspect", "head"]).out;
    for expected in ["voice.wav", "2d/still.svg", "face loa 3, tier 0"] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
    // The assembled head has the clips of body and face.
    let back = json(&here, &["convert", "head", "back.glb"]);
    assert_eq!(back["format_out"], "glb");
    let (before, after) = (
        json(&here, &["inspect", word(&head)]),
        json(&here, &["inspect", "back.glb"]),
    );
    assert_eq!(
        after["meshes"][0]["morph_targets"],
        before["meshes"][0]["morph_targets"]
    );
    assert_eq!(
        after["meshes"][0]["triangles"],
        before["meshes"][0]["triangles"]
    );
    let clips = after["clips"].as_array().unwrap();
    assert_eq!(clips.len(), before["clips"].as_array().unwrap().len() + 1);
    // The figure alone is a valid file without a surface.
    let figure = json(&here, &["inspect", "head/figure.glb"]);
    // One vertex keeps each material.
    assert_eq!(figure["meshes"][0]["vertices"], before["materials"]);
    assert_eq!(
        figure["skeletons"][0]["joints"],
        before["skeletons"][0]["joints"]
    );
}

#[test]
fn mistakes_are_one_line() {
    let here = folder("item-mistakes");
    let human = word(small());
    let why = fault(&here, 2, &["package", human, "item", "--clip", "fly"]);
    assert!(why.contains("there is no clip \"fly\""), "{why}");
    let why = fault(&here, 2, &["package", human, "item", "--face", human]);
    assert!(why.contains("--face") && why.contains(".fap"), "{why}");
    std::fs::write(here.join("file"), b"x").unwrap();
    let why = fault(&here, 2, &["package", human, "file"]);
    assert!(why.contains("name a folder"), "{why}");
    std::fs::create_dir_all(here.join("old")).unwrap();
    std::fs::write(here.join("old/manifest.json"), b"{}").unwrap();
    let why = fault(&here, 1, &["package", human, "old"]);
    assert!(
        why.contains("manifest.json") && why.contains("--force"),
        "{why}"
    );
    let why = fault(&here, 1, &["inspect", "old"]);
    assert!(why.contains("old: manifest.json: missing field"), "{why}");
    let why = fault(&here, 1, &["convert", "old", "x.glb"]);
    assert!(why.contains("old: manifest.json"), "{why}");
    assert!(!here.join("item").exists() && !here.join("x.glb").exists());
}
