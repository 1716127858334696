//! VRM 0.x, VRM 1.0 and VRM animation: humanoid map, expressions, credits, pass-through data, and
//! the facing of VRM 0.x characters.

use super::tiny::{Tiny, hips_height_metres, read};
use articula_core::source::{Channel, Expression, Mask, MaskKind, MorphBinding, Property};
use articula_formats::gltf::{GltfFile, PassThrough};
use serde_json::{Value, json};

/// Hips with two legs on nodes 0 to 2, and on nodes 3 and 4 the one mesh, with two morph targets.
/// The left leg is at `left`.
pub(crate) fn figure(left: f32) -> Tiny {
    let mut tiny = Tiny::triangle();
    let offsets = tiny.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let target = json!({"POSITION": offsets});
    tiny.json["meshes"][0]["primitives"][0]["targets"] = json!([target, target]);
    tiny.json["nodes"] = json!([
        {"name": "hips", "children": [1, 2], "translation": [0.25, 1, 0.5]},
        {"name": "left", "translation": [left, -0.1, 0]},
        {"name": "right", "translation": [-left, -0.1, 0]},
        {"name": "face", "mesh": 0},
        {"name": "mask", "mesh": 0},
    ]);
    tiny.json["scenes"] = json!([{"nodes": [0, 3, 4]}]);
    tiny.json["scene"] = json!(0);
    tiny
}

pub(crate) fn old(left: f32) -> Tiny {
    let mut tiny = figure(left);
    tiny.json["extensionsUsed"] = json!(["VRM"]);
    tiny.json["extensions"] = json!({"VRM": {
        "specVersion": "0.0",
        "meta": {"title": "Old", "author": "Somebody", "licenseName": "CC0"},
        "humanoid": {"humanBones": [
            {"bone": "hips", "node": 0}, {"bone": "leftUpperLeg", "node": 1},
            {"bone": "rightUpperLeg", "node": 2}, {"bone": "jaw", "node": -1},
            {"bone": "spine", "node": 99}]},
        "blendShapeMaster": {"blendShapeGroups": [
            {"name": "Joy", "presetName": "joy", "isBinary": true,
                "binds": [{"mesh": 0, "index": 1, "weight": 40}]},
            {"name": "Wink", "presetName": "unknown", "binds": [{"mesh": 0, "index": 2}],
                "materialValues": [{"materialName": "m"}]}]},
        "firstPerson": {"lookAtTypeName": "Bone", "meshAnnotations": [{"mesh": 0}]},
        "secondaryAnimation": {"boneGroups": [{}, {}],
            "colliderGroups": [{"node": 0, "colliders": [{}, {}, {}]}]},
    }});
    tiny
}

pub(crate) fn new() -> Tiny {
    let mut tiny = figure(0.1);
    tiny.json["extensionsUsed"] = json!(["VRMC_vrm", "VRMC_springBone"]);
    tiny.json["nodes"][1]["extensions"] = json!({"VRMC_node_constraint": {"specVersion": "1.0"}});
    let bind = |node: usize, index: usize, weight: f32| json!({"node": node, "index": index, "weight": weight});
    tiny.json["extensions"] = json!({
        "VRMC_vrm": {
            "specVersion": "1.0",
            "meta": {"name": "New", "authors": ["A", "B"],
                "licenseUrl": "https://vrm.dev/licenses/1.0/"},
            "humanoid": {"humanBones": {"hips": {"node": 0}, "leftUpperLeg": {"node": 1},
                "rightUpperLeg": {"node": 2}}},
            "expressions": {
                "preset": {
                    "happy": {"morphTargetBinds": [bind(3, 0, 1.0), bind(4, 1, 0.5)],
                        "overrideBlink": "blend", "overrideMouth": "block"},
                    "blink": {"isBinary": true, "morphTargetBinds": [bind(4, 0, 1.0)],
                        "overrideBlink": "block"},
                    "aa": {"materialColorBinds": [{}], "textureTransformBinds": [{}, {}]}},
                "custom": {"wink": {"overrideBlink": "none", "overrideLookAt": "blend"}}},
            "lookAt": {"type": "bone"},
        },
        "VRMC_springBone": {"springs": [{}], "colliders": [{}, {}]},
    });
    tiny
}

fn value(tiny: &Tiny) -> GltfFile {
    tiny.read().unwrap().value
}

fn morph(mesh: usize, target: usize, weight: f32) -> MorphBinding {
    MorphBinding {
        mesh,
        target,
        weight,
    }
}

#[test]
fn vrm_0_by_hand() {
    let read = old(-0.1).read().unwrap();
    let file = read.value;
    assert_eq!(file.version.as_deref(), Some("VRM 0.0"));
    let bones = ["hips", "leftUpperLeg", "rightUpperLeg"];
    let wanted = bones.iter().enumerate();
    let wanted: Vec<_> = wanted.map(|(j, b)| (j, (*b).to_owned())).collect();
    assert_eq!(file.humanoid, Some(wanted));
    let expressions = &file.character.expressions;
    let happy = Expression {
        name: "happy".into(),
        morphs: vec![morph(0, 1, 0.4), morph(1, 1, 0.4)],
        is_binary: true,
        ..Expression::default()
    };
    assert_eq!(expressions[0], happy, "a mesh counts wherever it is shown");
    assert_eq!(expressions[1].name, "Wink");
    assert!(expressions[1].morphs.is_empty(), "there is no target 2");
    assert_eq!(expressions[1].unapplied, 1);
    let credits = file.character.credits.unwrap();
    assert_eq!(
        (credits.title, credits.licence_name),
        ("Old".into(), "CC0".into())
    );
    let kept = |what, count| PassThrough { what, count };
    assert_eq!(
        file.kept,
        [
            kept("spring bone chains", 2),
            kept("spring bone colliders", 3),
            kept("look-at settings", 1),
            kept("first-person annotations", 1),
            kept("expression bindings to materials and textures", 1),
        ]
    );
    let warnings: Vec<_> = read.warnings.iter().map(|w| w.to_owned()).collect();
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].what.contains("index 99"));
    assert!(warnings[1].at.contains("blendShapeGroups[1].binds[0]"));
}

#[test]
fn vrm_1_by_hand() {
    let file = value(&new());
    assert_eq!(file.version.as_deref(), Some("VRM 1.0"));
    assert_eq!(file.humanoid.as_ref().map(Vec::len), Some(3));
    assert_eq!(hips_height_metres(&file), 1.0);
    let expressions = &file.character.expressions;
    let names: Vec<_> = expressions.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(names, ["happy", "blink", "aa", "wink"]);
    assert_eq!(expressions[0].morphs, [morph(0, 0, 1.0), morph(1, 1, 0.5)]);
    let mask = |target, kind| Mask {
        target,
        kind,
        amount: 1.0,
        adds: true,
    };
    let block = MaskKind::Block { above: 0.0 };
    assert_eq!(
        expressions[0].masks,
        [mask(2, block), mask(1, MaskKind::Blend)]
    );
    assert!(expressions[1].masks.is_empty(), "not its own kind");
    assert!(expressions[1].is_binary);
    assert_eq!(expressions[2].unapplied, 3);
    assert!(
        expressions[3].masks.is_empty(),
        "there is no gaze to weaken"
    );
    let counts: Vec<_> = file.kept.iter().map(|k| (k.what, k.count)).collect();
    assert_eq!(
        counts,
        [
            ("spring bone chains", 1),
            ("spring bone colliders", 2),
            ("node constraints", 1),
            ("look-at settings", 1),
            ("expression bindings to materials and textures", 3),
        ]
    );
    assert_eq!(file.character.credits.unwrap().authors, ["A", "B"]);
}

/// Adds a clip that moves and rotates the hips, and rotates a leg.
fn moving(mut tiny: Tiny) -> Tiny {
    let places = tiny.floats("VEC3", &[0.25, 1.0, 0.5, 0.0, 1.0, -2.0]);
    let turns = [0.0, 0.0, 0.0, 1.0, 0.5, 0.5, -0.5, 0.5];
    let turns = tiny.floats("VEC4", &turns);
    let times = [0.0, 1.0];
    tiny.channel(
        json!({"node": 0, "path": "translation"}),
        "LINEAR",
        &times,
        places,
    );
    tiny.channel(
        json!({"node": 0, "path": "rotation"}),
        "LINEAR",
        &times,
        turns,
    );
    tiny.channel(
        json!({"node": 1, "path": "rotation"}),
        "LINEAR",
        &times,
        turns,
    );
    tiny
}

#[test]
fn vrm_0_is_turned_to_face_the_front_and_written_as_it_was() {
    let tiny = moving(old(-0.1));
    let file = value(&tiny);
    let joints = &file.character.skeleton.joints;
    assert_eq!(joints[0].rest.translation.to_array(), [-0.25, 1.0, -0.5]);
    assert_eq!(joints[0].rest.rotation.to_array(), [0.0, 1.0, 0.0, 0.0]);
    assert_eq!(joints[1].rest.translation.to_array(), [-0.1, -0.1, 0.0]);
    let channels = &file.character.clips[0].channels;
    assert_eq!(channels[0].values[3..], [0.0, 1.0, 2.0]);
    // Half a turn about y, times the key (0.5, 0.5, -0.5, 0.5).
    assert_eq!(channels[1].values[4..], [-0.5, 0.5, -0.5, -0.5]);
    assert_eq!(
        channels[2].values[4..],
        [0.5, 0.5, -0.5, 0.5],
        "no root joint"
    );
    // Meshes rigidly attached to the root turn too.
    let face = &joints[file.character.meshes[0].skin.joints[0]];
    assert_eq!(face.rest.rotation.to_array(), [0.0, 1.0, 0.0, 0.0]);

    let mut document = file.document.clone();
    document
        .replace_clips(
            &file.character.clips,
            &file.node_of_joint,
            &file.node_of_mesh,
        )
        .unwrap();
    let mut bare = document.clone();
    // The view of a reader without VRM support.
    bare.json
        .as_object_mut()
        .unwrap()
        .shift_remove("extensions");
    let seen = read(&bare.write_glb().unwrap()).unwrap().value;
    let mut untouched = tiny;
    untouched
        .json
        .as_object_mut()
        .unwrap()
        .shift_remove("extensions");
    let wanted = value(&untouched);
    assert_eq!(seen.character.clips, wanted.character.clips);
    let again = read(&document.write_glb().unwrap()).unwrap().value;
    assert_eq!(again.character, file.character);
}

#[test]
fn vrm_0_that_faces_the_front_already_is_left_alone() {
    let file = value(&moving(old(0.1)));
    let joints = &file.character.skeleton.joints;
    assert_eq!(joints[0].rest.translation.to_array(), [0.25, 1.0, 0.5]);
    assert_eq!(joints[0].rest.rotation.to_array(), [0.0, 0.0, 0.0, 1.0]);
}

/// Hips, two expression tracks and a look-at target.
pub(crate) fn animation() -> Tiny {
    let mut tiny = Tiny::new();
    tiny.json["nodes"] = json!([{"name": "hips", "translation": [0, 0.9, 0]}, {"name": "happy"},
        {"name": "mine"}, {"name": "gaze"}]);
    let values = tiny.floats("VEC3", &[0.0, 5.0, 5.0, 0.75, 5.0, 5.0]);
    let times = [0.0, 2.0];
    for node in [2, 1, 3] {
        let target = json!({"node": node, "path": "translation"});
        tiny.channel(target, "LINEAR", &times, values);
    }
    tiny.json["extensionsUsed"] = json!(["VRMC_vrm_animation"]);
    tiny.json["extensions"] = json!({"VRMC_vrm_animation": {
        "specVersion": "1.0",
        "humanoid": {"humanBones": {"hips": {"node": 0}}},
        "expressions": {"preset": {"happy": {"node": 1}}, "custom": {"mine": {"node": 2}}},
        "lookAt": {"node": 3}}});
    tiny
}

#[test]
fn expression_tracks_of_vrm_animations() {
    let file = value(&animation());
    assert_eq!(file.version.as_deref(), Some("VRM animation 1.0"));
    let character = &file.character;
    let names: Vec<_> = character
        .expressions
        .iter()
        .map(|e| e.name.as_str())
        .collect();
    assert_eq!(names, ["happy", "mine"]);
    let joints: Vec<_> = character
        .skeleton
        .joints
        .iter()
        .map(|j| j.name.as_str())
        .collect();
    assert_eq!(joints, ["hips", "gaze"], "a track is no joint");
    let seen = |c: &Channel| (c.target, c.property, c.values.clone());
    let channels: Vec<_> = character.clips[0].channels.iter().map(seen).collect();
    assert_eq!(channels[0], (1, Property::Expression, vec![0.0, 0.75]));
    assert_eq!(channels[1], (0, Property::Expression, vec![0.0, 0.75]));
    assert_eq!((channels[2].0, channels[2].1), (1, Property::Translation));
    assert_eq!(file.kept.len(), 1);
    assert_eq!(file.kept[0].what, "look-at tracks");

    let mut document = file.document.clone();
    document
        .replace_clips(&character.clips, &file.node_of_joint, &file.node_of_mesh)
        .unwrap();
    let again = read(&document.write_glb().unwrap()).unwrap().value;
    assert_eq!(again.character, *character);
}

#[test]
fn a_track_that_is_also_a_bone_stays_a_joint() {
    let mut tiny = animation();
    let bones = json!({"hips": {"node": 1}});
    tiny.json["extensions"]["VRMC_vrm_animation"]["humanoid"]["humanBones"] = bones;
    let file = value(&tiny);
    let channels = &file.character.clips[0].channels;
    let properties: Vec<_> = channels.iter().map(|c| c.property).collect();
    let joint = Property::Translation;
    assert_eq!(properties, [Property::Expression, joint, joint]);
}

#[test]
fn hostile_extensions_are_warnings_or_nothing() {
    survives_any_word(|| old(-0.1));
    survives_any_word(new);
    survives_any_word(animation);
}

/// Replaces every value of the document's extensions in turn; each time the file must be readable,
/// and the result writable.
pub(crate) fn survives_any_word(make: impl Fn() -> Tiny) {
    let words = [
        json!(null),
        json!(-1),
        json!(1e300),
        json!("x"),
        json!([]),
        json!([[], {}, null, "x"]),
        json!({"a": {}, "preset": [], "happy": 7}),
    ];
    for path in paths_of(&make().json["extensions"], String::from("/extensions")) {
        for word in &words {
            let mut tiny = make();
            *tiny.json.pointer_mut(&path).unwrap() = word.clone();
            let read = tiny.read();
            let read = read.unwrap_or_else(|e| panic!("{path} = {word}: {e}"));
            read.value.document.write_glb().unwrap();
        }
    }
}

/// Returns pointers to a value and to every value below it.
fn paths_of(value: &Value, at: String) -> Vec<String> {
    let below: Vec<(String, &Value)> = match value {
        Value::Object(members) => members.iter().map(|(k, v)| (k.clone(), v)).collect(),
        Value::Array(list) => {
            let entries = list.iter().enumerate();
            entries.map(|(i, v)| (i.to_string(), v)).collect()
        }
        _ => Vec::new(),
    };
    let mut paths = vec![at.clone()];
    for (key, value) in below {
        paths.extend(paths_of(value, format!("{at}/{key}")));
    }
    paths
}
