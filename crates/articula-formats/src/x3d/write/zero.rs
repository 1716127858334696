//! The pose in which every joint is unrotated and every point is written.
//!
//! This is the rest pose, if the skin was bound in it. If the skin was bound in another pose, it is
//! the binding pose: only there can one list of points represent skin that several joints move. The
//! fields of the joints then restore the rest pose.

use articula_core::source::{Character, Primitive, RawMesh};
use glam::{Affine3A, DAffine3, DMat3};

/// Relative difference of the joint matrices of one point from which it counts as bound in another
/// pose.
const SAME_BIND: f64 = 1e-4;

/// Model matrix of every joint in the zero pose.
#[derive(Debug)]
pub(super) struct ZeroPose {
    pub(super) matrices: Vec<DAffine3>,
    /// Whether it is the binding pose instead of the rest pose.
    pub(super) is_binding: bool,
}

/// Determines the zero pose of a character.
pub(super) fn zero_pose(character: &Character) -> ZeroPose {
    let rest = rest_pose(character);
    if character
        .meshes
        .iter()
        .all(|mesh| loose_vertices(mesh, &rest) == 0)
    {
        return ZeroPose {
            matrices: rest,
            is_binding: false,
        };
    }
    ZeroPose {
        matrices: binding_pose(character, &rest),
        is_binding: true,
    }
}

fn rest_pose(character: &Character) -> Vec<DAffine3> {
    let mut matrices: Vec<DAffine3> = Vec::new();
    for index in 0..character.skeleton.joints.len() {
        let joint = &character.skeleton.joints[index];
        let local = local(character, index);
        matrices.push(joint.parent.map_or(local, |p| matrices[p] * local));
    }
    matrices
}

fn local(character: &Character, joint: usize) -> DAffine3 {
    let rest = &character.skeleton.joints[joint].rest;
    DAffine3::from_scale_rotation_translation(
        rest.scale.as_dvec3(),
        rest.rotation.as_dquat().normalize(),
        rest.translation.as_dvec3(),
    )
}

/// Returns the pose given by the inverse bind matrices. The first joint of each skin that no
/// earlier skin has placed stays at rest, so that the figure stays in place.
fn binding_pose(character: &Character, rest: &[DAffine3]) -> Vec<DAffine3> {
    let mut bound: Vec<Option<DAffine3>> = vec![None; rest.len()];
    for mesh in &character.meshes {
        let skin = &mesh.skin;
        let pairs = || skin.joints.iter().zip(&skin.inverse_bind);
        let known = pairs().find_map(|(&joint, bind)| Some(bound[joint]? * affine(bind)));
        let first = pairs().min_by_key(|(joint, _)| **joint);
        let placed = known.or_else(|| first.map(|(&joint, bind)| rest[joint] * affine(bind)));
        let Some(model_from_mesh) = placed else {
            continue;
        };
        for (&joint, bind) in pairs() {
            let inverse = affine(bind).inverse();
            if inverse.is_finite() {
                bound[joint].get_or_insert(model_from_mesh * inverse);
            }
        }
    }
    let mut matrices: Vec<DAffine3> = Vec::new();
    for (index, joint) in character.skeleton.joints.iter().enumerate() {
        let above = joint.parent.map_or(DAffine3::IDENTITY, |p| matrices[p]);
        matrices.push(bound[index].unwrap_or_else(|| above * local(character, index)));
    }
    matrices
}

/// Returns the model-from-mesh matrix of each joint of a skin, in a pose.
pub(super) fn model_from_mesh(mesh: &RawMesh, pose: &[DAffine3]) -> Vec<DAffine3> {
    let pairs = mesh.skin.joints.iter().zip(&mesh.skin.inverse_bind);
    pairs
        .map(|(&joint, bind)| pose[joint] * affine(bind))
        .collect()
}

/// Returns the non-zero influences of a vertex: index in the skin's list, and weight.
pub(super) fn influences(
    primitive: &Primitive,
    vertex: usize,
) -> impl Iterator<Item = (usize, f32)> + Clone + '_ {
    let range = vertex * primitive.influences..(vertex + 1) * primitive.influences;
    let joints = &primitive.joints[range.clone()];
    let pairs = joints.iter().zip(&primitive.weights[range]);
    pairs
        .map(|(joint, weight)| (usize::from(*joint), *weight))
        .filter(|(_, weight)| *weight > 0.0)
}

/// Returns whether two joints move a point to the same position.
pub(super) fn agree(a: &DAffine3, b: &DAffine3) -> bool {
    let size = a.matrix3.x_axis.length().max(1e-12);
    a.abs_diff_eq(*b, SAME_BIND * size.max(a.translation.abs().max_element()))
}

/// Returns the number of vertices whose joints do not agree on their position in a pose.
pub(super) fn loose_vertices(mesh: &RawMesh, pose: &[DAffine3]) -> usize {
    let matrices = model_from_mesh(mesh, pose);
    let is_loose = |primitive: &Primitive, vertex: usize| {
        let mut moved = influences(primitive, vertex);
        let Some((first, _)) = moved.next() else {
            return false;
        };
        !moved.all(|(other, _)| agree(&matrices[first], &matrices[other]))
    };
    let of = |p: &Primitive| (0..p.positions.len()).filter(|v| is_loose(p, *v)).count();
    mesh.primitives.iter().map(of).sum()
}

fn affine(matrix: &Affine3A) -> DAffine3 {
    let axes = [
        matrix.matrix3.x_axis,
        matrix.matrix3.y_axis,
        matrix.matrix3.z_axis,
    ];
    let [x, y, z] = axes.map(|axis| axis.as_dvec3());
    DAffine3::from_mat3_translation(DMat3::from_cols(x, y, z), matrix.translation.as_dvec3())
}
