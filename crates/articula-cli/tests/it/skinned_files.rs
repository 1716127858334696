//! Real characters: grouped skinning gives the same result as plain skinning.

use crate::program;
use crate::real::bytes;
use articula::core::source::Character;
use articula::core::{
    Articulation, GroupedSkin, JointArticulation, JointSet, Matrix3x4, Mesh, ModelPose, Region,
    Rig, SkinnedMesh, local_to_model, palette, skin,
};
use articula::formats::{Limits, gltf};
use glam::{Affine3A, Quat, Vec3};

/// A rig, its mesh, and buffers of one frame.
struct Figure {
    rig: Rig,
    mesh: Mesh,
}

impl Figure {
    fn new(character: &Character) -> Self {
        let joint = JointArticulation {
            hanim: None,
            level: 0,
            region: Region::Torso,
        };
        let articulation = Articulation {
            profile: String::new(),
            joints: vec![joint; character.skeleton.joints.len()],
        };
        let rig = Rig::new(&character.skeleton, articulation).unwrap();
        let mesh = Mesh::new(&character.meshes, rig.len()).unwrap();
        Self { rig, mesh }
    }

    /// The palette of a pose in which some joints are rotated, each differently.
    fn palette(&self, turned: &JointSet) -> (Vec<Affine3A>, Vec<Matrix3x4>) {
        let mut local = self.rig.rest_pose().clone();
        for joint in turned.iter() {
            let axis = Vec3::new(0.3, -0.2, 0.4) * (joint as f32 * 2.4).sin();
            local.rotations[joint] *= Quat::from_scaled_axis(axis);
        }
        let mut model = ModelPose::new(self.rig.len());
        local_to_model(&self.rig, &local, &mut model);
        let mut matrices = vec![Affine3A::IDENTITY; self.mesh.bindings.len()];
        palette(&self.mesh, &model, &mut matrices);
        let mut rows_of = vec![[[0.0; 4]; 3]; matrices.len()];
        GroupedSkin::rows(&matrices, &mut rows_of);
        (matrices, rows_of)
    }
}

/// Rounding where a build fuses multiplication and addition; zero elsewhere.
fn same(a: &[Vec3], b: &[Vec3], size: f32) -> bool {
    let fused = cfg!(any(target_feature = "fma", target_arch = "aarch64"));
    let within = if fused { 1e-5 * size } else { 0.0 };
    a.iter().zip(b).all(|(a, b)| a.distance(*b) <= within)
}

fn check(name: &str, character: &Character) {
    let figure = Figure::new(character);
    let mesh = &figure.mesh;
    let grouped = GroupedSkin::new(mesh);
    let weights: Vec<f32> = (0..mesh.morph_weights.len())
        .map(|slot| (slot % 3) as f32 * 0.4)
        .collect();
    let (mut shape, mut stale) = (grouped.rest().clone(), grouped.stale());
    grouped.morph(&weights, &mut shape, &mut stale);
    let (mut plain, mut fast) = (SkinnedMesh::new(mesh), SkinnedMesh::new(mesh));
    let compare = |plain: &SkinnedMesh, fast: &SkinnedMesh| {
        let size = plain
            .positions
            .iter()
            .map(|p| p.length())
            .fold(1.0, f32::max);
        assert!(same(&fast.positions, &plain.positions, size), "{name}");
        assert!(same(&fast.normals, &plain.normals, 100.0), "{name}");
    };

    let all = JointSet::first(figure.rig.len());
    let (matrices, before) = figure.palette(&all);
    skin(mesh, &matrices, &weights, &mut plain);
    grouped.skin_stale(&shape, &before, &mut stale, &mut fast);
    compare(&plain, &fast);

    // The joint in the middle of the list turns back, and all its descendants follow.
    let mut turned = all;
    turned.remove(figure.rig.len() / 2);
    let (matrices, now) = figure.palette(&turned);
    skin(mesh, &matrices, &weights, &mut plain);
    grouped.mark_joints(&grouped.moved(&before, &now), &mut stale);
    let count = grouped.skin_stale(&shape, &now, &mut stale, &mut fast);
    compare(&plain, &fast);
    println!("{name}: {count} of {} vertices again", mesh.len());
}

fn read(bytes: &[u8]) -> Character {
    let mut beside = |uri: &str| Err(format!("{uri} lies beside"));
    let file = gltf::read(bytes, &Limits::default(), &mut beside).unwrap();
    file.value.character
}

#[test]
fn the_reference_human_is_skinned_alike() {
    let bytes = std::fs::read(program::human()).unwrap();
    check("human", &read(&bytes));
}

#[test]
fn real_characters_are_skinned_alike() {
    let files = [
        "glb/pab_arnaud.glb",
        "glb/mh_female_default163_arkit52.glb",
        "glb/KayKit_Knight.glb",
        "glb/RobotExpressive.glb",
        "glb/mannequiny.glb",
        "vrm/Godette_vrm_v4.vrm",
    ];
    for name in files {
        let Some(bytes) = bytes(name) else { continue };
        check(name, &read(&bytes));
    }
}
