//! The pose in which every joint is unturned and every point is given.
//!
//! That is the rest pose, if the skin lies there as it was made. If the skin was bound in
//! another pose, it is the pose of binding: only there can one list of points stand for skin
//! that several joints move. Joints then show the rest pose by their fields.

use articula_core::source::{Character, Primitive, RawMesh};
use glam::{Affine3A, DAffine3, DMat3};

/// Joint matrices of one point may differ by this share before it counts as bound elsewhere.
const SAME_BIND: f64 = 1e-4;

/// Model matrix of every joint in the pose of zero.
#[derive(Debug)]
pub(super) struct ZeroPose {
    pub(super) matrices: Vec<DAffine3>,
    /// Whether it is the pose of binding, and not that of rest.
    pub(super) is_binding: bool,
}

/// Finds the pose for a character.
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

/// Joints as the inverse bind matrices have them. The first joint of each skin that no skin
/// before it has placed stays at rest, so that the figure does.
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

/// Model-from-mesh matrix of each joint of a skin, in a pose.
pub(super) fn model_from_mesh(mesh: &RawMesh, pose: &[DAffine3]) -> Vec<DAffine3> {
    let pairs = mesh.skin.joints.iter().zip(&mesh.skin.inverse_bind);
    pairs
        .map(|(&joint, bind)| pose[joint] * affine(bind))
        .collect()
}

/// Influences of a vertex that count: entry of the skin's list, and weight.
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

/// Whether two joints carry a point to the same place.
pub(super) fn agree(a: &DAffine3, b: &DAffine3) -> bool {
    let size = a.matrix3.x_axis.length().max(1e-12);
    a.abs_diff_eq(*b, SAME_BIND * size.max(a.translation.abs().max_element()))
}

/// Vertices that follow several joints which do not carry them to the same place in a pose.
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
