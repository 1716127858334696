//! `convert --onto`: motions of other figures on one character.

use crate::program::{BVH, articula, fault, folder, human, json, short, word};
use crate::real::real_data;
use articula::core::source::{Character, evaluate};
use articula::core::{ModelPose, Rig, local_to_model};
use articula::formats::{Limits, gltf, joint_map};
use glam::Vec3;
use serde_json::Value;
use std::path::Path;

/// The reference human's own walk and wave as motion files, and a broken one among them.
fn motions(here: &Path) {
    let human = word(human());
    std::fs::create_dir_all(here.join("clips")).unwrap();
    for clip in ["walk", "wave"] {
        let out = format!("clips/{clip}.bvh");
        json(here, &["convert", human, &out, "--clip", clip]);
    }
    std::fs::write(here.join("clips/broken.bvh"), "HIERARCHY\nROOT Hips\n{\n").unwrap();
}

fn character(path: &Path) -> Character {
    let bytes = std::fs::read(path).unwrap();
    let mut nothing = |uri: &str| Err(format!("{uri}: not here"));
    gltf::read(&bytes, &Limits::default(), &mut nothing)
        .unwrap()
        .value
        .character
}

/// Joint positions of a clip at a time.
fn positions(character: &Character, clip: &str, time: f32) -> Vec<Vec3> {
    let map = articula::build::joint_names::map(&character.skeleton, joint_map::builtin(), None);
    let rig = Rig::new(&character.skeleton, map.articulation).unwrap();
    let clip = character.clips.iter().find(|c| c.name == clip).unwrap();
    let mut local = rig.rest_pose().clone();
    evaluate::pose(clip, &character.skeleton, time, &mut local);
    let mut model = ModelPose::new(rig.len());
    local_to_model(&rig, &local, &mut model);
    (0..rig.len()).map(|j| model.position(j)).collect()
}

/// A motion of the human written as BVH, where rest rotations and scales are lost, and retargeted
/// back onto the human is the original motion.
#[test]
fn a_motion_comes_back_onto_the_figure_it_left() {
    let here = folder("there-and-back");
    motions(&here);
    let human = human();
    let words = ["convert", "clips/walk.bvh", "o.glb", "--onto", word(human)];
    let report = json(&here, &words);
    let motion = &report["onto"]["motions"][0];
    assert!(
        (motion["scale"].as_f64().unwrap() - 1.0).abs() < 1e-3,
        "{motion}"
    );
    let joints = motion["joints"].as_array().unwrap().len() as u64;
    let count = |field: &str| motion[field].as_u64().unwrap();
    let sum = count("joints_mapped") + count("joints_shared") + count("joints_held");
    assert_eq!(sum, joints, "every joint is one of the three");
    let (was, is) = (character(human), character(&here.join("o.glb")));
    for time in [0.0, 0.3, 0.6, 0.9] {
        let (was, is) = (positions(&was, "walk", time), positions(&is, "walk", time));
        let far = was
            .iter()
            .zip(&is)
            .map(|(a, b)| a.distance(*b))
            .fold(0.0, f32::max);
        assert!(far < 0.01, "at {time} s a joint is {far} m away");
    }
}

/// A walk on a figure with legs of other proportions: with joint rotations only the feet slide,
/// with pinning they do not.
#[test]
fn feet_are_pinned_unless_told_otherwise() {
    let Some(data) = real_data() else { return };
    let here = folder("onto-pinned");
    let walk = data.join("bvh/cmu_12_01_walk.bvh");
    let knight = data.join("glb/KayKit_Knight.glb");
    let slide = |pin: &[&str]| {
        let mut words = vec!["convert", word(&walk), "o.glb", "--onto", word(&knight)];
        words.extend(pin);
        let report = json(&here, &words);
        let quality = &report["onto"]["motions"][0]["clips"][0]["quality"];
        let mean = |field: &str| quality[field]["mean"].as_f64().unwrap();
        assert!(quality["foot_slide_mm"]["contacts"].as_u64().unwrap() > 0);
        (mean("foot_slide_before_mm"), mean("foot_slide_mm"))
    };
    let (before, after) = slide(&[]);
    assert!(
        after < 5.0 && after < before,
        "{before} mm, then {after} mm"
    );
    assert_eq!(slide(&["--pin", "feet"]), (before, after));
    let (before, after) = slide(&["--pin", "none"]);
    assert!(
        (before - after).abs() < 1e-3,
        "{before} mm, then {after} mm"
    );
    slide(&["--pin", "hands"]);
}

/// A capture that begins with a frame of the T-pose is told, with the flag that cuts it.
#[test]
fn a_first_frame_of_another_pose_is_told_and_cut() {
    let Some(data) = real_data() else { return };
    let here = folder("first-frame");
    let (walk, man) = (
        "bvh/cmu_12_01_walk.bvh",
        "glb/Quaternius_modular_men__Casual2.glb",
    );
    let [walk, man] = [walk, man].map(|name| data.join(name));
    let words = ["convert", word(&walk), "o.glb", "--onto", word(&man)];
    let text = articula(&here, &words).out;
    assert!(
        text.contains("RightArm jumps by 83 degrees; --read first-frame=skip leaves it out"),
        "{text}"
    );
    assert!(text.contains("look at it"), "{text}");
    let clip = |report: &Value| report["onto"]["motions"][0]["clips"][0].clone();
    let whole = clip(&json(&here, &words));
    assert_eq!(whole["good"], false);
    assert_eq!(whole["findings"][0]["kind"], "first_frame");
    let cut = clip(&json(
        &here,
        &[&words[..], &["--read", "first-frame=skip"]].concat(),
    ));
    assert_eq!(
        (&cut["good"], &cut["findings"]),
        (&true.into(), &Value::Array(vec![]))
    );
    let secs = |clip: &Value| clip["duration_secs"].as_f64().unwrap();
    assert!(
        (secs(&whole) - secs(&cut) - 1.0 / 120.0).abs() < 1e-4,
        "one frame less"
    );
    // Without --onto too.
    let plain = [
        "convert",
        word(&walk),
        "p.glb",
        "--read",
        "first-frame=skip",
    ];
    json(&here, &plain);
    let kept = character(&here.join("p.glb")).clips[0].duration_secs;
    assert!((f64::from(kept) - secs(&cut)).abs() < 1e-4);
}

#[test]
fn a_folder_becomes_the_clips_of_one_file() {
    let here = folder("onto-one");
    motions(&here);
    let words = [
        "convert",
        "clips",
        "o.glb",
        "--onto",
        word(human()),
        "--json",
    ];
    let ran = articula(&here, &words);
    assert_eq!(ran.status, 1, "{}", ran.err);
    let report: Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!(report["clips"], serde_json::json!(["walk", "wave"]));
    assert_eq!(report["in"], "clips");
    assert_eq!(report["failed"][0]["in"], "clips/broken.bvh");
    assert!(
        ran.err
            .ends_with("error: 1 of 3 files failed; the others are done\n"),
        "{}",
        ran.err
    );
    let clips = &json(&here, &["inspect", "o.glb"])["clips"];
    assert_eq!(clips.as_array().unwrap().len(), 2);
    // Everything but the clips is the character's own.
    let own = json(&here, &["inspect", word(human())]);
    let new = json(&here, &["inspect", "o.glb"]);
    for field in ["meshes", "skeletons", "height_m"] {
        assert_eq!(own[field], new[field], "{field}");
    }
}

#[test]
fn the_clips_of_the_character_are_kept_when_asked() {
    let here = folder("onto-kept");
    motions(&here);
    std::fs::remove_file(here.join("clips/broken.bvh")).unwrap();
    let words = [
        "convert",
        "clips",
        "o.glb",
        "--onto",
        word(human()),
        "--keep-clips",
    ];
    let report = json(&here, &words);
    let names = serde_json::json!(["idle", "walk", "wave", "walk 2", "wave 2"]);
    assert_eq!(report["clips"], names);
    assert_eq!(report["onto"]["clips_kept"], 3);
    assert_eq!(report["onto"]["motions"][1]["clips"][0]["name"], "wave 2");
    let ran = articula(&here, &[&words[..], &["--force"]].concat());
    assert!(ran.out.contains("keeps 3 clips of its own"), "{}", ran.out);
}

#[test]
fn a_folder_becomes_one_file_for_each_motion() {
    let here = folder("onto-each");
    motions(&here);
    std::fs::remove_file(here.join("clips/broken.bvh")).unwrap();
    let report = json(
        &here,
        &["convert", "clips", "out/", "--onto", word(human())],
    );
    assert_eq!(report["files"].as_array().unwrap().len(), 2);
    for (name, clip) in [("out/walk.glb", "walk"), ("out/wave.glb", "wave")] {
        let clips = &json(&here, &["inspect", name])["clips"];
        assert_eq!(clips.as_array().unwrap().len(), 1, "{name}");
        assert_eq!(clips[0]["name"], clip);
    }
    // As BVH: one clip each, on the character's own joints.
    json(
        &here,
        &[
            "convert",
            "clips",
            "bvh/",
            "--to",
            "bvh",
            "--onto",
            word(human()),
        ],
    );
    let found = json(&here, &["inspect", "bvh/walk.bvh"]);
    assert_eq!(found["skeletons"][0]["joints"], 89);
}

#[test]
fn several_clips_of_one_file_keep_their_names() {
    let here = folder("onto-names");
    let human = word(human());
    let report = json(&here, &["convert", human, "o.glb", "--onto", human]);
    assert_eq!(report["clips"], serde_json::json!(["idle", "walk", "wave"]));
    let report = json(
        &here,
        &[
            "convert", human, human, "o.glb", "--onto", human, "--clip", "walk",
        ],
    );
    assert_eq!(
        report["clips"],
        serde_json::json!(["human walk", "human walk 2"])
    );
}

#[test]
fn a_reduction_follows_the_retarget() {
    let here = folder("onto-reduced");
    motions(&here);
    let words = [
        "convert",
        "clips/walk.bvh",
        "o.glb",
        "--onto",
        word(human()),
        "--loa",
        "loa(Low)",
    ];
    let report = json(&here, &words);
    assert!(report["reduction"]["saved"].as_f64().unwrap() > 0.3);
    assert_eq!(report["onto"]["motions"][0]["clips"][0]["name"], "walk");
}

#[test]
fn the_map_of_the_joints_is_listed() {
    let here = folder("onto-map");
    motions(&here);
    let words = [
        "convert",
        "clips/walk.bvh",
        "o.glb",
        "--onto",
        word(human()),
        "--map",
    ];
    let ran = articula(&here, &words);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let line = ran
        .out
        .lines()
        .find(|l| l.trim_start().starts_with("l_elbow "))
        .unwrap();
    let cells: Vec<&str> = line.split_whitespace().collect();
    assert_eq!(cells, ["l_elbow", "mapped", "l_elbow"]);
}

#[test]
fn what_is_no_human_is_answered_with_a_mend() {
    let here = folder("onto-wrong");
    motions(&here);
    std::fs::write(here.join("bust.bvh"), BVH).unwrap();
    let human = word(human());
    for words in [
        ["convert", "bust.bvh", "o.glb", "--onto", human],
        ["convert", "clips/walk.bvh", "o.glb", "--onto", "bust.bvh"],
    ] {
        let line = fault(&here, 1, &words);
        assert!(
            line.contains("bust.bvh: joints: ") && line.contains("--joint-map"),
            "{line}"
        );
    }
    let line = fault(
        &here,
        1,
        &["convert", "clips/walk.bvh", "o.glb", "--onto", "gone.glb"],
    );
    assert!(line.contains("gone.glb"), "{line}");
    let line = fault(&here, 2, &["convert", "clips", "o.glb"]);
    assert!(line.contains("--onto CHARACTER"), "{line}");
    for flag in ["--keep-clips", "--map"] {
        assert_eq!(
            articula(&here, &["convert", human, "o.glb", flag]).status,
            2
        );
    }
    assert!(
        !here.join("o.glb").exists(),
        "nothing is written on an error"
    );
}

#[test]
fn a_capture_walks_on_a_game_character_and_an_avatar_stays_one() {
    let Some(data) = real_data() else { return };
    let here = folder("onto-real");
    let walk = data.join("bvh/cmu_12_01_walk.bvh");
    let knight = data.join("glb/KayKit_Knight.glb");
    let words = ["convert", word(&walk), "o.glb", "--onto", word(&knight)];
    let report = json(&here, &words);
    assert_eq!(report["clips"], serde_json::json!(["cmu_12_01_walk"]));
    let found = json(&here, &["inspect", "o.glb"]);
    assert_eq!(found["clips"][0]["frames"], 524);
    assert_eq!(found["skeletons"][0]["joints"], 41);
    let avatar = data.join("vrm/Godette_vrm_v4.vrm");
    json(
        &here,
        &["convert", word(&walk), "o.vrm", "--onto", word(&avatar)],
    );
    let found = json(&here, &["inspect", "o.vrm"]);
    assert_eq!(
        (&found["format"], &found["face"]["morphs"]),
        (&"vrm".into(), &15.into())
    );
    assert_eq!(
        found["skeletons"][0]["mapped"], 45,
        "the map of the file is still there"
    );
    // A file without a clip in a folder of motions is skipped, with a note.
    std::fs::create_dir_all(here.join("mixed")).unwrap();
    for file in [&walk, &data.join("glb/mh_male_cmu31.glb")] {
        std::fs::copy(file, here.join("mixed").join(file.file_name().unwrap())).unwrap();
    }
    let report = json(
        &here,
        &["convert", "mixed", "o.glb", "--onto", word(&knight)],
    );
    assert_eq!(
        report["left_out"][0],
        "mixed/mh_male_cmu31.glb (it has no clip)"
    );
}

#[test]
fn build_takes_clips_from_other_files() {
    let here = folder("build-clips");
    motions(&here);
    let human = word(short());
    let words = ["build", human, "clips/walk.bvh", "clips/wave.bvh", "o.glb"];
    let report = json(&here, &words);
    let own = report["clips"].as_array().unwrap().len() - 2;
    assert_eq!(report["clips"][own]["name"], "walk 2", "{report}");
    assert_eq!(report["added"][1]["in"], "clips/wave.bvh");
    let found = json(&here, &["inspect", "o.glb"]);
    assert_eq!(found["clips"].as_array().unwrap().len(), own + 2);
    std::fs::write(here.join("bust.bvh"), BVH).unwrap();
    let line = fault(&here, 1, &["build", human, "bust.bvh", "p.glb"]);
    assert!(
        line.contains("bust.bvh: joints: ") && line.contains("--joint-map F.json"),
        "{line}"
    );
    assert!(!here.join("p.glb").exists());
}

#[test]
fn clipless_characters_become_assets_with_clips() {
    let Some(data) = real_data() else { return };
    let here = folder("build-real");
    for (character, motion, clips, retargeted) in [
        (
            "glb/kaykit_mannequin/manny_med_mod.gltf",
            "glb/kaykit_mannequin/Med_MovementBasic.glb",
            11,
            false,
        ),
        (
            "glb/mh_female_default163_arkit52.glb",
            "bvh/cmu_12_01_walk.bvh",
            1,
            true,
        ),
    ] {
        let (character, motion) = (data.join(character), data.join(motion));
        // The shortest of the clips is a 15th of a second.
        let cut = ["convert", word(&motion), "m.glb", "--trim", "..0.06"];
        json(&here, &cut);
        let report = json(&here, &["build", word(&character), "m.glb", "o.glb"]);
        let added = &report["added"][0];
        assert_eq!(added["retargeted"], retargeted);
        assert_eq!(added["clips"].as_array().unwrap().len(), clips);
        let found = json(&here, &["inspect", "o.glb"]);
        let moving = found["clips"].as_array().unwrap();
        assert_eq!(moving.len(), clips);
        let joints = |clip: &Value| clip["joints_animated"].as_u64().unwrap();
        assert!(moving.iter().any(|clip| joints(clip) > 10), "{found}");
    }
}
