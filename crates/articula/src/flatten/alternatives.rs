//! Meshes that a file has for choice, such as several shields in one hand.

use articula_core::{Mesh, ModelPose, Rig, local_to_model};
use articula_flat::Bounds;
use glam::Vec3;
use std::collections::BTreeMap;

/// Least part of the smaller of two boxes that lies in the other, where one mesh is in the place of the other.
const SHARED: f32 = 2.0 / 3.0;

/// Meshes in one place on one joint, which may be alternatives.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AlternativeMeshes {
    /// Name of the joint.
    pub joint: String,
    /// Names of the meshes, in the order of the file.
    pub meshes: Vec<String>,
}

/// Finds meshes that hang in one place on one joint which is no part of a body, such as a slot for weapons:
/// of these a game shows one. Pictures show all.
pub fn alternative_meshes(rig: &Rig, mesh: &Mesh) -> Vec<AlternativeMeshes> {
    let mut rest = ModelPose::new(rig.len());
    local_to_model(rig, rig.rest_pose(), &mut rest);
    let mut held: BTreeMap<usize, Vec<(usize, String, Bounds)>> = BTreeMap::new();
    let meshes = mesh.parts.iter().map(|p| p.mesh).max().map_or(0, |m| m + 1);
    for index in 0..meshes {
        let Some(Held { joint, slot }) = held_by(rig, mesh, index) else {
            continue;
        };
        let vertices = || vertices_of(mesh, index);
        let Some(part) = mesh.parts.iter().find(|p| p.mesh == index) else {
            continue;
        };
        // In model space, at rest.
        let place = |v: usize| {
            let binding = usize::from(mesh.binding_indices[v * mesh.influences]);
            let bind = mesh.bindings[binding].inverse_bind;
            (rest.matrices[joint] * bind).transform_point3(mesh.positions[v])
        };
        let places = vertices().map(place).map(|p| (p, p));
        let bounds = Bounds::around(places);
        let own = bounds.map(|bounds| (index, part.name.clone(), bounds));
        held.entry(slot).or_default().extend(own);
    }
    let mut found = Vec::new();
    for (joint, mut left) in held {
        while let Some((_, _, first)) = left.first() {
            let first = *first;
            let (same, others): (Vec<_>, Vec<_>) = left
                .into_iter()
                .partition(|(_, _, bounds)| are_in_one_place(&first, bounds));
            if same.len() > 1 {
                found.push(AlternativeMeshes {
                    joint: rig.name(joint).to_owned(),
                    meshes: same.into_iter().map(|(_, name, _)| name).collect(),
                });
            }
            left = others;
        }
    }
    found
}

/// Where a mesh hangs.
struct Held {
    /// The joint of all its vertices.
    joint: usize,
    /// The joint of the skeleton that moves it.
    slot: usize,
}

/// Where a mesh hangs that is wholly on one joint which is no part of a body; `None` for others.
fn held_by(rig: &Rig, mesh: &Mesh, index: usize) -> Option<Held> {
    let joints = vertices_of(mesh, index).flat_map(|v| mesh.influences_of(v));
    let mut joints = joints.map(|(joint, _)| joint);
    let joint = joints.next()?;
    let slot = slot_of(rig, joint);
    let is_held = rig.articulation().joints[slot].hanim.is_none();
    (is_held && joints.all(|other| other == joint)).then_some(Held { joint, slot })
}

fn vertices_of(mesh: &Mesh, index: usize) -> impl Iterator<Item = usize> {
    let parts = mesh.parts.iter().filter(move |p| p.mesh == index);
    parts.flat_map(|p| p.vertices.clone())
}

/// Vertices of all meshes that hang on a joint which is no part of a body, such as a slot for weapons.
pub(super) fn held_vertices(rig: &Rig, mesh: &Mesh) -> Vec<usize> {
    let meshes = mesh.parts.iter().map(|p| p.mesh).max().map_or(0, |m| m + 1);
    let held = (0..meshes).filter(|index| held_by(rig, mesh, *index).is_some());
    held.flat_map(|index| vertices_of(mesh, index)).collect()
}

/// The joint of the skeleton that moves a joint: the node of a mesh that hangs on it is a joint of its own.
fn slot_of(rig: &Rig, joint: usize) -> usize {
    let is_drawn = |j: &usize| rig.skin_joints().contains(*j);
    let mut chain = std::iter::successors(Some(joint), |j| rig.parent(*j));
    chain.find(is_drawn).unwrap_or(joint)
}

/// Whether most of the smaller box lies in the other.
fn are_in_one_place(a: &Bounds, b: &Bounds) -> bool {
    let size = |low: Vec3, high: Vec3| (high - low).max(Vec3::ZERO);
    let volume = |size: Vec3| size.x * size.y * size.z;
    let both = volume(size(a.low.max(b.low), a.high.min(b.high)));
    let smaller = volume(size(a.low, a.high)).min(volume(size(b.low, b.high)));
    // A flat box has no volume.
    a == b || both > 0.0 && both >= SHARED * smaller
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::source::{Joint, Primitive, RawMesh, Skeleton, Skin};
    use articula_core::{Articulation, JointArticulation, Region, Transform};
    use glam::Affine3A;

    /// A skeleton of a hand and a slot in it, and the node of a mesh.
    fn rig() -> Rig {
        let joint = |name: &str, parent| Joint {
            name: name.into(),
            parent,
            rest: Transform::IDENTITY,
            in_skin: name != "node",
        };
        let part = |hanim: Option<&str>| JointArticulation {
            hanim: hanim.map(str::to_owned),
            level: 0,
            region: Region::Hands,
        };
        let skeleton = Skeleton {
            joints: vec![
                joint("hand", None),
                joint("slot", Some(0)),
                joint("node", Some(1)),
            ],
        };
        let articulation = Articulation {
            profile: String::new(),
            joints: vec![part(Some("l_wrist")), part(None), part(None)],
        };
        Rig::new(&skeleton, articulation).unwrap()
    }

    /// A tetrahedron over a box that begins at x, wholly on one joint.
    fn held(name: &str, joint: usize, x: f32, size: f32) -> RawMesh {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        RawMesh {
            name: name.into(),
            skin: Skin {
                joints: vec![joint],
                inverse_bind: vec![Affine3A::IDENTITY],
            },
            primitives: vec![Primitive {
                positions: corners.map(|c| c * size + Vec3::X * x).to_vec(),
                normals: vec![Vec3::Z; 4],
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                influences: 1,
                joints: vec![0; 4],
                weights: vec![1.0; 4],
                ..Primitive::default()
            }],
            ..RawMesh::default()
        }
    }

    #[test]
    fn what_hangs_in_one_place_on_a_slot_is_a_choice() {
        let meshes = [
            held("shield", 1, 0.0, 1.0),
            held("torch", 1, 3.0, 1.0),
            held("large shield", 2, -0.2, 1.5),
            held("glove", 0, 0.0, 1.0),
            held("ring", 0, 0.0, 0.9),
        ];
        let mesh = Mesh::new(&meshes, 3).unwrap();
        let found = alternative_meshes(&rig(), &mesh);
        let shields = AlternativeMeshes {
            joint: "slot".into(),
            meshes: ["shield", "large shield"].map(str::to_owned).to_vec(),
        };
        assert_eq!(found, [shields]);
        // The shields and the torch, of four vertices each.
        assert_eq!(held_vertices(&rig(), &mesh), (0..12).collect::<Vec<_>>());
        assert_eq!(alternative_meshes(&rig(), &Mesh::default()), []);
    }
}
