//! Options of `prepare`.

use super::part::PreparedPart;
use crate::mesh_levels::{MeshLevelOptions, coarser_levels};
use articula_core::feature_points::PointId;
use articula_core::source::RawMesh;
use articula_stream::abp2::MotionOptions;
use glam::Vec3;

/// Options of [`prepare`](crate::prepare()).
#[derive(Debug, Clone, PartialEq)]
pub struct PrepareOptions {
    /// Seed of the samples of vertices and frames.
    pub seed: u64,
    /// Mesh levels of the asset.
    pub mesh_levels: PreparedMeshLevels,
    /// Options of motion streams (ABP-2) that are stored beside the keys of each clip; `None` stores
    /// none. The hash of the rig is set.
    pub compact_clips: Option<MotionOptions>,
    /// Parts that are left out.
    pub without: Vec<PreparedPart>,
    /// Feature points of the face that are known, with their places in model space; the others are
    /// found.
    pub face_points: Vec<(PointId, Vec3)>,
}

/// Mesh levels that an asset is prepared with.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum PreparedMeshLevels {
    /// Those of the file or, if it has none, those that crowds are shown with
    /// ([`MeshLevelOptions::for_crowds`]).
    #[default]
    ForCrowds,
    /// Those of the file alone.
    OfFile,
    /// New ones, instead of those of the file.
    New(MeshLevelOptions),
}

impl PreparedMeshLevels {
    /// Options of the levels that are to be made of these meshes, if any.
    pub(super) fn made_of(&self, meshes: &[RawMesh]) -> Option<MeshLevelOptions> {
        match self {
            Self::ForCrowds if meshes.iter().any(|m| coarser_levels(m) > 0) => None,
            Self::ForCrowds => {
                let primitives = meshes.iter().flat_map(|mesh| &mesh.primitives);
                let triangles = primitives.map(|p| p.triangles.len()).sum();
                let options = MeshLevelOptions::for_crowds(triangles);
                (options.targets.len() > 1).then_some(options)
            }
            Self::OfFile => None,
            Self::New(options) => Some(options.clone()),
        }
    }
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
            mesh_levels: PreparedMeshLevels::default(),
            compact_clips: None,
            without: Vec::new(),
            face_points: Vec::new(),
        }
    }
}
