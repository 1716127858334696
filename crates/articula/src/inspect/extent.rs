//! Size of a character: bounding box of its skin, at rest and over a clip.
//!
//! Stored positions may have another scale than the skinned character, so boxes are computed after
//! skinning, or around the joints if there is no mesh.

use articula_build::Asset;
use articula_core::{LocalPose, PosedMesh, SkinnedMesh, Wrap, sample, sample_morphs};
use glam::Vec3;
use serde::Serialize;

/// Maximum number of frames measured per clip.
const MAX_FRAMES: usize = 64;

/// An axis-aligned box in model space.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Extent {
    /// Minimum corner, in metres.
    pub min_m: [f32; 3],
    /// Maximum corner, in metres.
    pub max_m: [f32; 3],
}

impl Extent {
    /// Returns the edge lengths in metres.
    pub fn size(&self) -> Vec3 {
        Vec3::from(self.max_m) - Vec3::from(self.min_m)
    }
}

/// Poses a character and measures it; reuses its buffers.
pub(super) struct Measure<'a> {
    asset: &'a Asset,
    local: LocalPose,
    posed: PosedMesh<'a>,
    skinned: SkinnedMesh,
    morphs: Vec<f32>,
}

impl<'a> Measure<'a> {
    pub(super) fn new(asset: &'a Asset) -> Self {
        Self {
            asset,
            local: asset.rig.rest_pose().clone(),
            posed: PosedMesh::new(&asset.rig, &asset.mesh),
            skinned: SkinnedMesh::new(&asset.mesh),
            morphs: asset.mesh.morph_weights.clone(),
        }
    }

    /// The box at rest; `None` if it is not finite.
    pub(super) fn rest(&mut self) -> Option<Extent> {
        self.local.copy_from(self.asset.rig.rest_pose());
        self.morphs.copy_from_slice(&self.asset.mesh.morph_weights);
        extent(self.corners())
    }

    /// The box over a clip, measured at up to 64 of its frames.
    pub(super) fn clip(&mut self, clip: usize) -> Option<Extent> {
        let clip = &self.asset.clips[clip];
        let frames = clip.frames().min(MAX_FRAMES);
        let mut corners: Option<(Vec3, Vec3)> = None;
        for i in 0..frames {
            let share = i as f64 / (frames - 1).max(1) as f64;
            let time = share * f64::from(clip.duration_secs());
            self.local.copy_from(self.asset.rig.rest_pose());
            self.morphs.copy_from_slice(&self.asset.mesh.morph_weights);
            let all = self.asset.rig.all();
            sample(clip, time, Wrap::Clamp, &all, &mut self.local);
            sample_morphs(clip, time, Wrap::Clamp, &mut self.morphs);
            let (low, high) = self.corners()?;
            corners = Some(match corners {
                Some((l, h)) => (l.min(low), h.max(high)),
                None => (low, high),
            });
        }
        extent(corners)
    }

    fn corners(&mut self) -> Option<(Vec3, Vec3)> {
        self.posed.pose(&self.local);
        if self.asset.mesh.is_empty() {
            let joints = self.asset.rig.skin_joints().iter();
            let places = joints.map(|j| self.posed.model.position(j));
            return places
                .map(|p| (p, p))
                .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        }
        self.posed.skin(&self.morphs, &mut self.skinned);
        self.skinned.bounds()
    }
}

fn extent(corners: Option<(Vec3, Vec3)>) -> Option<Extent> {
    let (low, high) = corners?;
    (low.is_finite() && high.is_finite()).then(|| Extent {
        min_m: low.into(),
        max_m: high.into(),
    })
}
