//! Streams of bones and of facial animation parameters: `convert` and `inspect`.

use crate::program::{fault, folder, json, word};
use crate::real;
use serde_json::Value;

/// Sum of a field of rows.
fn sum(rows: &Value, field: &str) -> f64 {
    let rows = rows.as_array().unwrap();
    rows.iter().map(|row| row[field].as_f64().unwrap()).sum()
}

/// Every bit belongs to a level and a region, or to what all have in common.
fn check_shares(found: &Value) {
    let stream = &found["stream"];
    let bytes = found["bytes"].as_f64().unwrap();
    let common = stream["bytes_common"].as_f64().unwrap();
    for shares in ["loa", "regions"] {
        assert_eq!(sum(&stream[shares], "bytes") + common, bytes, "{stream}");
    }
    assert_eq!(
        sum(&stream["loa"], "items"),
        sum(&stream["regions"], "items")
    );
}

#[test]
fn a_motion_goes_through_abp1_and_its_text() {
    let Some(walk) = real::file("bvh/cmu_12_01_walk.bvh") else {
        return;
    };
    let here = folder("abp1");
    let written = json(&here, &["convert", word(&walk), "walk.abp", "--abp1"]);
    assert_eq!(written["format_out"], "abp");
    let found = json(&here, &["inspect", "walk.abp"]);
    assert_eq!(found["articulation_stored"], true);
    let stream = &found["stream"];
    // 524 frames, 16 in each.
    assert_eq!(
        (&stream["profile"], &stream["access_units"]),
        (&"ABP-1".into(), &33.into())
    );
    check_shares(&found);
    json(&here, &["convert", "walk.abp", "walk.abpt"]);
    let text = json(&here, &["inspect", "walk.abpt"]);
    let back = json(&here, &["convert", "walk.abpt", "walk.glb"]);
    assert_eq!(back["format_in"], "abpt");
    let glb = json(&here, &["inspect", "walk.glb"]);
    for other in [&text, &glb] {
        assert_eq!(other["clips"][0]["frames"], found["clips"][0]["frames"]);
        assert_eq!(other["stream"], Value::Null);
    }
    let why = fault(&here, 2, &["convert", word(&walk), "other.abp"]);
    assert!(why.contains("--abp1"), "{why}");
    let why = fault(&here, 2, &["convert", word(&walk), "other.glb", "--abp1"]);
    assert!(why.contains("requires an .abp output"), "{why}");
}

#[test]
fn a_face_clip_goes_through_afp1() {
    let Some(talk) = real::file("fap/speech_synthetic.fap") else {
        return;
    };
    let here = folder("afp1");
    let talk = word(&talk);
    json(&here, &["convert", talk, "talk.afp"]);
    let found = json(&here, &["inspect", "talk.afp"]);
    assert_eq!(found["stream"]["profile"], "AFP-1");
    check_shares(&found);
    json(
        &here,
        &["convert", "talk.afp", "low.afp", "--face-level", "low"],
    );
    let low = json(&here, &["inspect", "low.afp"]);
    check_shares(&low);
    // Of the jaw, which alone moves, eleven parameters are left of 31.
    assert_eq!(sum(&found["stream"]["loa"], "items"), 31.0);
    assert_eq!(sum(&low["stream"]["loa"], "items"), 11.0);
    json(&here, &["convert", "talk.afp", "back.fap"]);
    let [before, after] = [talk, "back.fap"].map(|file| json(&here, &["inspect", file]));
    assert_eq!(before["clips"][0]["frames"], after["clips"][0]["frames"]);
    json(&here, &["convert", "talk.afp", "shapes.csv"]);
    json(&here, &["convert", "shapes.csv", "shapes.afp"]);
}
