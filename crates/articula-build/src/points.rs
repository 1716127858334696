//! A fixed, seeded sample of the skin.

use crate::character::Asset;
use crate::split_mix::SplitMix;
use articula_core::{Clip, LocalPose, PosedMesh, Wrap, sample};
use glam::Vec3;

/// Vertices that represent the whole skin; for a rig without mesh, its joints.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Points {
    vertices: Vec<u32>,
}

impl Points {
    /// Draws `count` different vertices (all of them if there are fewer).
    pub(crate) fn draw(asset: &Asset, count: usize, seed: u64) -> Self {
        Self {
            vertices: draw_vertices(asset.mesh.len(), count, seed),
        }
    }

    /// Model-space positions under a local pose, without morph targets.
    pub(crate) fn posed(&self, asset: &Asset, pose: &LocalPose) -> Vec<Vec3> {
        let mut posed = PosedMesh::new(&asset.rig, &asset.mesh);
        posed.pose(pose);
        if asset.mesh.is_empty() {
            let joints = 0..asset.rig.len();
            return joints.map(|j| posed.model.position(j)).collect();
        }
        let mut out = vec![Vec3::ZERO; self.vertices.len()];
        posed.points(&self.vertices, &mut out);
        out
    }

    /// Model-space positions at a time of a clip.
    pub(crate) fn at(&self, asset: &Asset, clip: &Clip, time_secs: f64) -> Vec<Vec3> {
        let mut pose = asset.rig.rest_pose().clone();
        sample(clip, time_secs, Wrap::Clamp, &asset.rig.all(), &mut pose);
        self.posed(asset, &pose)
    }
}

/// Returns a random sample of `count` different indices below `total` (all of them if there are
/// fewer), in ascending order.
pub fn draw_vertices(total: usize, count: usize, seed: u64) -> Vec<u32> {
    let mut vertices: Vec<u32> = (0..total as u32).collect();
    let mut random = SplitMix(seed);
    // Partial Fisher-Yates: the first `count` entries hold the sample.
    for i in 0..count.min(total) {
        let j = i + random.below(total - i);
        vertices.swap(i, j);
    }
    vertices.truncate(count);
    vertices.sort_unstable();
    vertices
}
