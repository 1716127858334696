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
