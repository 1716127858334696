//! Joints that are inserted into documents and removed from them.

use super::tiny::{Tiny, read};
use articula_core::Transform;
use articula_formats::WriteError;
use articula_formats::gltf::{Document, GltfFile, NewJoint, OldJoint};
use glam::{Affine3A, Quat, Vec3};
use serde_json::json;

/// A triangle skinned to hips, chest and neck in a chain, each 1 m above the other; another node
/// hangs from the chest.
fn chain() -> Tiny {
    let mut tiny = Tiny::skinned();
    tiny.json["nodes"] = json!([
        {"name": "hips", "children": [1]},
        {"name": "chest", "translation": [0, 1, 0], "children": [3, 4]},
        {"name": "body", "mesh": 0, "skin": 0},
        {"name": "neck", "translation": [0, 1, 0]},
        {"name": "arm", "translation": [1, 0, 0]},
    ]);
    let at = |y: f32| Affine3A::from_translation(Vec3::new(0.0, -y, 0.0));
    let binds = [at(0.0), at(1.0), at(2.0), at(1.0)];
    let numbers = binds.map(|m| glam::Mat4::from(m).to_cols_array()).concat();
    let binds = tiny.floats("MAT4", &numbers);
    tiny.json["skins"] =
        json!([{"joints": [0, 1, 3, 4], "inverseBindMatrices": binds, "skeleton": 1}]);
    let joints = tiny.bytes_accessor("VEC4", 5121, &[0, 1, 2, 0, 1, 0, 0, 0, 2, 3, 0, 0]);
    let weights = [0.25, 0.25, 0.5, 0., 1., 0., 0., 0., 0.5, 0.5, 0., 0.];
    let weights = tiny.floats("VEC4", &weights);
    let attributes = &mut tiny.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = json!(joints);
    attributes["WEIGHTS_0"] = json!(weights);
    tiny
}

fn again(document: &Document) -> GltfFile {
    let file = read(&document.write_glb().unwrap()).unwrap();
    assert_eq!(file.warnings, []);
    file.value
}

/// Removes the chest in favour of the hips.
fn chest(turned: Quat) -> OldJoint {
    let rest = |x, y| Transform {
        translation: Vec3::new(x, y, 0.0),
        rotation: turned,
        scale: Vec3::ONE,
    };
    OldJoint {
        node: 1,
        into: 0,
        rest: Transform::from_translation(Vec3::Y),
        children: vec![(3, rest(0.0, 2.0)), (4, rest(1.0, 1.0))],
    }
}

fn names(file: &GltfFile) -> Vec<(&str, Option<usize>)> {
    let joints = file.character.skeleton.joints.iter();
    joints.map(|j| (j.name.as_str(), j.parent)).collect()
}

#[test]
fn a_removed_joint_leaves_its_skin_and_its_children() {
    let mut document = chain().read().unwrap().value.document;
    let turned = Quat::from_rotation_z(0.5);
    document.remove_joint(&chest(turned)).unwrap();
    let file = again(&document);
    assert_eq!(
        names(&file),
        [("hips", None), ("neck", Some(0)), ("arm", Some(0))]
    );
    let joints = &file.character.skeleton.joints;
    assert_eq!(joints[1].rest.translation, Vec3::new(0.0, 2.0, 0.0));
    assert_eq!(joints[2].rest.rotation, turned);
    let mesh = &file.character.meshes[0];
    assert_eq!(mesh.skin.joints, [0, 1, 2]);
    let binds: Vec<f32> = mesh
        .skin
        .inverse_bind
        .iter()
        .map(|m| m.translation.y)
        .collect();
    assert_eq!(binds, [0.0, -2.0, -1.0]);
    let part = &mesh.primitives[0];
    assert_eq!(part.joints, [0, 0, 1, 0, 0, 0, 0, 0, 1, 2, 0, 0]);
    assert_eq!(
        part.weights,
        [0.5, 0., 0.5, 0., 1., 0., 0., 0., 0.5, 0.5, 0., 0.]
    );
    assert_eq!(document.json["skins"][0]["skeleton"], 0);
    assert_eq!(
        document.json["nodes"][1],
        json!({}),
        "an unused entry keeps the other numbers"
    );
}

#[test]
fn a_skin_without_the_receiver_lists_it_instead() {
    let mut tiny = chain();
    tiny.json["skins"][0]["joints"] = json!([2, 1, 3, 4]);
    let mut document = tiny.read().unwrap().value.document;
    document.remove_joint(&chest(Quat::IDENTITY)).unwrap();
    assert_eq!(document.json["skins"][0]["joints"], json!([2, 0, 3, 4]));
    let file = again(&document);
    let hips = file.character.skeleton.find("hips").unwrap();
    let skin = &file.character.meshes[0].skin;
    let slot = skin.joints.iter().position(|j| *j == hips).unwrap();
    // What was bound 1 m up, at the chest, is bound there, seen from the hips.
    assert_eq!(skin.inverse_bind[slot], Affine3A::IDENTITY);
}

#[test]
fn a_removed_joint_that_shows_something_stays_as_a_plain_node() {
    let mut tiny = chain();
    tiny.json["cameras"] =
        json!([{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}]);
    tiny.json["nodes"][1]["camera"] = json!(0);
    let mut document = tiny.read().unwrap().value.document;
    document.remove_joint(&chest(Quat::IDENTITY)).unwrap();
    assert_eq!(document.json["nodes"][0]["children"], json!([1, 3, 4]));
    let node = &document.json["nodes"][1];
    assert_eq!(
        node,
        &json!({"name": "chest_merged", "translation": [0, 1, 0], "camera": 0})
    );
}

#[test]
fn meshes_of_two_skins_are_refused_where_they_differ() {
    let mut tiny = chain();
    let own = tiny.json["skins"][0].clone();
    tiny.json["skins"] = json!([own, {"joints": [1, 0, 3, 4]}]);
    let nodes = tiny.json["nodes"].as_array_mut().unwrap();
    nodes.push(json!({"name": "other", "mesh": 0, "skin": 1}));
    tiny.json["scenes"][0]["nodes"] = json!([0, 2, 5]);
    let mut document = tiny.read().unwrap().value.document;
    let before = document.clone();
    let why = document.remove_joint(&chest(Quat::IDENTITY)).unwrap_err();
    assert!(
        matches!(&why, WriteError::Mismatch { at, .. } if at == "meshes[0]"),
        "{why}"
    );
    assert_eq!(before, document);
    let root = OldJoint {
        node: 0,
        ..chest(Quat::IDENTITY)
    };
    assert!(document.remove_joint(&root).is_err());
}

#[test]
fn an_inserted_joint_is_part_of_the_skins_around_it() {
    let mut document = chain().read().unwrap().value.document;
    let joint = NewJoint {
        name: "collar",
        parent: 1,
        child: 4,
        offset: Vec3::new(0.25, 0.0, 0.0),
        child_rest: Some(Transform::from_translation(Vec3::new(0.75, 0.0, 0.0))),
    };
    let node = document.insert_joint(&joint).unwrap();
    assert_eq!(node, 5);
    let file = again(&document);
    let wanted = [
        ("hips", None),
        ("chest", Some(0)),
        ("neck", Some(1)),
        ("collar", Some(1)),
        ("arm", Some(3)),
    ];
    assert_eq!(names(&file), wanted);
    let rest = file.character.skeleton.model_rest();
    assert_eq!(rest[4].translation, Vec3::new(1.0, 1.0, 0.0).into());
    let skin = &file.character.meshes[0].skin;
    assert_eq!(skin.joints, [0, 1, 2, 4, 3]);
    assert!(rest[3].inverse().abs_diff_eq(skin.inverse_bind[4], 1e-6));
    let stranger = NewJoint { parent: 3, ..joint };
    assert!(document.insert_joint(&stranger).is_err());
}
