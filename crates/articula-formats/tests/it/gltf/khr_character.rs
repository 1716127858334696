//! The draft KHR_character family: reading of expressions of all drafts, masks, mappings and
//! reference poses; and writing.

use super::tiny::{Tiny, hips_height_metres, read};
use super::vrm::{figure, new, old};
use articula_core::source::{Mask, MaskKind, MorphBinding};
use articula_formats::gltf::{GltfFile, ReferencePose, RigMapping};
use glam::Quat;
use serde_json::{Value, json};

fn value(tiny: &Tiny) -> GltfFile {
    tiny.read().unwrap().value
}

/// Adds an animation with one sampler per channel; each channel is target, accessor type and
/// values.
fn animation(tiny: &mut Tiny, mode: &str, times: &[f32], channels: &[(Value, &str, &[f32])]) {
    let mut all = tiny.json["animations"]
        .as_array()
        .cloned()
        .unwrap_or_default();
    tiny.json["animations"] = Value::Null;
    for (target, kind, values) in channels {
        let output = tiny.floats(kind, values);
        tiny.channel(target.clone(), mode, times, output);
    }
    all.push(tiny.json["animations"][0].take());
    tiny.json["animations"] = json!(all);
}

/// Animation 0 drives a morph target and the left leg, 1 is a step of a weight, 2 is a pose, 3
/// drives a material.
pub(crate) fn character() -> Tiny {
    let mut tiny = figure(0.1);
    let turn = Quat::from_rotation_x(1.0).to_array();
    let turns = [[0.0, 0.0, 0.0, 1.0], turn].concat();
    let weights = json!({"node": 3, "path": "weights"});
    let first: [(Value, &str, &[f32]); 2] = [
        (weights.clone(), "SCALAR", &[0.0, 0.0, 0.0, 0.75]),
        (json!({"node": 1, "path": "rotation"}), "VEC4", &turns),
    ];
    animation(&mut tiny, "LINEAR", &[0.0, 2.0], &first);
    let second: [(Value, &str, &[f32]); 1] = [(weights, "SCALAR", &[0.0, 0.0, 1.0, 0.0])];
    animation(&mut tiny, "STEP", &[0.0, 1.0], &second);
    let pose: [(Value, &str, &[f32]); 1] = [(
        json!({"node": 0, "path": "rotation"}),
        "VEC4",
        &[0.0, 0.0, 0.0, 1.0],
    )];
    animation(&mut tiny, "STEP", &[0.0], &pose);
    let pointer = json!({"path": "pointer", "extensions": {"KHR_animation_pointer":
        {"pointer": "/materials/0/pbrMetallicRoughness/baseColorFactor"}}});
    let fourth: [(Value, &str, &[f32]); 1] = [(pointer, "VEC4", &[1.0; 8])];
    animation(&mut tiny, "LINEAR", &[0.0, 1.0], &fourth);
    tiny.json["animations"][2]["extensions"] =
        json!({"KHR_character_reference_pose": {"poseType": "APose"}});
    let mask = |target: Value| {
        json!({"masks": [
        {"target": target, "type": "block", "amount": 0.5, "threshold": 0.25},
        {"target": "aa"}, {"target": "nobody"}, {"target": "aa", "type": "custom"}]})
    };
    tiny.json["extensions"] = json!({
        "KHR_character": {"rootNode": 0},
        "KHR_character_skeleton_mapping": {"skeletalRigMappings": {
            "vrmHumanoid": {"hips": 0, "leftUpperLeg": 1, "rightUpperLeg": 2, "head": 77},
            "mine": {"a": 1}}},
        "KHR_character_expression": {"expressions": [
            {"expression": "happy", "animation": 0, "extensions": {
                "KHR_character_expression_mask": mask(json!(1))}},
            {"expression": "aa", "animation": 1},
            {"expression": "red", "animation": 3},
            {"expression": "lost", "animation": 4}]},
        "KHR_character_expression_mapping": {"expressionSetMappings": {"arkit": {
            "mouthSmile": [{"source": "happy", "weight": 0.5}, {"source": 1, "weight": 0.25}],
            "none": [{"source": "x", "weight": 1.0}]}}},
    });
    tiny
}

#[test]
fn all_members_by_hand() {
    let read = character().read().unwrap();
    let file = read.value;
    assert_eq!(file.version.as_deref(), Some("KHR_character (draft)"));
    assert_eq!(file.humanoid.as_ref().map(Vec::len), Some(3));
    let expressions = &file.character.expressions;
    let names: Vec<_> = expressions.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(names, ["happy", "aa", "red", "lost"]);
    let happy = &expressions[0];
    let morph = |target, weight| MorphBinding {
        mesh: 0,
        target,
        weight,
    };
    assert_eq!(happy.morphs, [morph(1, 0.75)]);
    assert_eq!(happy.joints.len(), 1);
    assert_eq!(happy.joints[0].joint, 1);
    let rest = file.character.skeleton.joints[1].rest;
    assert_eq!(happy.joints[0].full.translation, rest.translation);
    let turned = happy.joints[0].full.rotation;
    assert!(turned.dot(Quat::from_rotation_x(1.0)).abs() > 0.999_999);
    let mask = |kind, amount| Mask {
        target: 1,
        kind,
        amount,
        adds: false,
    };
    let block = MaskKind::Block { above: 0.25 };
    assert_eq!(happy.masks, [mask(block, 0.5), mask(MaskKind::Blend, 1.0)]);
    assert_eq!((expressions[1].is_binary, happy.is_binary), (true, false));
    assert_eq!(expressions[2].unapplied, 1);

    let khr = file.khr_character.unwrap();
    assert_eq!(khr.root_node, Some(0));
    let hips = |n: usize, s: &str| (n, s.to_owned());
    let rig = RigMapping {
        rig: "mine".into(),
        joints: vec![hips(1, "a")],
    };
    assert_eq!(khr.rigs[1], rig);
    let pose = ReferencePose {
        clip: 2,
        kind: "APose".into(),
    };
    assert_eq!(khr.reference_poses, [pose]);
    assert_eq!(khr.expression_clips, [(0, 0), (1, 1), (3, 2)]);
    let shares = &khr.expression_sets[0].shares;
    let shares: Vec<_> = shares.iter().map(|s| (s.expression, s.weight)).collect();
    assert_eq!(shares, [(0, 0.5), (1, 0.25)]);
    let said = |what: &str| read.warnings.iter().any(|w| w.what.contains(what));
    assert!(said("1 entries do not name a node") && said("1 entries do not name an expression"));
    assert!(said("an unknown type") && said("the target is not an expression"));
    assert!(said("the expression has no effect"));
}

#[test]
fn earlier_drafts_list_channels_and_have_other_names() {
    let mut tiny = character();
    let entry = json!({"expression": "smile", "animation": 0, "channels": [0]});
    tiny.json["extensions"] = json!({
        "KHR_avatar": {},
        "KHR_avatar_expression_morphtargets": {"expressions": [entry]},
        "KHR_avatar_skeleton_mapping": {"skeletalRigMappings": {"vrmHumanoid": {
            "hips": "hips", "left": [{"target": "leftUpperLeg", "weight": 1.0}]}}},
        "KHR_avatar_expression_mapping": {"expressionSetMappings": {"known": {
            "smile": [{"target": "Smile", "weight": 0.8}]}}},
    });
    let file = value(&tiny);
    let expression = &file.character.expressions[0];
    assert_eq!((expression.morphs.len(), expression.joints.len()), (1, 0));
    assert_eq!(expression.unapplied, 0);
    assert_eq!(file.humanoid.unwrap().len(), 2);
    let khr = file.khr_character.unwrap();
    assert_eq!(khr.expression_sets[0].shares[0].known, "Smile");
}

#[test]
fn vrm_stands_above_khr_character() {
    let mut tiny = character();
    let vrm = new().json["extensions"]["VRMC_vrm"].clone();
    tiny.json["extensions"]["VRMC_vrm"] = vrm;
    let file = value(&tiny);
    assert_eq!(file.version.as_deref(), Some("VRM 1.0"));
    assert_eq!(file.character.expressions.len(), 4);
    assert_eq!(file.character.expressions[3].name, "wink");
    assert!(file.khr_character.unwrap().expression_clips.is_empty());
}

#[test]
fn expressions_follow_clips_that_are_written_anew() {
    let file = value(&character());
    let entries = |clips: &[usize]| {
        let mut document = file.document.clone();
        let clips: Vec<_> = clips
            .iter()
            .map(|c| file.character.clips[*c].clone())
            .collect();
        document
            .replace_clips(&clips, &file.node_of_joint, &file.node_of_mesh)
            .unwrap();
        read(&document.write_glb().unwrap()).unwrap();
        let entries = document.json["extensions"]["KHR_character_expression"].take();
        let entries = entries["expressions"]
            .as_array()
            .cloned()
            .unwrap_or_default();
        let entry = |e: &Value| {
            (
                e["expression"].as_str().unwrap().to_owned(),
                e["animation"].clone(),
            )
        };
        entries.iter().map(entry).collect::<Vec<_>>()
    };
    let moved = |name: &str, animation: u64| (name.to_owned(), json!(animation));
    assert_eq!(entries(&[2, 1, 0]), [moved("happy", 2), moved("aa", 1)]);
    assert_eq!(entries(&[1]), [moved("aa", 0)]);
    assert_eq!(entries(&[2]), []);
}

fn written(tiny: &Tiny) -> (Value, GltfFile) {
    let file = value(tiny);
    let mut document = file.document.clone();
    let nodes = |(joint, bone): &(usize, String)| (file.node_of_joint[*joint], bone.clone());
    let bones: Vec<_> = file.humanoid.as_ref().unwrap().iter().map(nodes).collect();
    document
        .set_khr_character(&bones, "TPose", file.character.credits.as_ref())
        .unwrap();
    let again = read(&document.write_glb().unwrap()).unwrap().value;
    (document.json, again)
}

#[test]
fn what_is_written_of_vrm_1() {
    let before = value(&new());
    let (json, again) = written(&new());
    let extensions = &json["extensions"];
    // The scene has three root nodes, so a new one is added above them.
    assert_eq!(extensions["KHR_character"]["rootNode"], 5);
    assert_eq!(json["nodes"][5]["children"], json!([0, 3, 4]));
    assert_eq!(json["scenes"][0]["nodes"], json!([5]));
    let rig = &extensions["KHR_character_skeleton_mapping"]["skeletalRigMappings"]["vrmHumanoid"];
    assert_eq!(
        *rig,
        json!({"hips": 0, "leftUpperLeg": 1, "rightUpperLeg": 2})
    );
    let pose = &json["animations"][0];
    assert_eq!(
        pose["extensions"]["KHR_character_reference_pose"]["poseType"],
        "TPose"
    );
    let paths: Vec<_> = pose["channels"].as_array().unwrap().iter().collect();
    assert_eq!(paths.len(), 4, "three rotations and the place of the hips");
    assert_eq!(again.character.expressions, before.character.expressions);
    assert_eq!(again.character.credits, before.character.credits);
    assert_eq!(hips_height_metres(&again), 1.0);
    let khr = again.khr_character.unwrap();
    assert_eq!((khr.rigs.len(), khr.reference_poses.len()), (1, 1));
}

#[test]
fn what_is_written_of_vrm_0_faces_the_front_for_everyone() {
    let before = value(&old(-0.1));
    let (json, again) = written(&old(-0.1));
    assert_eq!(json["nodes"][5]["rotation"], json!([0.0, 1.0, 0.0, 0.0]));
    // The reader recognises the turn and adds none.
    let place = |file: &GltfFile, name: &str| {
        let skeleton = &file.character.skeleton;
        let mut at = skeleton.find(name);
        let mut place = glam::Vec3::ZERO;
        while let Some(j) = at {
            place = skeleton.joints[j].rest.to_affine().transform_point3(place);
            at = skeleton.joints[j].parent;
        }
        place
    };
    for name in ["hips", "left", "right", "face"] {
        assert!(
            place(&before, name).distance(place(&again, name)) < 1e-6,
            "{name}"
        );
    }
    assert!(place(&again, "left").x > place(&again, "right").x);
}

#[test]
fn a_second_writing_changes_nothing_more() {
    let (json, again) = written(&new());
    let mut document = again.document.clone();
    let nodes = |(joint, bone): &(usize, String)| (again.node_of_joint[*joint], bone.clone());
    let bones: Vec<_> = again.humanoid.as_ref().unwrap().iter().map(nodes).collect();
    document.set_khr_character(&bones, "APose", None).unwrap();
    for key in ["nodes", "animations", "extensions", "extensionsUsed"] {
        assert_eq!(document.json[key], json[key], "{key}");
    }
}

#[test]
fn wrong_bones_are_refused_and_thumbs_renamed() {
    let mut document = value(&new()).document;
    let bone = |node: usize, name: &str| (node, name.to_owned());
    let before = document.clone();
    for bones in [
        vec![],
        vec![bone(1, "head")],
        vec![bone(0, "hips"), bone(9, "head")],
    ] {
        document
            .set_khr_character(&bones, "TPose", None)
            .unwrap_err();
        assert_eq!(document, before);
    }
    let bones = [
        bone(0, "hips"),
        bone(1, "leftThumbProximal"),
        bone(2, "leftThumbIntermediate"),
        bone(3, "leftEye"),
        bone(4, "tail"),
    ];
    document.set_khr_character(&bones, "TPose", None).unwrap();
    let rigs = &document.json["extensions"]["KHR_character_skeleton_mapping"];
    assert_eq!(
        rigs["skeletalRigMappings"]["vrmHumanoid"],
        json!({"hips": 0, "leftThumbMetacarpal": 1, "leftThumbProximal": 2})
    );
}

#[test]
fn hostile_extensions_are_warnings_or_nothing() {
    super::vrm::survives_any_word(character);
}
