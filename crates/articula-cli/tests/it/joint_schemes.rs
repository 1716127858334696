//! `convert --joint-scheme`: what the report says, and what files hold afterwards.

use crate::program::{articula, fault, folder, human, json, word};
use crate::real;

#[test]
fn the_reference_human_goes_to_the_scheme_of_the_thesis_and_back() {
    let here = folder("schemes");
    let human = word(human());
    let report = json(
        &here,
        &["convert", human, "t.glb", "--joint-scheme", "thesis"],
    );
    let changed = &report["joint_scheme"];
    assert_eq!(
        (&changed["scheme"], &changed["joints"]),
        (&"thesis".into(), &89.into())
    );
    let merged = serde_json::json!([
        {"joint": "l_subtalar", "into": "l_ankle"},
        {"joint": "r_subtalar", "into": "r_ankle"},
    ]);
    let inserted = serde_json::json!([
        {"joint": "l_thumb0", "parent": "l_wrist", "child": "l_thumb1"},
        {"joint": "r_thumb0", "parent": "r_wrist", "child": "r_thumb1"},
    ]);
    assert_eq!(
        (&changed["merged"], &changed["inserted"]),
        (&merged, &inserted)
    );
    assert!(changed["joints_m"].as_f64().unwrap() < 1e-5);
    let found = json(&here, &["inspect", "t.glb"]);
    let skeleton = &found["skeletons"][0];
    assert_eq!(
        (&skeleton["regions"]["feet"], &skeleton["regions"]["hands"]),
        (&4.into(), &40.into())
    );
    let reduced = json(
        &here,
        &["convert", "t.glb", "u.glb", "--loa", "zone(UpperBody)"],
    );
    assert_eq!(reduced["reduction"]["joints_active"], 77);
    let words = [
        "convert",
        "t.glb",
        "walk.abp",
        "--clip",
        "walk",
        "--stream",
        "group-by=region",
    ];
    json(&here, &words);
    let stream = json(&here, &["inspect", "walk.abp"]);
    assert_eq!(stream["joints"], 89, "{stream}");
    let groups = stream["groups"].as_array().unwrap();
    let is_base = |group: &&serde_json::Value| group["region"] == "hands" && group["loa"] == 5;
    assert!(groups.iter().any(|group| is_base(&group)), "{stream}");
    let ran = articula(
        &here,
        &["convert", "t.glb", "h.bvh", "--joint-scheme", "hanim"],
    );
    for line in [
        "l_thumb0 merged into l_thumb1",
        "r_subtalar inserted between r_ankle and r_midtarsal",
    ] {
        assert!(ran.out.contains(line), "{}", ran.out);
    }
    let found = json(&here, &["inspect", "h.bvh"]);
    assert_eq!(found["skeletons"][0]["regions"]["feet"], 6);
}

#[test]
fn a_motion_with_thumbs_gets_thumb_bases_and_keeps_them() {
    let Some(dance) = real::file("bvh/dance_fingers.bvh") else {
        return;
    };
    let here = folder("schemes_dance");
    let report = json(
        &here,
        &["convert", word(&dance), "d.bvh", "--joint-scheme", "thesis"],
    );
    let changed = &report["joint_scheme"];
    assert_eq!(changed["inserted"].as_array().unwrap().len(), 2);
    assert_eq!(changed["merged"].as_array().unwrap().len(), 0);
    let found = json(&here, &["inspect", "d.bvh", "--map"]);
    let map = found["map"].as_array().unwrap();
    let base = map.iter().find(|j| j["hanim"] == "l_thumb0").unwrap();
    assert_eq!(
        (&base["region"], &base["level"]),
        (&"hands".into(), &5.into())
    );
    let again = json(
        &here,
        &["convert", "d.bvh", "e.bvh", "--joint-scheme", "thesis"],
    );
    assert_eq!(again["joint_scheme"]["inserted"], serde_json::json!([]));
}

#[test]
fn a_face_clip_has_no_joint_scheme() {
    let here = folder("schemes_face");
    std::fs::write(here.join("a.fap"), "x").unwrap();
    let told = fault(
        &here,
        2,
        &["convert", "a.fap", "b.fap", "--joint-scheme", "thesis"],
    );
    assert!(told.contains("do not apply to a face clip"), "{told}");
    let ran = articula(
        &here,
        &["convert", "a.bvh", "b.bvh", "--joint-scheme", "mpeg"],
    );
    assert_eq!(ran.status, 2);
    assert!(ran.err.contains("hanim, thesis"), "{}", ran.err);
}
