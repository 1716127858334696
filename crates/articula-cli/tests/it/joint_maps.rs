//! Joint maps of a user: `inspect --write joint-map=…`, `--joint-map`, doubtful joints, hands alone and
//! rigs that are no humans.

use crate::program::{articula, edited, fault, folder, human, json, word};
use crate::real::real_data;
use serde_json::Value;
use std::path::Path;

/// Replaces the names of the nodes of a GLB.
fn renamed(glb: &Path, out: &Path, name: impl Fn(&str) -> String) {
    edited(glb, out, |document| {
        for node in document["nodes"].as_array_mut().unwrap() {
            if let Some(own) = node["name"].as_str() {
                node["name"] = name(own).into();
            }
        }
        // Levels and regions are found anew.
        document.as_object_mut().unwrap().remove("extensions");
        document.as_object_mut().unwrap().remove("extensionsUsed");
        for skin in document["skins"].as_array_mut().unwrap() {
            skin.as_object_mut().unwrap().remove("extensions");
        }
        for node in document["nodes"].as_array_mut().unwrap() {
            node.as_object_mut().unwrap().remove("extensions");
        }
    });
}

/// H-Anim joint, level and region of every joint.
fn mapping(found: &Value) -> Vec<[Value; 3]> {
    let joints = found["map"].as_array().unwrap();
    let of = |joint: &'_ Value| -> [Value; 3] {
        ["hanim", "level", "region"].map(|field| joint[field].clone())
    };
    joints.iter().map(of).collect()
}

/// A written map gives the joints of its own rig what they had; returns the report of the first run.
fn comes_back(here: &Path, file: &Path) -> Value {
    let words = ["inspect", word(file), "--write", "joint-map=map.json"];
    let before = json(here, &words);
    assert_eq!(before["written"][0], "map.json");
    let after = json(here, &["inspect", word(file), "--joint-map", "map.json"]);
    assert_eq!(mapping(&before), mapping(&after), "{}", file.display());
    let name = &after["skeletons"][0]["profile"];
    assert_eq!(name, file.file_stem().unwrap().to_str().unwrap());
    before
}

#[test]
fn a_written_joint_map_maps_the_rig_as_before() {
    let here = folder("joint-map-written");
    let plain = here.join("plain.glb");
    renamed(human(), &plain, str::to_owned);
    comes_back(&here, &plain);
    // Words of two conventions: limbs by DAZ, the rest by H-Anim, with numbers of an exporter.
    let words = here.join("words.glb");
    renamed(human(), &words, |name| {
        let daz = [
            ("hip", "Thigh"),
            ("knee", "Shin"),
            ("ankle", "Foot"),
            ("shoulder", "Shldr"),
            ("elbow", "ForeArm"),
            ("wrist", "Hand"),
        ];
        let (side, part) = name.split_once('_').unwrap_or(("", name));
        let own = daz.iter().find(|(hanim, _)| *hanim == part);
        own.map_or(format!("cloth_{name}"), |(_, own)| {
            format!("{side}{own}_07")
        })
    });
    let found = comes_back(&here, &words);
    assert_eq!(found["skeletons"][0]["profile"], "words");
    let Some(data) = real_data() else { return };
    for name in [
        "glb/pab_arnaud.glb",
        "glb/webxr_hand_right.glb",
        "vrm/Godette_vrm_v4.vrm",
        "vrm/debug_robot.vrm",
        "bvh/cmu_12_01_walk.bvh",
    ] {
        comes_back(&here, &data.join(name));
    }
    // A rig that was recognised by its shape has no names to write.
    let cesium = data.join("glb/CesiumMan.glb");
    let words = ["inspect", word(&cesium), "--write", "joint-map=no.json"];
    let line = fault(&here, 1, &words);
    assert!(
        line.contains("CesiumMan.glb: joints: no joint map can tell them"),
        "{line}"
    );
    assert!(!here.join("no.json").exists());
}

#[test]
fn an_unknown_rig_is_written_to_be_edited() {
    let Some(data) = real_data() else { return };
    let here = folder("joint-map-unknown");
    let fox = data.join("glb/Fox.glb");
    json(
        &here,
        &["inspect", word(&fox), "--write", "joint-map=fox.json"],
    );
    let text = std::fs::read_to_string(here.join("fox.json")).unwrap();
    let mut map: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(map["unmapped"].as_array().unwrap().len(), 24);
    // A person says that it is one all the same, and leaves the rest of the list.
    for (name, hanim) in [
        ("b_Hip_01", "humanoid_root"),
        ("b_LeftLeg01_015", "l_hip"),
        ("b_RightLeg01_019", "r_hip"),
        ("b_LeftUpperArm_09", "l_shoulder"),
        ("b_RightUpperArm_06", "r_shoulder"),
    ] {
        map["joints"][name] = hanim.into();
    }
    std::fs::write(here.join("fox.json"), map.to_string()).unwrap();
    let found = json(&here, &["inspect", word(&fox), "--joint-map", "fox.json"]);
    assert_eq!(found["skeletons"][0]["profile"], "Fox");
    assert_eq!(found["skeletons"][0]["mapped"], 5);
}

#[test]
fn a_joint_map_of_the_user_wins_over_that_of_the_file() {
    let Some(data) = real_data() else { return };
    let here = folder("joint-map-wins");
    let robot = data.join("vrm/debug_robot.vrm");
    let before = comes_back(&here, &robot);
    let text = std::fs::read_to_string(here.join("map.json")).unwrap();
    let mut map: Value = serde_json::from_str(&text).unwrap();
    let joints = map["joints"].as_object_mut().unwrap();
    joints.retain(|_, hanim| hanim != "skullbase");
    std::fs::write(here.join("map.json"), map.to_string()).unwrap();
    let after = json(&here, &["inspect", word(&robot), "--joint-map", "map.json"]);
    let mapped = |found: &Value| found["skeletons"][0]["mapped"].as_u64().unwrap();
    assert_eq!(mapped(&after) + 1, mapped(&before));
    let told = |found: &Value| {
        found["map"]
            .as_array()
            .unwrap()
            .iter()
            .find_map(|j| j["told_by"].as_str().map(str::to_owned))
    };
    assert_eq!(told(&before).as_deref(), Some("file map"));
    assert_eq!(told(&after).as_deref(), Some("joint map"));
    // A map that lacks a hip does not fit, and that is said.
    let joints = map["joints"].as_object_mut().unwrap();
    joints.retain(|_, hanim| hanim != "l_hip");
    std::fs::write(here.join("map.json"), map.to_string()).unwrap();
    let other = json(&here, &["inspect", word(&robot), "--joint-map", "map.json"]);
    assert_eq!(mapped(&other), mapped(&before));
    let warnings = other["warnings"].as_array().unwrap();
    assert!(
        warnings.iter().any(|w| w["at"] == "--joint-map"),
        "{warnings:?}"
    );
    assert!(
        before["warnings"]
            .as_array()
            .unwrap()
            .iter()
            .all(|w| w["at"] != "--joint-map")
    );
}

#[test]
fn doubtful_joints_are_listed_with_the_reason() {
    let here = folder("joint-map-doubts");
    renamed(human(), &here.join("good.glb"), str::to_owned);
    let good = articula(&here, &["inspect", "good.glb"]);
    assert!(!good.out.contains("doubt"), "{}", good.out);
    let odd = here.join("odd.glb");
    renamed(human(), &odd, |name| match name {
        "l_knee" => "Kneipe".to_owned(),
        "r_wrist" => "l_wrist_b".to_owned(),
        other => other.to_owned(),
    });
    let found = json(&here, &["inspect", word(&odd)]);
    let doubtful = found["skeletons"][0]["doubtful"].as_array().unwrap();
    let knee = doubtful.iter().find(|d| d["joint"] == "Kneipe").unwrap();
    assert_eq!(
        (knee["hanim"].as_str(), knee["confidence"].as_str()),
        (Some("l_knee"), Some("low"))
    );
    let text = articula(&here, &["inspect", "odd.glb"]).out;
    let line = "\"Kneipe\" as l_knee, low confidence: unknown name; found by its place in the tree";
    assert!(text.contains(line), "{text}");
    assert!(text.contains("--write joint-map=F.json"), "{text}");
}

/// A joint map may come from a pipe, which can be read once.
#[cfg(unix)]
#[test]
fn a_joint_map_is_read_once() {
    let here = folder("joint-map-pipe");
    std::fs::write(here.join("hand.bvh"), bvh("LeftHand", &FINGERS, 5.0)).unwrap();
    let words = ["inspect", "hand.bvh", "--write", "joint-map=hand.json"];
    json(&here, &words);
    let line = "cat hand.json | \"$0\" inspect hand.bvh --joint-map /dev/stdin --json";
    let mut shell = std::process::Command::new("sh");
    let shell = shell.args(["-c", line, env!("CARGO_BIN_EXE_articula")]);
    let ran = shell.current_dir(&here).output().unwrap();
    let err = String::from_utf8_lossy(&ran.stderr);
    assert!(ran.status.success() && err.is_empty(), "{err}");
    let found: Value = serde_json::from_slice(&ran.stdout).unwrap();
    assert_eq!(found["skeletons"][0]["profile"], "hand");
    let warnings = found["warnings"].as_array().unwrap().iter();
    assert!(
        warnings.clone().all(|w| w["at"] != "--joint-map"),
        "{found}"
    );
}

#[test]
fn a_file_without_joints_has_no_joint_map() {
    let here = folder("joint-map-data");
    std::fs::write(here.join("a.fap"), "2.1 a 30 1\n").unwrap();
    let words = ["inspect", "a.fap", "--write", "joint-map=o.json"];
    assert!(fault(&here, 2, &words).contains("this file has no joints"));
}

/// A rig of one joint chain per line of names, with one motion, as BVH. Every joint is `length`
/// below the one above it.
fn bvh(root: &str, chains: &[&[&str]], length: f32) -> String {
    let mut text = format!(
        "HIERARCHY\nROOT {root}\n{{\nOFFSET 0 {length} 0\nCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n"
    );
    let mut joints = 0;
    for (at, chain) in chains.iter().enumerate() {
        for name in *chain {
            joints += 1;
            text += &format!(
                "JOINT {name}\n{{\nOFFSET {} {length} 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n",
                at as f32 * 0.1 * length
            );
        }
        text += &format!("End Site\n{{\nOFFSET 0 {length} 0\n}}\n");
        text += &"}\n".repeat(chain.len());
    }
    text += "}\nMOTION\nFrames: 2\nFrame Time: 0.1\n";
    for frame in 0..2 {
        let turns = vec![(10 * frame).to_string(); 3 * joints];
        text += &format!(
            "0 {} {frame} 0 {} 0 {}\n",
            length,
            5 * frame,
            turns.join(" ")
        );
    }
    text
}

const FINGERS: [&[&str]; 5] = [
    &["LeftHandThumb1", "LeftHandThumb2", "LeftHandThumb3"],
    &["LeftHandIndex1", "LeftHandIndex2", "LeftHandIndex3"],
    &["LeftHandMiddle1", "LeftHandMiddle2", "LeftHandMiddle3"],
    &["LeftHandRing1", "LeftHandRing2", "LeftHandRing3"],
    &["LeftHandPinky1", "LeftHandPinky2", "LeftHandPinky3"],
];

#[test]
fn a_hand_alone_is_mapped_and_moves_the_hand_of_a_figure() {
    let here = folder("hands-alone");
    std::fs::write(here.join("hand.bvh"), bvh("LeftHand", &FINGERS, 5.0)).unwrap();
    let found = json(
        &here,
        &["inspect", "hand.bvh", "--read", "unit-metres=0.01"],
    );
    let skeleton = &found["skeletons"][0];
    assert_eq!(
        (skeleton["mapped"].as_u64(), skeleton["profile"].as_str()),
        (Some(16), Some("mixamo"))
    );
    assert_eq!(skeleton["missing"].as_array().unwrap().len(), 0);
    let words = ["convert", "hand.bvh", "o.glb", "--onto", word(human())];
    let report = json(&here, &words);
    let motion = &report["onto"]["motions"][0];
    assert_eq!(motion["joints_mapped"], 15, "{motion}");
    let followed = motion["joints"].as_array().unwrap().iter();
    let mut followed = followed.filter(|joint| joint["origin"] == "mapped");
    assert!(followed.all(|joint| joint["joint"].as_str().unwrap().starts_with("l_")));
    // Of a character there is no hand alone to move.
    let line = fault(
        &here,
        1,
        &["convert", word(human()), "p.glb", "--onto", "hand.bvh"],
    );
    assert!(line.contains("hand.bvh: joints: "), "{line}");
    let words = ["inspect", "hand.bvh", "--write", "joint-map=hand.json"];
    json(&here, &words);
    let text = std::fs::read_to_string(here.join("hand.json")).unwrap();
    assert!(text.contains("\"scope\": \"hand\""), "{text}");
}

#[test]
fn a_motion_of_a_rig_that_is_no_human_goes_onto_one_of_the_same_names() {
    let here = folder("onto-same-names");
    let legs: [&[&str]; 3] = [
        &["Vorn", "VornUnten"],
        &["Hinten", "HintenUnten"],
        &["Rute"],
    ];
    std::fs::write(here.join("small.bvh"), bvh("Leib", &legs, 10.0)).unwrap();
    std::fs::write(here.join("large.bvh"), bvh("Leib", &legs, 30.0)).unwrap();
    let words = [
        "convert",
        "small.bvh",
        "o.bvh",
        "--onto",
        "large.bvh",
        "--read",
        "unit-metres=0.01",
    ];
    let report = json(&here, &words);
    let motion = &report["onto"]["motions"][0];
    assert_eq!(motion["by_name"], true);
    assert_eq!(
        (
            motion["joints_mapped"].as_u64(),
            motion["dropped"].as_array().unwrap().len()
        ),
        (Some(6), 0)
    );
    assert!(
        (motion["scale"].as_f64().unwrap() - 3.0).abs() < 1e-4,
        "{motion}"
    );
    assert!(motion["clips"][0]["quality"].is_null());
    let ran = articula(&here, &[&words[..], &["--force"]].concat());
    let line =
        "small.bvh: retargeted by joint names: 6 of 6 moving joints are followed, scale 3.00";
    assert!(ran.out.contains(line), "{} {}", ran.out, ran.err);
    // Half of the names are gone: refused, with the numbers.
    let other: [&[&str]; 3] = [&["A", "B"], &["C", "D"], &["Rute"]];
    std::fs::write(here.join("other.bvh"), bvh("Leib", &other, 10.0)).unwrap();
    let words = [
        "convert",
        "small.bvh",
        "p.bvh",
        "--onto",
        "other.bvh",
        "--read",
        "unit-metres=0.01",
    ];
    let line = fault(&here, 1, &words);
    assert!(
        line.contains("only 2 of the 6 moving joints of small.bvh"),
        "{line}"
    );
    assert!(!here.join("p.bvh").exists());
}

#[test]
fn moving_joints_are_counted_among_the_joints_listed() {
    let Some(data) = real_data() else { return };
    let here = folder("moving-counts");
    for name in [
        "glb/kaykit_mannequin/Med_General.glb",
        "vrm/idle_loop.vrma",
        "glb/Fox.glb",
    ] {
        let found = json(&here, &["inspect", word(&data.join(name))]);
        let joints = found["skeletons"].as_array().unwrap().iter();
        let joints: u64 = joints.map(|s| s["joints"].as_u64().unwrap()).sum();
        for clip in found["clips"].as_array().unwrap() {
            let count = |field: &str| clip[field].as_u64().unwrap();
            let (moving, keyed) = (count("joints_animated"), count("joints_keyed"));
            assert!(
                moving <= keyed && keyed <= joints,
                "{name}: {moving}, {keyed} of {joints}"
            );
        }
    }
}
