//! Converted files read back the same, and a reduced animation is smaller by the reported amount.

use crate::program::{BVH, articula, folder, human, json, word};
use serde_json::Value;

fn inspected(here: &std::path::Path, name: &str) -> Value {
    json(here, &["inspect", name])
}

#[test]
fn bvh_through_glb_keeps_joints_frames_and_motion() {
    let here = folder("round");
    std::fs::write(here.join("a.bvh"), BVH).unwrap();
    let first = inspected(&here, "a.bvh");
    json(&here, &["convert", "a.bvh", "b.glb"]);
    json(&here, &["convert", "b.glb", "c.bvh"]);
    for name in ["b.glb", "c.bvh"] {
        let other = inspected(&here, name);
        assert_eq!(other["skeletons"][0]["joints"], 5, "{name}");
        for field in ["frames", "joints_animated"] {
            assert_eq!(
                other["clips"][0][field], first["clips"][0][field],
                "{name} {field}"
            );
        }
        for (axis, corner) in [(1, "max_m"), (0, "max_m"), (2, "max_m")] {
            let of = |v: &Value| v["clips"][0]["bounds"][corner][axis].as_f64().unwrap();
            // Six decimals of a degree over a metre of arm are far below a millimetre.
            assert!(
                (of(&other) - of(&first)).abs() < 1e-3,
                "{name} {corner}[{axis}]"
            );
        }
    }
}

#[test]
fn what_is_not_understood_passes_through() {
    let here = folder("through");
    let text = "{\"asset\":{\"version\":\"2.0\",\"extras\":{\"note\":\"kept\"}},\"extensionsUsed\":[\"X_unknown\"],\
        \"extensions\":{\"X_unknown\":{\"a\":[1,2]}},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\
        \"nodes\":[{\"name\":\"n\",\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\
        \"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,0]}],\
        \"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"buffers\":[{\"byteLength\":36,\"uri\":\"a.bin\"}]}";
    let corners: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let bytes: Vec<u8> = corners.iter().flat_map(|v| v.to_le_bytes()).collect();
    std::fs::write(here.join("a.bin"), bytes).unwrap();
    std::fs::write(here.join("a.gltf"), text).unwrap();
    json(&here, &["convert", "a.gltf", "b.glb"]);
    let glb = std::fs::read(here.join("b.glb")).unwrap();
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let document: Value = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    assert_eq!(document["extensions"]["X_unknown"]["a"][1], 2);
    assert_eq!(document["asset"]["extras"]["note"], "kept");
    assert_eq!(inspected(&here, "b.glb")["meshes"][0]["triangles"], 1);
}

#[test]
fn a_lower_level_saves_more_and_never_touches_the_rest() {
    let here = folder("levels");
    let human = word(human());
    let before = inspected(&here, human);
    let mut last = -1.0;
    for level in ["VeryHigh", "High", "Medium", "Low", "VeryLow", "None"] {
        let expression = format!("loa({level})");
        let report = json(&here, &["convert", human, "o.glb", "--loa", &expression]);
        let reduction = &report["reduction"];
        let saved = reduction["saved"].as_f64().unwrap();
        assert!(saved >= last, "{level}: {saved} after {last}");
        last = saved;
        let after = inspected(&here, "o.glb");
        let moving = after["clips"][1]["joints_animated"].as_u64().unwrap();
        let active = reduction["joints_active"].as_u64().unwrap();
        assert!(
            moving <= active + 1,
            "{level}: {moving} joints move, the root and {active} may"
        );
        for field in ["meshes", "height_m", "skeletons"] {
            assert_eq!(after[field], before[field], "{level} {field}");
        }
        let (keys, found) = (&reduction["after"]["keys"], &after["clips"]);
        let total: u64 = found
            .as_array()
            .unwrap()
            .iter()
            .map(|c| c["keys"].as_u64().unwrap())
            .sum();
        assert_eq!(
            keys.as_u64().unwrap(),
            total,
            "{level}: keys are those of the file"
        );
    }
    assert!(
        last > 0.9,
        "without any joint only the root is left: {last}"
    );
}

#[test]
fn every_policy_writes_a_file_that_is_read_again() {
    let here = folder("policies");
    let human = word(human());
    for policy in ["hold", "rest", "key-pose", "blend-to-rest:0.3"] {
        let words = [
            "convert",
            human,
            "o.glb",
            "--loa",
            "loa(Low) + zone(hands)",
            "--passive",
            policy,
        ];
        assert_eq!(json(&here, &words)["reduction"]["passive"], policy);
        let after = inspected(&here, "o.glb");
        assert_eq!(after["clips"].as_array().unwrap().len(), 3, "{policy}");
        let secs = after["clips"][1]["duration_secs"].as_f64().unwrap();
        assert!((secs - 1.0667).abs() < 0.01, "{policy}: {secs}");
    }
}

#[test]
fn a_saved_selection_does_what_its_expression_does() {
    let here = folder("selection");
    let human = word(human());
    let profile = "{\"complexity\":\"Low\",\"zones\":[\"hands\"]}";
    std::fs::write(here.join("l.json"), profile).unwrap();
    let by_file = json(
        &here,
        &["convert", human, "a.glb", "--loa-profile", "l.json"],
    );
    let words = ["convert", human, "b.glb", "--loa", "loa(Low) + zone(hands)"];
    let by_words = json(&here, &words);
    assert_eq!(
        by_file["reduction"]["after"],
        by_words["reduction"]["after"]
    );
    let same = |name: &str| std::fs::read(here.join(name)).unwrap();
    assert_eq!(same("a.glb"), same("b.glb"));
}

#[test]
fn one_clip_can_be_kept_alone() {
    let here = folder("alone");
    json(
        &here,
        &["convert", word(human()), "o.glb", "--clip", "wave"],
    );
    let clips = &inspected(&here, "o.glb")["clips"];
    assert_eq!(clips.as_array().unwrap().len(), 1);
    assert_eq!(clips[0]["name"], "wave");
    let ran = articula(&here, &["convert", "o.glb", "o.bvh"]);
    assert!(ran.out.contains("left out: 4 meshes"), "{}", ran.out);
}

#[test]
fn the_unit_of_a_bvh_file_can_be_given() {
    let here = folder("unit");
    std::fs::write(here.join("a.bvh"), BVH).unwrap();
    let height = |unit: &str| {
        let unit = format!("unit-metres={unit}");
        let found = json(&here, &["inspect", "a.bvh", "--read", &unit]);
        found["height_m"].as_f64().unwrap()
    };
    assert!((height("0.02") / height("0.01") - 2.0).abs() < 1e-5);
    let told = json(&here, &["inspect", "a.bvh", "--read", "unit-metres=0.01"]);
    let warnings = told["warnings"].to_string();
    assert!(!warnings.contains("unit-metres"), "{warnings}");
    // A guess is shown with the flag that overrides it, by both commands.
    for words in [&["inspect", "a.bvh"][..], &["convert", "a.bvh", "a.glb"]] {
        let guessed = json(&here, words)["warnings"].to_string();
        assert!(guessed.contains("read as"), "{guessed}");
        assert!(
            guessed.contains("give --read unit-metres=M if that is wrong"),
            "{guessed}"
        );
    }
}

#[test]
fn a_joint_counts_once_however_many_clips_move_it() {
    let here = folder("counted");
    let made = json(
        &here,
        &["convert", word(human()), "a.glb", "--loa", "loa(VeryHigh)"],
    );
    let reduction = &made["reduction"];
    let animated = reduction["before"]["joints_animated"].as_u64().unwrap();
    assert!(animated <= reduction["joints"].as_u64().unwrap() + 1);
    assert_eq!(reduction["before"], reduction["after"]);
}
