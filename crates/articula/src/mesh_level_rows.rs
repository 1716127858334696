//! Sizes and errors of mesh levels, under the names of the JSON reports (`docs/commands.md`).

use crate::mesh_levels::CodedMeshLevels;
use serde::Serialize;

/// Sizes and errors of one mesh level. Errors are `None` for a level without triangles.
#[derive(Debug, Clone, Serialize)]
pub struct MeshLevelRow {
    /// Number of the level; 0 is the finest.
    pub level: usize,
    /// Number of triangles.
    pub triangles: u64,
    /// Number of vertices.
    pub vertices: u64,
    /// Maximum distance from the original surface to the level at rest, in metres.
    pub error_rest_m: Option<f32>,
    /// The same over poses that were not used for simplification.
    pub error_motion_m: Option<f32>,
    /// 99th percentile over the surface, and poses.
    pub error_motion_p99_m: Option<f32>,
    /// Mean over the surface and poses.
    pub error_motion_mean_m: Option<f32>,
    /// Bytes of this level coded alone; 0 if it was not.
    pub bytes_direct: usize,
    /// Bytes that this level adds to the next coarser one in the stream.
    pub bytes_added: usize,
    /// Number of index ranges that show the level, over all parts.
    pub ranges: usize,
}

/// Bytes of all mesh levels together.
#[derive(Debug, Clone, Serialize)]
pub struct MeshLevelBytes {
    /// The whole stream: its header and the additions of every level.
    pub clustered: usize,
    /// The finest level, coded alone.
    pub finest_alone: usize,
    /// Sum of all levels, each coded alone.
    pub discrete_sum: usize,
    /// The meshes in the asset, not coded: vertices once, triangles of all levels.
    pub store: usize,
}

impl CodedMeshLevels {
    /// Returns sizes and errors of the levels, finest first.
    pub fn rows(&self) -> Vec<MeshLevelRow> {
        let finite = |metres: f32| metres.is_finite().then_some(metres);
        let objects = || self.levels.objects.iter();
        let rows = self.levels.table.levels.iter().enumerate();
        rows.map(|(l, row)| MeshLevelRow {
            level: l,
            triangles: row.triangles,
            vertices: row.vertices,
            error_rest_m: finite(row.rest.max_metres),
            error_motion_m: finite(row.motion.max_metres),
            error_motion_p99_m: finite(row.motion.p99_metres),
            error_motion_mean_m: finite(row.motion.mean_metres),
            bytes_direct: self.stream.direct.get(l).copied().unwrap_or(0),
            bytes_added: self.stream.chunks[l],
            ranges: objects().map(|o| o.clusters.ranges(l).count()).sum(),
        })
        .collect()
    }

    /// Returns sizes of all levels; `store` is the size of the meshes in the asset.
    pub fn sizes(&self, store: usize) -> MeshLevelBytes {
        let direct = &self.stream.direct;
        MeshLevelBytes {
            clustered: self.stream.bytes.len(),
            finest_alone: direct.first().copied().unwrap_or(0),
            discrete_sum: direct.iter().sum(),
            store,
        }
    }

    /// Returns the number of poses on which errors in motion were measured.
    pub fn poses_measured(&self) -> usize {
        let on = self.levels.measured;
        on.clips + on.bends + on.morphs
    }
}
