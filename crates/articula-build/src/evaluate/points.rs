//! A fixed, seeded sample of the skin.

use crate::character::Asset;
use crate::split_mix::SplitMix;
use articula_core::{
    Clip, LocalPose, ModelPose, Wrap, local_to_model, palette, sample, skin_points,
};
use glam::{Affine3A, Vec3};

/// Vertices that stand for the whole skin; for a rig without mesh, its joints.
#[derive(Debug, Clone, PartialEq)]
pub struct Points {
    vertices: Vec<u32>,
}

impl Points {
    /// Draws `count` different vertices (all of them if there are fewer).
    pub fn draw(asset: &Asset, count: usize, seed: u64) -> Self {
        Self {
            vertices: draw_vertices(asset.mesh.len(), count, seed),
        }
    }

    /// Model-space positions under a local pose, without morph targets.
    pub fn posed(&self, asset: &Asset, pose: &LocalPose) -> Vec<Vec3> {
        let mut model = ModelPose::new(asset.rig.len());
        local_to_model(&asset.rig, pose, &mut model);
        if asset.mesh.is_empty() {
            return (0..asset.rig.len()).map(|j| model.position(j)).collect();
        }
        let mut matrices = vec![Affine3A::IDENTITY; asset.mesh.bindings.len()];
        palette(&asset.mesh, &model, &mut matrices);
        let mut out = vec![Vec3::ZERO; self.vertices.len()];
        skin_points(&asset.mesh, &matrices, &self.vertices, &mut out);
        out
    }

    /// Model-space positions at a time of a clip.
    pub fn at(&self, asset: &Asset, clip: &Clip, time_secs: f64) -> Vec<Vec3> {
        let mut pose = asset.rig.rest_pose().clone();
        sample(clip, time_secs, Wrap::Clamp, &asset.rig.all(), &mut pose);
        self.posed(asset, &pose)
    }
}

/// Draws `count` different indices below `total` (all of them if there are fewer), rising.
pub(crate) fn draw_vertices(total: usize, count: usize, seed: u64) -> Vec<u32> {
    let mut vertices: Vec<u32> = (0..total as u32).collect();
    let mut random = SplitMix(seed);
    // Partial Fisher-Yates: the first `count` places hold the sample.
    for i in 0..count.min(total) {
        let j = i + random.below(total - i);
        vertices.swap(i, j);
    }
    vertices.truncate(count);
    vertices.sort_unstable();
    vertices
}
