//! Nodes with a matrix that receive clips.

use super::tiny::{Tiny, read};
use crate::cases::case;
use articula_core::source::{Channel, Interpolation, Property, RawClip};
use articula_formats::gltf::GltfFile;
use glam::{Mat4, Quat, Vec3};
use proptest::prelude::*;
use serde_json::json;

/// A clip that turns every joint.
fn turning(joints: usize) -> RawClip {
    let channel = |target| Channel {
        target,
        property: Property::Rotation,
        interpolation: Interpolation::Linear,
        times_secs: vec![0.0],
        values: vec![0.0, 0.0, 0.0, 1.0],
    };
    RawClip {
        name: "turn".to_owned(),
        duration_secs: 0.0,
        channels: (0..joints).map(channel).collect(),
    }
}

/// The file with a clip that turns every joint, written and read.
fn with_clip(mut file: GltfFile) -> GltfFile {
    let clip = turning(file.node_of_joint.len());
    let document = &mut file.document;
    document
        .replace_clips(&[clip], &file.node_of_joint, &file.node_of_mesh)
        .unwrap();
    read(&document.write_glb().unwrap()).unwrap().value
}

#[test]
fn joints_with_matrices_receive_a_clip_without_moving() {
    let file = read(&case("matrix_nodes.glb")).unwrap().value;
    let matrices = |file: &GltfFile| {
        let nodes = file.document.json["nodes"].as_array().unwrap();
        nodes.iter().filter(|n| n.get("matrix").is_some()).count()
    };
    assert_eq!(matrices(&file), 21);
    let rest = file.character.skeleton.clone();
    let written = with_clip(file);
    assert_eq!(matrices(&written), 0);
    assert_eq!(written.character.skeleton, rest);
}

proptest! {
    #[test]
    fn a_matrix_is_written_as_the_transform_that_it_is(
        translation: [i8; 3], turn in prop::array::uniform3(-3.0f32..3.0),
        scale in prop::array::uniform3(0.1f32..5.0), mirrored: bool,
    ) {
        let [x, y, z] = turn;
        let rotation = Quat::from_euler(glam::EulerRot::XYZ, x, y, z);
        let mut scale = Vec3::from_array(scale);
        scale.x *= if mirrored { -1.0 } else { 1.0 };
        let translation = Vec3::from_array(translation.map(f32::from));
        let matrix = Mat4::from_scale_rotation_translation(scale, rotation, translation);
        let mut tiny = Tiny::skinned();
        tiny.json["nodes"][1] = json!({"name": "chest", "matrix": matrix.to_cols_array()});
        let written = with_clip(tiny.read().unwrap().value);
        prop_assert_eq!(written.document.json["nodes"][1].get("matrix"), None);
        let rest = Mat4::from(written.character.skeleton.joints[1].rest.to_affine());
        prop_assert!(rest.abs_diff_eq(matrix, 1e-4), "{rest} for {matrix}");
    }
}

#[test]
fn shear_is_told_and_written_as_it_is_read() {
    let mut tiny = Tiny::skinned();
    let sheared = [1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 1];
    tiny.json["nodes"][1] = json!({"name": "chest", "matrix": sheared});
    let file = tiny.read().unwrap();
    assert_eq!(file.warnings.len(), 1);
    assert_eq!(file.warnings[0].at, "nodes[1].matrix");
    assert!(file.warnings[0].what.contains("sheared"));
    let rest = file.value.character.skeleton.clone();
    assert_eq!(with_clip(file.value).character.skeleton, rest);
}
