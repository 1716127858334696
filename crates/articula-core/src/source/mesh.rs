//! The editable form of meshes: triangles, skin and morph targets.

use crate::clustered::ClusteredTriangles;
use glam::{Affine3A, Vec2, Vec3, Vec4};

/// The joints that deform a mesh.
///
/// A mesh attached rigidly to a node has one joint and an identity inverse bind matrix, so that
/// both kinds are handled in the same way.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Skin {
    /// Joint indices of the skeleton; the joint numbers of a vertex index this list.
    pub joints: Vec<usize>,
    /// Inverse bind matrices (joint from mesh, in the rest pose), one for each entry of `joints`.
    pub inverse_bind: Vec<Affine3A>,
}

/// A morph target: vertex offsets that are scaled by a weight and added before skinning.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MorphTarget {
    /// Position offsets in mesh space, one for each vertex.
    pub positions: Vec<Vec3>,
    /// Normal offsets, one for each vertex, or empty.
    pub normals: Vec<Vec3>,
}

/// A drawable part of a mesh with one material.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Primitive {
    /// Vertex positions in mesh space.
    pub positions: Vec<Vec3>,
    /// Unit normals, one for each vertex, or empty.
    pub normals: Vec<Vec3>,
    /// First texture coordinate set, or empty.
    pub texcoords: Vec<Vec2>,
    /// Linear RGBA vertex colours, or empty.
    pub colors: Vec<Vec4>,
    /// Number of influences per vertex, at least 1.
    pub influences: usize,
    /// `positions.len() * influences` indices into [`Skin::joints`].
    pub joints: Vec<u16>,
    /// `positions.len() * influences` weights, not negative, summing to 1 for each vertex.
    pub weights: Vec<f32>,
    /// One entry for each morph target of the mesh.
    pub morphs: Vec<MorphTarget>,
    /// Vertex indices of the triangles, counter-clockwise.
    pub triangles: Vec<[u32; 3]>,
    /// Index into the character's materials.
    pub material: Option<usize>,
}

impl Primitive {
    /// Returns the primitive with its vertices in another order, and the given triangles, which
    /// index the new vertices. `order` has the present index of each new vertex; vertices that it
    /// does not list are left out.
    ///
    /// # Panics
    /// If `order` names a vertex that does not exist, or an attribute has fewer values than there
    /// are vertices.
    #[must_use]
    pub fn reordered(&self, order: &[u32], triangles: Vec<[u32; 3]>) -> Self {
        let morph = |target: &MorphTarget| MorphTarget {
            positions: picked(&target.positions, 1, order),
            normals: picked(&target.normals, 1, order),
        };
        Self {
            positions: picked(&self.positions, 1, order),
            normals: picked(&self.normals, 1, order),
            texcoords: picked(&self.texcoords, 1, order),
            colors: picked(&self.colors, 1, order),
            influences: self.influences,
            joints: picked(&self.joints, self.influences, order),
            weights: picked(&self.weights, self.influences, order),
            morphs: self.morphs.iter().map(morph).collect(),
            triangles,
            material: self.material,
        }
    }
}

/// Renumbers the joints of vertices with `influences` influences each. Weights of one vertex that come
/// to the same joint are added up, in the first of their places; the other places become joint 0
/// with weight 0, as do those that had no weight.
///
/// # Panics
/// If `influences` is 0.
pub fn renumber_influences(
    joints: &mut [u16],
    weights: &mut [f32],
    influences: usize,
    renumber: impl Fn(u16) -> u16,
) {
    let vertices = joints
        .chunks_exact_mut(influences)
        .zip(weights.chunks_exact_mut(influences));
    for (joints, weights) in vertices {
        for i in 0..influences {
            let joint = if weights[i] == 0.0 {
                0
            } else {
                renumber(joints[i])
            };
            joints[i] = joint;
            let has = |k: &usize| weights[*k] != 0.0 && joints[*k] == joint;
            let first = (0..i).find(has).filter(|_| weights[i] != 0.0);
            if let Some(first) = first {
                weights[first] += weights[i];
                (joints[i], weights[i]) = (0, 0.0);
            }
        }
    }
}

/// Selects elements of `each` values by index; empty for an absent attribute.
fn picked<T: Copy>(values: &[T], each: usize, order: &[u32]) -> Vec<T> {
    if values.is_empty() {
        return Vec::new();
    }
    let of = |v: &u32| &values[*v as usize * each..(*v as usize + 1) * each];
    order.iter().flat_map(of).copied().collect()
}

/// A coarser replacement of a [`RawMesh`], drawn when the mesh is small on the screen.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RawMeshLevel {
    /// The joints that deform it.
    pub skin: Skin,
    /// The drawable parts, each with as many morph targets as the mesh, or each with none.
    pub primitives: Vec<Primitive>,
    /// Minimum fraction of the screen for which the level is made, if the file states it.
    pub screen_coverage: Option<f32>,
}

/// The mesh of one node.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RawMesh {
    /// Name of the node or, if it has none, of the mesh.
    pub name: String,
    /// The joints that deform it.
    pub skin: Skin,
    /// The drawable parts.
    pub primitives: Vec<Primitive>,
    /// Name of each morph target; may be empty strings.
    pub morph_names: Vec<String>,
    /// Default weight of each morph target.
    pub morph_weights: Vec<f32>,
    /// Minimum fraction of the screen for which `primitives` are made, if the file states it.
    pub screen_coverage: Option<f32>,
    /// Coarser levels of the mesh, the finest first.
    pub levels: Vec<RawMeshLevel>,
    /// Empty, or one entry for each primitive: levels over the primitive's own vertices, the finest
    /// of which are its triangles. Must be cleared when vertices or triangles of a primitive
    /// change.
    pub clustered: Vec<ClusteredTriangles>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_that_come_to_one_joint_are_added_up() {
        let mut joints = vec![3, 7, 4, 9, 4, 3, 1, 0];
        let mut weights = vec![0.5, 0.0, 0.25, 0.25, 0.5, 0.25, 0.25, 0.0];
        // Joint 4 is merged into joint 3; those behind it move up.
        renumber_influences(
            &mut joints,
            &mut weights,
            4,
            |j| if j > 3 { j - 1 } else { j },
        );
        assert_eq!(joints, [3, 0, 0, 8, 3, 0, 1, 0]);
        assert_eq!(weights, [0.75, 0.0, 0.0, 0.25, 0.75, 0.0, 0.25, 0.0]);
    }
}
