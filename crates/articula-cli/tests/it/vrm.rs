//! Real VRM files: expression rules of the files that test them, and the output of `inspect`.

use crate::program::{fault, folder, json, word};
use crate::real::real_data;
use articula::build::{bake, resolve};
use articula::core::source::{Channel, Expression, Interpolation, Property, RawClip, evaluate};
use articula::formats::Limits;
use articula::formats::gltf::{self, GltfFile};
use std::path::{Path, PathBuf};

/// The folder of real VRM files, or none.
fn vrm_data() -> Option<PathBuf> {
    real_data().map(|folder| folder.join("vrm"))
}

fn open(path: &Path) -> GltfFile {
    let bytes = std::fs::read(path).unwrap();
    let mut alone = |_: &str| Err("nothing".to_owned());
    gltf::read(&bytes, &Limits::default(), &mut alone)
        .unwrap()
        .value
}

fn named(expressions: &[Expression], name: &str) -> usize {
    expressions.iter().position(|e| e.name == name).unwrap()
}

/// The two files state: an override by a binary expression is 0 or 1; a binary expression that is
/// overridden at all is off.
#[test]
fn binary_expressions_and_overrides() {
    let Some(data) = vrm_data() else { return };
    let check = |file: &str, table: &[[(f32, f32); 2]]| {
        let file = open(&data.join(format!("VRMC_vrm_expressions_isBinary_{file}.vrm")));
        let expressions = &file.character.expressions;
        let (happy, blink) = (named(expressions, "happy"), named(expressions, "blink"));
        for [(happy_in, blink_in), wanted] in table {
            let mut drivers = vec![0.0; expressions.len()];
            drivers[happy] = *happy_in;
            drivers[blink] = *blink_in;
            let found = resolve(expressions, &drivers);
            assert_eq!(
                (found[happy], found[blink]),
                *wanted,
                "{happy_in} {blink_in}"
            );
        }
    };
    // Happy is plain and blends blink away; blink is binary.
    let overridden = [
        [(0.0, 0.4), (0.0, 0.0)],
        [(0.0, 0.6), (0.0, 1.0)],
        [(0.01, 1.0), (0.01, 0.0)],
        [(1.0, 1.0), (1.0, 0.0)],
    ];
    check("Overridden", &overridden);
    // Happy is binary and blends blink away; blink is plain.
    let overrides = [
        [(0.4, 0.7), (0.0, 0.7)],
        [(0.6, 0.7), (1.0, 0.0)],
        [(0.0, 1.0), (0.0, 1.0)],
    ];
    check("Overrides", &overrides);
}

#[test]
fn expressions_of_a_real_face_become_its_morph_weights() {
    let Some(data) = vrm_data() else { return };
    let file = open(&data.join("Godette_vrm_v4.vrm"));
    let character = &file.character;
    let drive = |name: &str, values: [f32; 2]| Channel {
        target: named(&character.expressions, name),
        property: Property::Expression,
        interpolation: Interpolation::Linear,
        times_secs: vec![0.0, 1.0],
        values: values.to_vec(),
    };
    let clip = RawClip {
        name: "face".into(),
        duration_secs: 1.0,
        channels: vec![drive("angry", [0.0, 1.0]), drive("aa", [0.0, 0.5])],
    };
    let baked = bake(character, &clip).unwrap();
    assert_eq!(baked.channels.len(), 1);
    let channel = &baked.channels[0];
    let mesh = &character.meshes[channel.target];
    assert_eq!(mesh.name, "Face");
    let mut weights = vec![0.0; mesh.morph_weights.len()];
    evaluate::channel(channel, 1.0, &mut weights);
    let weight = |name: &str| {
        let target = mesh.morph_names.iter().position(|n| n == name);
        weights[target.unwrap()]
    };
    // By the file: angry is angled_eyebrows 100, ah 25, blinks 25 each; aa is ah 100.
    assert_eq!(weight("angled_eyebrows"), 1.0);
    assert_eq!(weight("ah"), 0.25 + 0.5);
    assert_eq!((weight("blink_left"), weight("blink_right")), (0.25, 0.25));
    assert_eq!(weights.iter().filter(|w| **w != 0.0).count(), 4);
}

#[test]
fn every_character_faces_the_front() {
    let Some(data) = vrm_data() else { return };
    let mut seen = 0;
    for entry in std::fs::read_dir(data).unwrap() {
        let path = entry.unwrap().path();
        let file = open(&path);
        let bones = file.humanoid.as_ref().unwrap();
        let place = |bone: &str| {
            let (joint, _) = bones.iter().find(|(_, b)| b == bone).unwrap();
            let joints = &file.character.skeleton.joints;
            let mut place = glam::Vec3::ZERO;
            let mut at = Some(*joint);
            while let Some(j) = at {
                place = joints[j].rest.to_affine().transform_point3(place);
                at = joints[j].parent;
            }
            place
        };
        assert!(
            place("leftUpperArm").x > place("rightUpperArm").x,
            "{} has its left at -X",
            path.display()
        );
        if path.ends_with("Godette_vrm_v4.vrm") {
            // The sum of the heights of its nodes.
            assert!((place("hips").y - 0.6457).abs() < 1e-4);
        }
        seen += 1;
    }
    assert_eq!(seen, 7);
}

#[test]
fn inspect_says_who_made_it_and_what_drives_its_face() {
    let Some(data) = vrm_data() else { return };
    let here = folder("vrm-inspect");
    let file = data.join("Godette_vrm_v4.vrm");
    let found = json(&here, &["inspect", word(&file)]);
    assert_eq!(found["format_version"], "VRM 0.0");
    assert_eq!(found["human_bones"], 45);
    assert_eq!(found["credits"]["authors"][0], "SirRichard94");
    assert_eq!(found["credits"]["licence_name"], "CC_BY");
    assert_eq!(found["expressions"].as_array().unwrap().len(), 17);
    assert_eq!(found["expressions"][6]["name"], "blink");
    assert_eq!(
        found["expressions"][6]["morphs"][1]["target"],
        "blink_right"
    );
    assert_eq!(found["kept"][0]["what"], "spring bone chains");
    assert_eq!(found["kept"][0]["count"], 3);
    let found = json(&here, &["inspect", word(&data.join("test.vrma"))]);
    assert_eq!(found["clips"][0]["expressions_keyed"], 1);
    assert_eq!(found["format_version"], "VRM animation 1.0");
}

#[test]
fn a_khr_character_opens_with_mapping_pose_and_licence() {
    let Some(data) = vrm_data() else { return };
    let here = folder("khr-character");
    let file = data.join("Godette_vrm_v4.vrm");
    let words = ["convert", word(&file), "g.glb", "--khr-character"];
    json(&here, &words);
    let found = json(&here, &["inspect", "g.glb"]);
    let khr = &found["khr_character"];
    assert_eq!(khr["rigs"][0]["name"], "vrmHumanoid");
    assert_eq!(khr["rigs"][0]["joints"], 45);
    assert_eq!(khr["reference_poses"][0]["kind"], "TPose");
    assert_eq!(found["credits"]["licence_name"], "CC_BY");
    let words = ["convert", word(&file), "g.bvh", "--khr-character"];
    assert!(fault(&here, 2, &words).contains(".glb"));
}
