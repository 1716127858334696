//! What is known of a level once its connectivity, matching and positions are coded.
//!
//! Source: `docs/methods/clustered-mesh.md` 8.1 (c, e, f). The values that are left (normals, texture
//! coordinates, skins, morphs) are predicted over this surface, in the order of the ids.

/// A whole level and the part of it that is known from a coarser one.
///
/// Points below `known_points` and wedges below `known_wedges` have all their values. New points
/// and new wedges have the ids that follow, in the order in which the faces first name them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surface<'a> {
    /// Faces of wedges, all of the level, in the order in which they were discovered.
    pub(super) faces: &'a [[u32; 3]],
    /// Point of each wedge.
    pub(super) wedge_points: &'a [u32],
    /// Number of points known from the coarser level; 0 without one.
    pub(super) known_points: usize,
    /// Number of wedges known from the coarser level; 0 without one.
    pub(super) known_wedges: usize,
}
