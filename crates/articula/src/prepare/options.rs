//! Options of `prepare`.

use super::part::PreparedPart;
use crate::mesh_levels::MeshLevelOptions;
use articula_core::feature_points::PointId;
use articula_stream::abp2::MotionOptions;
use glam::Vec3;

/// Options of [`prepare`](crate::prepare()).
#[derive(Debug, Clone, PartialEq)]
pub struct PrepareOptions {
    /// Seed of the samples of vertices and frames.
    pub seed: u64,
    /// Options of the mesh levels. `None` makes none; those that the file has stay.
    pub mesh_levels: Option<MeshLevelOptions>,
    /// Options of motion streams (ABP-2) that are stored beside the keys of each clip; `None` stores
    /// none. The hash of the rig is set.
    pub compact_clips: Option<MotionOptions>,
    /// Parts that are left out.
    pub without: Vec<PreparedPart>,
    /// Feature points of the face that are known, with their places in model space; the others are
    /// found.
    pub face_points: Vec<(PointId, Vec3)>,
}

impl PrepareOptions {
    /// Whether a part is not left out.
    pub(crate) fn wants(&self, part: PreparedPart) -> bool {
        !self.without.contains(&part)
    }
}

impl Default for PrepareOptions {
    fn default() -> Self {
        Self {
            seed: 1,
            mesh_levels: None,
            compact_clips: None,
            without: Vec::new(),
            face_points: Vec::new(),
        }
    }
}
