//! Triangles of corners: what geometry nodes become before vertices are made of them.

use super::scene::NodeId;
use glam::{DVec2, DVec3, DVec4};

/// A corner has no such value of its own.
pub(super) const NONE: u32 = u32::MAX;

/// One corner of a triangle: where its values stand in the lists of [`Faces`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Corner {
    pub(super) point: u32,
    pub(super) texcoord: u32,
    pub(super) normal: u32,
    pub(super) color: u32,
}

/// A geometry with its lists, before vertices are made of corners.
#[derive(Debug, Default)]
pub(super) struct Faces {
    /// The node of the coordinates, if the file has one.
    pub(super) coord: Option<NodeId>,
    pub(super) points: Vec<DVec3>,
    pub(super) texcoords: Vec<DVec2>,
    pub(super) normals: Vec<DVec3>,
    pub(super) colors: Vec<DVec4>,
    pub(super) triangles: Vec<[Corner; 3]>,
    /// The face that each triangle is part of.
    pub(super) face_of_triangle: Vec<u32>,
    /// Normal of each face, as long as twice its area.
    pub(super) face_normals: Vec<DVec3>,
    /// Whether triangles turn counter-clockwise as the file has them.
    pub(super) ccw: bool,
    /// Whether the back is not drawn.
    pub(super) solid: bool,
    /// Faces that meet at a smaller angle are smooth, radians.
    pub(super) crease: f64,
}
