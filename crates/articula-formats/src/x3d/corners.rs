//! Triangles of corners: intermediate form between geometry nodes and vertices.

use super::scene::NodeId;
use glam::{DVec2, DVec3, DVec4};

/// Index of a value that a corner does not have.
pub(super) const NONE: u32 = u32::MAX;

/// One corner of a triangle: indices of its values in the lists of [`Faces`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Corner {
    pub(super) point: u32,
    pub(super) texcoord: u32,
    pub(super) normal: u32,
    pub(super) color: u32,
}

/// A geometry with its value lists, before corners are merged into vertices.
#[derive(Debug, Default)]
pub(super) struct Faces {
    /// The coordinate node, if the file has one.
    pub(super) coord: Option<NodeId>,
    pub(super) points: Vec<DVec3>,
    pub(super) texcoords: Vec<DVec2>,
    pub(super) normals: Vec<DVec3>,
    pub(super) colors: Vec<DVec4>,
    pub(super) triangles: Vec<[Corner; 3]>,
    /// Index of the face that contains each triangle.
    pub(super) face_of_triangle: Vec<u32>,
    /// Normal of each face, with twice its area as length.
    pub(super) face_normals: Vec<DVec3>,
    /// Whether triangles are counter-clockwise in the file.
    pub(super) ccw: bool,
    /// Whether back faces are culled.
    pub(super) solid: bool,
    /// Faces that meet at a smaller angle are shaded smoothly, in radians.
    pub(super) crease: f64,
}
