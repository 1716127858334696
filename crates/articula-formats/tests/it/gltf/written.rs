//! Writing: unknown content is untouched, animations get smaller, extensions carry tables.

use super::tiny::{Tiny, read};
use articula_core::source::{Channel, Interpolation, Property, RawClip};
use articula_core::{Articulation, JointArticulation, Region};
use articula_formats::gltf::{Document, GltfFile, read_document};
use articula_formats::{Limits, WriteError};
use serde_json::{Value, json};

/// Writes and reads a document; reading it from memory gives the same.
fn written(document: &Document) -> GltfFile {
    let file = read(&document.write_glb().unwrap()).unwrap();
    assert_eq!(file.warnings, []);
    let alone = read_document(document.clone(), &Limits::default()).unwrap();
    assert_eq!(alone.warnings, []);
    assert_eq!(alone.value.character, file.value.character);
    assert_eq!(alone.value.node_of_joint, file.value.node_of_joint);
    assert_eq!(alone.value.node_of_mesh, file.value.node_of_mesh);
    file.value
}

/// A skinned triangle that waves for a second with many keys.
fn waving() -> Tiny {
    let mut tiny = Tiny::skinned();
    let times: Vec<f32> = (0..100).map(|i| i as f32 * 0.01).collect();
    let turns = tiny.floats("VEC4", &[0., 0., 0., 1.].repeat(100));
    tiny.channel(
        json!({"node": 1, "path": "rotation"}),
        "LINEAR",
        &times,
        turns,
    );
    tiny.json["animations"][0]["name"] = json!("wave");
    tiny
}

fn slide(target: usize) -> RawClip {
    let channel = Channel {
        target,
        property: Property::Translation,
        interpolation: Interpolation::Step,
        times_secs: vec![0.0, 0.5],
        values: vec![0.0, 0.0, 0.0, 0.1, 0.2, 0.3],
    };
    RawClip {
        name: "wave".to_owned(),
        duration_secs: 0.5,
        channels: vec![channel],
    }
}

#[test]
fn extensions_and_extras_pass_through_untouched() {
    let mut tiny = Tiny::skinned();
    let odd = json!({"z": [1, 2.5, {"deep": null}], "a": "b", "big": 123_456_789_012_345_u64});
    tiny.json["extensions"] = json!({"ACME_future": odd});
    tiny.json["extras"] = odd.clone();
    tiny.json["nodes"][0]["extras"] = odd.clone();
    tiny.json["nodes"][0]["extensions"] = json!({"ACME_future": odd});
    tiny.json["unheard_of"] = odd.clone();
    let document = tiny.read().unwrap().value.document;
    let back = written(&document).document;
    assert_eq!(back.json, document.json);
    assert_eq!(
        back.json.to_string(),
        document.json.to_string(),
        "key order too"
    );
    assert_eq!(back.buffers, document.buffers);
}

#[test]
fn several_buffers_and_inline_pictures_become_one_chunk() {
    let tiny = Tiny::skinned();
    let mut json = tiny.json.clone();
    let uri = |bytes: &[u8]| {
        let encoded: String = bytes.iter().map(|b| format!("%{b:02x}")).collect();
        format!("data:,{encoded}")
    };
    // A first buffer of odd length, so that the second one's views must move.
    json["buffers"] = json!([
        {"uri": uri(&[7, 7, 7]), "byteLength": 3},
        {"uri": uri(&tiny.bytes), "byteLength": tiny.bytes.len()},
    ]);
    for view in json["bufferViews"].as_array_mut().unwrap() {
        view["buffer"] = json!(1);
    }
    json["images"] = json!([{"uri": uri(b"\x89PNG picture"), "name": "face"}]);
    let file = read(json.to_string().as_bytes()).unwrap().value;
    let back = written(&file.document);
    assert_eq!(back.character, file.character);
    assert_eq!(back.character.images[0].bytes, b"\x89PNG picture");
    assert_eq!(back.document.buffers.len(), 1);
    let image = &back.document.json["images"][0];
    assert_eq!(
        (image["uri"].is_null(), &image["name"]),
        (true, &json!("face"))
    );
    assert_eq!(image["mimeType"], "image/png");
}

#[test]
fn new_clips_take_the_place_of_the_old_and_their_bytes() {
    let mut tiny = waving();
    tiny.json["animations"][0]["extras"] = json!({"author": "someone"});
    // Bytes after those of the animation, which must move too.
    let marker = tiny.bytes_accessor("SCALAR", 5121, &[0, 1, 2]);
    tiny.json["meshes"][0]["primitives"][0]["indices"] = json!(marker);
    let mut file = tiny.read().unwrap().value;
    let before = file.document.write_glb().unwrap().len();
    file.document
        .replace_clips(&[slide(1)], &file.node_of_joint, &file.node_of_mesh)
        .unwrap();
    let back = written(&file.document);
    assert_eq!(back.character.clips, [slide(1)]);
    assert_eq!(back.character.meshes, file.character.meshes);
    let extras = &back.document.json["animations"][0]["extras"];
    assert_eq!(extras["author"], "someone");
    // 100 keys of 20 bytes were removed, 2 keys of 16 added.
    let after = file.document.write_glb().unwrap().len();
    assert!(before > after + 1500, "{before} to {after}");

    file.document.replace_clips(&[], &[], &[]).unwrap();
    let bare = written(&file.document);
    assert_eq!(bare.document.json.get("animations"), None);
    assert_eq!(bare.character.meshes, file.character.meshes);
}

#[test]
fn an_unknown_extension_keeps_every_array() {
    let mut tiny = waving();
    tiny.json["extensions"] = json!({"ACME_curves": {"bufferView": 3}});
    let mut file = tiny.read().unwrap().value;
    let views = file.document.json["bufferViews"].as_array().unwrap().len();
    file.document
        .replace_clips(&[slide(0)], &file.node_of_joint, &file.node_of_mesh)
        .unwrap();
    let back = written(&file.document);
    let kept = back.document.json["bufferViews"].as_array().unwrap();
    assert_eq!(
        kept[..views],
        file.document.json["bufferViews"].as_array().unwrap()[..views]
    );
    assert_eq!(kept.len(), views + 1);
    assert_eq!(back.character.clips, [slide(0)]);
}

#[test]
fn clips_for_other_characters_are_refused() {
    let mut file = waving().read().unwrap().value;
    let document = file.document.clone();
    let refused = |result: Result<(), WriteError>| result.unwrap_err().to_string();
    let error = refused(
        file.document
            .replace_clips(&[slide(5)], &file.node_of_joint, &[]),
    );
    assert_eq!(error, "channel 0: target 5 has no node");
    let mut short = slide(0);
    short.channels[0].values.pop();
    let error = refused(
        file.document
            .replace_clips(&[short], &file.node_of_joint, &[]),
    );
    assert_eq!(error, "channel 0: 5 floats for 2 keys");
    assert_eq!(file.document, document, "unchanged after an error");
}

fn articulation() -> Articulation {
    let joint = |hanim: &str, level, region| JointArticulation {
        hanim: Some(hanim.to_owned()),
        level,
        region,
    };
    Articulation {
        profile: "hanim".to_owned(),
        joints: vec![
            joint("humanoid_root", 0, Region::Pelvis),
            joint("vl5", 2, Region::Torso),
        ],
    }
}

#[test]
fn articulation_and_motion_tables_come_back_and_survive_new_clips() {
    let mut file = waving().read().unwrap().value;
    let document = &mut file.document;
    document
        .set_articulation(&articulation(), &file.node_of_joint)
        .unwrap();
    document
        .set_motion_table(0, "motionError", &[1, 2, 3, 4, 5])
        .unwrap();
    document.json["animations"][0]["extensions"]["ARTICULA_articulation"]["metric"] =
        json!({"at": "skin"});
    let used = json!(["ARTICULA_articulation"]);
    assert_eq!(document.json["extensionsUsed"], used, "named once");
    let back = written(document);
    assert_eq!(back.character.articulation, Some(articulation()));
    let back = back.document;
    assert_eq!(
        back.motion_table(0, "motionError"),
        Some(&[1, 2, 3, 4, 5][..])
    );
    assert_eq!(back.motion_table(0, "other"), None);
    assert_eq!(
        back.json["animations"][0]["extensions"]["ARTICULA_articulation"]["metric"],
        json!({"at": "skin"}),
        "what others say there stays"
    );
    // Tables describe old keys, so they are removed with them; the articulation of skins stays.
    document
        .replace_clips(&[slide(0)], &file.node_of_joint, &file.node_of_mesh)
        .unwrap();
    let back = written(document);
    assert_eq!(back.document.motion_table(0, "motionError"), None);
    assert_eq!(back.character.articulation, Some(articulation()));
    assert!(document.set_motion_table(1, "motionError", &[]).is_err());
}

#[test]
fn a_table_that_is_written_again_takes_the_place_of_the_old() {
    let mut document = waving().read().unwrap().value.document;
    document
        .set_motion_table(0, "segs", &[1, 2, 3, 4, 5])
        .unwrap();
    let length = document.buffers[0].len();
    for bytes in [&[6, 7, 8, 9, 10][..], &[11, 12], &[13, 14, 15]] {
        document.set_motion_table(0, "segs", bytes).unwrap();
        assert_eq!(document.motion_table(0, "segs"), Some(bytes));
    }
    // Three bytes do not fit over two; the first two rewrites cost nothing.
    assert!(document.buffers[0].len() <= length + 4 + 3);
    assert_eq!(
        written(&document).document.motion_table(0, "segs"),
        Some(&[13, 14, 15][..])
    );
}

#[test]
fn a_broken_articulation_is_a_warning() {
    let mut tiny = Tiny::skinned();
    for broken in [
        json!({"profile": "x", "joints": []}),
        json!({"joints": [{"level": 9, "region": "pelvis"}, {"level": 0, "region": "pelvis"}]}),
        json!({"joints": [{"level": 0, "region": "tail"}, {"level": 0, "region": "pelvis"}]}),
    ] {
        tiny.json["skins"][0]["extensions"] = json!({ "ARTICULA_articulation": broken });
        let file = tiny.read().unwrap();
        assert_eq!(file.value.character.articulation, None);
        assert_eq!(file.warnings.len(), 1);
    }
}

#[test]
fn joints_in_no_skin_take_what_is_above_them() {
    let mut tiny = Tiny::skinned();
    let nodes = tiny.json["nodes"].as_array_mut().unwrap();
    nodes[1]["children"] = json!([3]);
    nodes.push(json!({"name": "sword", "mesh": 0}));
    nodes.push(json!({"name": "armature", "children": [0]}));
    tiny.json["scenes"][0]["nodes"] = json!([4, 2]);
    let joint = |level: u8, region: &str| json!({"hanim": null, "level": level, "region": region});
    let joints = json!([joint(1, "legs"), joint(2, "torso")]);
    tiny.json["skins"][0]["extensions"] =
        json!({"ARTICULA_articulation": {"profile": "x", "joints": joints}});
    let character = tiny.read().unwrap().value.character;
    let found = character.articulation.unwrap().joints;
    let names: Vec<_> = character
        .skeleton
        .joints
        .iter()
        .map(|j| j.name.as_str())
        .collect();
    assert_eq!(names, ["armature", "hips", "chest", "sword"]);
    let found: Vec<_> = found.iter().map(|j| (j.level, j.region)).collect();
    assert_eq!(found[0], (0, Region::Pelvis));
    assert_eq!(found[1], (1, Region::Legs));
    assert_eq!(found[3], (2, Region::Torso));
}

#[test]
fn a_new_document_states_bounds_and_puts_skins_at_the_root() {
    let mut file = waving().read().unwrap().value;
    file.character.name = "Someone".to_owned();
    let document = Document::from_character(&file.character).unwrap();
    let json = &document.json;
    assert_eq!(
        json["asset"]["generator"],
        concat!("articula ", env!("CARGO_PKG_VERSION"))
    );
    assert_eq!(json["scenes"][0]["nodes"], json!([0, 2]));
    assert_eq!(json["nodes"][2]["skin"], 0);
    assert_eq!(json["buffers"].as_array().unwrap().len(), 1);
    let positions = &json["meshes"][0]["primitives"][0]["attributes"]["POSITION"];
    let positions = &json["accessors"][positions.as_u64().unwrap() as usize];
    assert_eq!(positions["min"], json!([0.0, 0.0, 0.0]));
    assert_eq!(positions["max"], json!([1.0, 1.0, 0.0]));
    let view = &json["bufferViews"][positions["bufferView"].as_u64().unwrap() as usize];
    assert_eq!(view["target"], 34962);
    assert_eq!(written(&document).character, file.character);
}

#[test]
fn a_skeleton_alone_keeps_its_joints_and_motion() {
    let mut file = waving().read().unwrap().value;
    file.character.meshes.clear();
    file.character.articulation = Some(articulation());
    let back = written(&Document::from_character(&file.character).unwrap());
    assert_eq!(back.character, file.character);
    assert_eq!(back.document.json.get("meshes"), None::<&Value>);
}

#[test]
fn an_inconsistent_character_is_refused() {
    let good = waving().read().unwrap().value.character;
    let refused = |change: &dyn Fn(&mut articula_core::source::Character)| {
        let mut character = good.clone();
        change(&mut character);
        Document::from_character(&character)
            .unwrap_err()
            .to_string()
    };
    let error = refused(&|c| c.skeleton.joints[1].parent = Some(1));
    assert_eq!(error, "joint 1: its parent must come before it");
    let error = refused(&|c| c.meshes[0].skin.joints[0] = 9);
    assert_eq!(error, "mesh 0: its skin does not match the skeleton");
    let error = refused(&|c| c.meshes[0].primitives[0].triangles[0][2] = 3);
    assert!(
        error.contains("a vertex index of a triangle is out of range"),
        "{error}"
    );
    let error = refused(&|c| c.meshes[0].primitives[0].weights.truncate(3));
    assert_eq!(
        error,
        "mesh 0 primitive 0: the lengths of its arrays do not match"
    );
}
