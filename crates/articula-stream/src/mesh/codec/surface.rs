//! The part of a level that is known once its connectivity, matching and positions are coded.
//!
//! Source: `docs/methods/clustered-mesh.md` part 8.1 (c, e, f). The remaining values (normals,
//! texture coordinates, skins, morphs) are predicted over this surface, in the order of the ids.

/// A whole level, and the part of it that is known from a coarser one.
///
/// Points below `known_points` and wedges below `known_wedges` have all their values. New points
/// and wedges follow, in the order in which the faces first use them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surface<'a> {
    /// All faces of the level as triples of wedges, in the order of discovery.
    pub(super) faces: &'a [[u32; 3]],
    /// Point of each wedge.
    pub(super) wedge_points: &'a [u32],
    /// Number of points known from the coarser level; 0 without one.
    pub(super) known_points: usize,
    /// Number of wedges known from the coarser level; 0 without one.
    pub(super) known_wedges: usize,
}
