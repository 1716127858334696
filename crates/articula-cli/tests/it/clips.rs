//! Cleaning of clips on real motions.

use crate::program;
use crate::program::{BVH, fault, folder, json, word};
use crate::real;
use articula::build::Asset;
use articula::build::ClipOptions;
use articula::build::clip_edit::EditSubject;
use articula::build::clip_edit::{ReduceOptions, Timelines, reduce_keys, trim};
use articula::core::PosedMesh;
use articula::core::source::{Character, RawClip, evaluate};
use articula::formats::{Limits, bvh, gltf, joint_map};
use glam::Vec3;
use serde_json::Value;

fn read(name: &str) -> Option<(Character, Vec<(usize, Vec3)>)> {
    let bytes = real::bytes(name)?;
    let limits = Limits::default();
    if name.ends_with(".bvh") {
        let file = bvh::read(&bytes, &articula::formats::ReadOptions::default(), &limits)
            .unwrap()
            .value;
        return Some((file.character, file.end_sites));
    }
    let mut alone = |uri: &str| Err(format!("{uri} is not needed"));
    let file = gltf::read(&bytes, &limits, &mut alone).unwrap().value;
    Some((file.character, Vec::new()))
}

/// Positions of every joint and every vertex (without morph targets) of a clip.
fn shown(figure: &Asset, character: &Character, clip: &RawClip, secs: f32) -> Vec<Vec3> {
    let mut pose = figure.rig.rest_pose().clone();
    evaluate::pose(clip, &character.skeleton, secs, &mut pose);
    let every: Vec<u32> = (0..figure.mesh.len() as u32).collect();
    let mut skin = vec![Vec3::ZERO; every.len()];
    let mut posed = PosedMesh::new(&figure.rig, &figure.mesh);
    posed.pose(&pose).points(&every, &mut skin);
    let joints = (0..figure.rig.len()).map(|j| posed.model.position(j));
    joints.chain(skin).collect()
}

/// File, clip, its seconds of which the start is used, and the minimum factor by which its bytes
/// shrink at 1 mm and at 1 cm.
const REDUCED: [(&str, &str, f32, f32, f32); 6] = [
    ("glb/mh_female_dance.glb", "dance", 2.0, 2.0, 5.0),
    ("bvh/cmu_12_01_walk.bvh", "motion", WHOLE, 2.0, 12.0),
    ("bvh/fair1_dab.bvh", "motion", WHOLE, 1.2, 1.9),
    ("glb/KayKit_Knight.glb", "1H_Ranged_Aiming", WHOLE, 2.0, 3.0),
    ("glb/pab_arnaud.glb", "atlas", 5.0, 2.5, 6.0),
    (
        "glb/Quaternius_cyberpunk_pack__Character.glb",
        "CharacterArmature|Idle_Gun_Pointing",
        WHOLE,
        2.5,
        7.0,
    ),
];

/// More than any clip lasts.
const WHOLE: f32 = f32::MAX;

#[test]
fn fewer_keys_move_no_vertex_of_real_figures_farther_than_the_bound() {
    for (name, clip, most_secs, at_1_mm, at_1_cm) in REDUCED {
        let Some((character, ends)) = read(name) else {
            continue;
        };
        let clip = character.clips.iter().find(|c| c.name == clip).unwrap();
        let clip = &trim(clip, 0.0..=clip.duration_secs.min(most_secs)).unwrap();
        let mapping =
            articula::build::joint_names::map(&character.skeleton, joint_map::builtin(), None);
        let subject = EditSubject::new(&character, mapping.articulation.clone(), &ends).unwrap();
        let posed = articula::build::character(
            &Character {
                clips: Vec::new(),
                ..character.clone()
            },
            Some(mapping.articulation),
            &ClipOptions::default(),
        );
        let posed = posed.unwrap();
        for (bound_metres, factor) in [(1e-3, at_1_mm), (1e-2, at_1_cm)] {
            let opts = ReduceOptions {
                bound_metres,
                drop_rest: true,
                timelines: Timelines::Own,
            };
            let out = reduce_keys(&subject, clip, &opts).unwrap();
            let (before, after) = (out.before, out.after);
            println!(
                "{name} \"{}\" at {bound_metres} m: {} -> {} keys, {} -> {} bytes, worst {:.6} m",
                clip.name, before.keys, after.keys, before.bytes, after.bytes, out.worst_metres
            );
            assert!(out.worst_metres <= bound_metres);
            let shrunk = before.bytes as f32 / after.bytes as f32;
            assert!(shrunk >= factor, "{name}: {shrunk} times smaller");
            // Times that are on no grid of the reduction.
            for i in 0..12 {
                let secs = clip.duration_secs * (i as f32 + 0.37) / 12.0;
                let [a, b] = [clip, &out.clip].map(|c| shown(&posed, &character, c, secs));
                let apart = a.iter().zip(&b).map(|(p, q)| p.distance(*q));
                let apart = apart.fold(0.0, f32::max);
                assert!(
                    apart <= 1.01 * bound_metres,
                    "{name} at {secs} s: {apart} m"
                );
            }
        }
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

#[test]
fn the_loop_of_a_captured_walk_is_its_gait_cycle() {
    let Some(walk) = real::file("bvh/cmu_12_01_walk.bvh") else {
        return;
    };
    let here = folder("gait");
    let report = json(&here, &["convert", word(&walk), "o.glb", "--loop"]);
    let looped = &report["edits"][0]["loop"];
    assert_eq!(looped["is_loop"], true);
    // Both feet of CMU 12_01 come down every 1.27 to 1.3 s (seen on its sheet).
    let period = number(&looped["part"]["period_secs"]);
    assert!((1.2..1.4).contains(&period), "{looped}");
    assert!(number(&looped["part"]["seam_m"]) < 0.04, "{looped}");
    assert!(number(&looped["closed"]["seam_deg"]) < 1e-3, "{looped}");
    assert!(number(&looped["closed"]["moved_m"]) < 0.03, "{looped}");
    assert!(
        (1.0..1.4).contains(&number(&looped["closed"]["travel_m"])),
        "{looped}"
    );
    // The written clip is a loop already.
    let again = json(&here, &["convert", "o.glb", "p.glb", "--loop"]);
    assert_eq!(again["edits"][0]["loop"]["is_whole"], true, "{again}");
}

#[test]
fn made_loops_are_known_and_deeds_are_none() {
    let here = folder("loops");
    for (name, loops, none) in [
        (
            "glb/pab_arnaud.glb",
            &["walk", "jog", "run"][..],
            &["atlas"][..],
        ),
        (
            "glb/KayKit_Knight.glb",
            &["Idle", "Walking_A", "Running_A", "Sit_Floor_Idle"],
            &["Death_A", "Lie_Down", "Dodge_Left", "T-Pose"],
        ),
        ("bvh/fair1_dab.bvh", &[], &["motion"]),
    ] {
        let Some(path) = real::file(name) else {
            continue;
        };
        let report = json(&here, &["convert", word(&path), "o.glb", "--loop"]);
        let edits = report["edits"].as_array().unwrap();
        let looped = |clip: &str| &edits.iter().find(|e| e["clip"] == clip).unwrap()["loop"];
        for clip in loops {
            let found = looped(clip);
            assert_eq!(found["is_whole"], true, "{name} {clip}: {found}");
            assert!(
                number(&found["closed"]["moved_m"]) < 0.006,
                "{name} {clip}: {found}"
            );
        }
        for clip in none {
            let found = looped(clip);
            assert_eq!(found["is_loop"], false, "{name} {clip}: {found}");
            assert!(found["closed"].is_null());
        }
    }
}

#[test]
fn root_motion_goes_to_the_joint_above_the_hips() {
    let here = folder("root-motion");
    for (name, carrier, chosen) in [
        // One of 76 clips.
        (
            "glb/KayKit_Knight.glb",
            Some("root"),
            &["--clip", "Dodge_Left"][..],
        ),
        // Below an armature of scale 100.
        (
            "glb/Quaternius_cyberpunk_pack__Character.glb",
            Some("Root"),
            &[],
        ),
        ("glb/mannequiny.glb", Some("root.001"), &[]),
        ("glb/RobotExpressive.glb", Some("Bone"), &[]),
        // A somersault.
        ("glb/viverse/jump-forward.glb", Some("root"), &[]),
        ("glb/pab_arnaud.glb", None, &[]),
        ("bvh/cmu_12_01_walk.bvh", None, &[]),
    ] {
        let Some(file) = real::file(name) else {
            continue;
        };
        let report = |mode| {
            let words = ["convert", word(&file), "o.glb", "--root-motion", mode];
            json(&here, &[&words, chosen].concat())
        };
        let extracted = report("extract");
        let in_place = report("in-place");
        for (edits, mode) in [(&extracted, "extract"), (&in_place, "in-place")] {
            for edit in edits["edits"].as_array().unwrap() {
                let root = &edit["root_motion"];
                assert_eq!(root["carrier"].as_str(), carrier, "{name} {mode}");
                let worst = number(&root["worst_m"]);
                assert!(worst < 2e-4, "{name} {mode} {}: {worst} m", edit["clip"]);
            }
        }
        let left = json(
            &here,
            &["convert", "o.glb", "p.glb", "--root-motion", "keep"],
        );
        for edit in left["edits"].as_array().unwrap() {
            let travel = number(&edit["root_motion"]["path_m"]);
            assert!(
                travel < 0.03,
                "{name} {}: {travel} m are left",
                edit["clip"]
            );
        }
    }
}

#[test]
fn edits_come_in_one_order_and_say_what_they_did() {
    let here = folder("edits");
    std::fs::write(here.join("a.bvh"), BVH).unwrap();
    let words = |flags: &[&'static str]| {
        [
            &["convert", "a.bvh", "o.glb", "--read", "unit-metres=0.01"],
            flags,
        ]
        .concat()
    };
    let report = json(
        &here,
        &words(&[
            "--reduce-keys",
            "5mm",
            "--rate",
            "60",
            "--trim",
            "..0.06",
            "--root-motion",
            "in-place",
        ]),
    );
    let edit = &report["edits"][0];
    assert!((number(&edit["trim"]["duration_secs"]) - 0.06).abs() < 1e-6);
    assert_eq!(edit["rate"]["rate_hz"], 60.0);
    // A centimetre per frame at 30 frames per second.
    assert!((number(&edit["root_motion"]["travel_m"]) - 0.018).abs() < 1e-4);
    let keys = &edit["reduce_keys"];
    assert_eq!(edit["rate"]["keys_after"], keys["keys_before"]);
    assert!(
        number(&keys["worst_m"]) <= 0.005
            && number(&keys["keys_after"]) < number(&keys["keys_before"])
    );
    assert!(edit["loop"].is_null());
    let clip = json(&here, &["inspect", "o.glb"]);
    assert!(
        (number(&clip["clips"][0]["duration_secs"]) - 0.06).abs() < 1e-5,
        "the length stays"
    );
    let line = fault(&here, 1, &words(&["--trim", "0..9", "--force"]));
    assert!(line.contains("is not an interval within"));
    for bad in [
        &["--trim", "2..1"][..],
        &["--rate", "0"],
        &["--reduce-keys", "1km"],
        &["--root-motion", "away"],
        &["--reduce-keys", "1mm,rest"],
        &["--root-motion", "keep:0"],
        &["--loop=0"],
    ] {
        let ran = program::articula(&here, &words(bad));
        assert_eq!(ran.status, 2, "{bad:?}: {}", ran.err);
    }
    let why = fault(
        &here,
        2,
        &["convert", "a.bvh", "o.bvh", "--reduce-keys", "1mm"],
    );
    assert!(why.contains("every joint in every frame"), "{why}");
}
