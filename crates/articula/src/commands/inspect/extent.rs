//! How large a character is: the box around its skin, at rest and over a clip.
//!
//! Stored positions may be of another scale than what is seen, so boxes are always taken
//! after skinning; without a mesh they are taken around the joints.

use articula_build::Asset;
use articula_core::{
    LocalPose, ModelPose, SkinnedMesh, Wrap, local_to_model, palette, sample, sample_morphs, skin,
};
use glam::{Affine3A, Vec3};
use serde::Serialize;

/// Most frames of a clip that are looked at.
const MOST_FRAMES: usize = 64;

/// A box in model space.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Extent {
    /// Least corner, metres.
    pub(super) min_m: [f32; 3],
    /// Greatest corner, metres.
    pub(super) max_m: [f32; 3],
}

impl Extent {
    /// Edge lengths, metres.
    pub(super) fn size(&self) -> Vec3 {
        Vec3::from(self.max_m) - Vec3::from(self.min_m)
    }
}

/// Poses a character and measures it; keeps its buffers.
pub(super) struct Measure<'a> {
    asset: &'a Asset,
    local: LocalPose,
    model: ModelPose,
    matrices: Vec<Affine3A>,
    skinned: SkinnedMesh,
    morphs: Vec<f32>,
}

impl<'a> Measure<'a> {
    pub(super) fn new(asset: &'a Asset) -> Self {
        Self {
            asset,
            local: asset.rig.rest_pose().clone(),
            model: ModelPose::new(asset.rig.len()),
            matrices: vec![Affine3A::IDENTITY; asset.mesh.bindings.len()],
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

    /// The box around a clip, over at most 64 of its frames.
    pub(super) fn clip(&mut self, clip: usize) -> Option<Extent> {
        let clip = &self.asset.clips[clip];
        let frames = clip.frames().min(MOST_FRAMES);
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
        local_to_model(&self.asset.rig, &self.local, &mut self.model);
        if self.asset.mesh.is_empty() {
            let joints = self.asset.rig.skin_joints().iter();
            let places = joints.map(|j| self.model.position(j));
            return places
                .map(|p| (p, p))
                .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        }
        palette(&self.asset.mesh, &self.model, &mut self.matrices);
        skin(
            &self.asset.mesh,
            &self.matrices,
            &self.morphs,
            &mut self.skinned,
        );
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
