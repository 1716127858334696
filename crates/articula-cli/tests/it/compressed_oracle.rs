//! A compressed file: three.js with the decoder of meshoptimizer shows the original, the file that
//! Articula writes, and the character as read; the validator accepts the written file.

use crate::judges::{ask, judges_are_here};
use crate::real::{data_folder, data_is_here};
use articula::core::source::{Character, Primitive, RawMesh};
use articula::formats::Limits;
use articula::formats::gltf::{self, GltfFile};
use glam::{Affine3A, Vec3};
use serde_json::Value;
use std::path::Path;

/// Quantised, filtered and compressed, without plain bytes: 53 joints, 7125 vertices.
const FILE: &str = "glb/viverse/mannequin.glb";

/// Maximum distance of a vertex from that of three.js, metres, in a figure of 1.83 m: three.js
/// multiplies 32-bit matrices in another order.
const TOLERANCE: f32 = 1e-6 * 1.83;

/// One primitive as shown by three.js.
struct Shown {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
}

fn shown(path: &Path) -> (Vec<Shown>, String) {
    let (answer, good) = ask(
        "skinned_positions.mjs",
        &[path.to_string_lossy().into_owned()],
    );
    assert!(good, "{answer}");
    let list: Value = serde_json::from_str(&answer).unwrap();
    let vectors = |value: &Value| {
        let numbers = value.as_array().unwrap().iter();
        let numbers: Vec<f32> = numbers.map(|x| x.as_f64().unwrap() as f32).collect();
        numbers
            .as_chunks::<3>()
            .0
            .iter()
            .map(|v| Vec3::from_array(*v))
            .collect()
    };
    let primitive = |value: &Value| Shown {
        positions: vectors(&value["positions"]),
        normals: vectors(&value["normals"]),
    };
    let primitives = list.as_array().unwrap().iter().map(primitive).collect();
    (primitives, answer)
}

fn open(path: &Path) -> GltfFile {
    let mut alone = |uri: &str| Err(format!("{uri} is not needed"));
    let bytes = std::fs::read(path).unwrap();
    gltf::read(&bytes, &Limits::default(), &mut alone)
        .unwrap()
        .value
}

/// Skinned vertices at rest, computed from the definition.
fn skinned(character: &Character, mesh: &RawMesh, primitive: &Primitive) -> Vec<Vec3> {
    let mut model: Vec<Affine3A> = Vec::new();
    for joint in &character.skeleton.joints {
        let parent = joint.parent.map_or(Affine3A::IDENTITY, |p| model[p]);
        let t = joint.rest;
        model.push(
            parent * Affine3A::from_scale_rotation_translation(t.scale, t.rotation, t.translation),
        );
    }
    let skin = &mesh.skin;
    let matrices: Vec<Affine3A> = skin
        .joints
        .iter()
        .zip(&skin.inverse_bind)
        .map(|(j, inverse)| model[*j] * *inverse)
        .collect();
    let vertex = |(v, position): (usize, &Vec3)| {
        let range = v * primitive.influences..(v + 1) * primitive.influences;
        let each = primitive.joints[range.clone()]
            .iter()
            .zip(&primitive.weights[range]);
        each.map(|(j, w)| matrices[usize::from(*j)].transform_point3(*position) * *w)
            .sum()
    };
    primitive.positions.iter().enumerate().map(vertex).collect()
}

#[test]
fn a_compressed_file_is_shown_the_same_by_all() {
    if !judges_are_here() || !data_is_here() {
        return;
    }
    let original = data_folder().join(FILE);
    let file = open(&original);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("compressed");
    std::fs::create_dir_all(&folder).unwrap();
    let written = folder.join("plain.glb");
    std::fs::write(&written, file.document.write_glb().unwrap()).unwrap();
    let (verdict, good) = ask("validate.mjs", &[written.to_string_lossy().into_owned()]);
    assert!(good, "{verdict}");

    let (primitives, answer) = shown(&original);
    assert_eq!(answer, shown(&written).1, "to the last digit");

    let meshes = file.character.meshes.iter();
    let ours: Vec<(&RawMesh, &Primitive)> = meshes
        .flat_map(|m| m.primitives.iter().map(move |p| (m, p)))
        .collect();
    assert_eq!(ours.len(), primitives.len());
    for ((mesh, ours), theirs) in ours.into_iter().zip(primitives) {
        assert_eq!(ours.positions.len(), theirs.positions.len());
        for (a, b) in skinned(&file.character, mesh, ours)
            .iter()
            .zip(&theirs.positions)
        {
            assert!(a.distance(*b) <= TOLERANCE, "{a} is at {b} in three.js");
        }
        // Rounded to eight bits by a filter: an error of one unit each is allowed, sqrt(3) / 127 in
        // all.
        for (a, b) in ours.normals.iter().zip(&theirs.normals) {
            assert!(a.distance(*b) <= 0.014, "{a} is {b} in three.js");
        }
    }
}
