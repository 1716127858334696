//! Triangles, their skin and their morph targets.

use crate::clustered::ClusteredTriangles;
use glam::{Affine3A, Vec2, Vec3, Vec4};

/// Which joints move a mesh.
///
/// A mesh that a file hangs rigidly on a node has one joint and an identity inverse bind
/// matrix: one rule for both kinds.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Skin {
    /// Skeleton joints; a vertex's joint numbers index this list.
    pub joints: Vec<usize>,
    /// Joint-from-mesh matrix at rest, one for each entry of `joints`.
    pub inverse_bind: Vec<Affine3A>,
}

/// Displacements that a weight blends in before skinning.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MorphTarget {
    /// Position offsets in mesh space, one for each vertex.
    pub positions: Vec<Vec3>,
    /// Normal offsets, one for each vertex, or empty.
    pub normals: Vec<Vec3>,
}

/// One drawable part with one material.
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
    /// Influences a vertex, at least 1.
    pub influences: usize,
    /// `positions.len() * influences` indices into [`Skin::joints`].
    pub joints: Vec<u16>,
    /// As many weights, not negative, summing to 1 for each vertex.
    pub weights: Vec<f32>,
    /// One for each of the mesh's morph targets.
    pub morphs: Vec<MorphTarget>,
    /// Counter-clockwise triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Index into the character's materials.
    pub material: Option<usize>,
}

/// A coarser form of a [`RawMesh`], to be shown in its place when it is small on the screen.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MeshLevel {
    /// What moves it.
    pub skin: Skin,
    /// Its drawable parts, each with as many morph targets as the mesh has, or each with none.
    pub primitives: Vec<Primitive>,
    /// Least share of the screen that it is made for, if the file says so.
    pub screen_coverage: Option<f32>,
}

/// A mesh as one node shows it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RawMesh {
    /// Name of the node or, without one, of the mesh.
    pub name: String,
    /// What moves it.
    pub skin: Skin,
    /// Its drawable parts.
    pub primitives: Vec<Primitive>,
    /// Name of each morph target (may be empty strings).
    pub morph_names: Vec<String>,
    /// Weight of each morph target at rest.
    pub morph_weights: Vec<f32>,
    /// Least share of the screen that the parts above are made for, if the file says so.
    pub screen_coverage: Option<f32>,
    /// Coarser forms of the same, the finest first.
    pub levels: Vec<MeshLevel>,
    /// One for each primitive, or none: levels over its own vertices, the finest of them its
    /// triangles. Who changes vertices or triangles of a primitive clears it.
    pub clustered: Vec<ClusteredTriangles>,
}
