//! Error of a motion on all vertices, at frames and between them.

use articula_build::Asset;
use articula_core::{Clip, ModelPose, PosedMesh, SkinnedMesh, Wrap, sample_morphs};
use glam::{Affine3A, Vec3};

/// Greatest errors in millimetres.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Errors {
    /// At the frames of the clip.
    pub(super) frames_mm: f64,
    /// In the middle between two frames, both motions interpolated.
    pub(super) between_mm: f64,
}

/// A motion as it is shown.
pub(super) trait Shown {
    /// Model-space pose and morph weights at a time in seconds.
    fn pose(&mut self, secs: f64, model: &mut ModelPose, weights: &mut [f32]);
}

/// A clip of the runtime.
pub(super) struct Sampled<'a> {
    clip: &'a Clip,
    posed: PosedMesh<'a>,
}

impl<'a> Sampled<'a> {
    pub(super) fn new(asset: &'a Asset, clip: &'a Clip) -> Self {
        Self {
            clip,
            posed: PosedMesh::new(&asset.rig, &asset.mesh),
        }
    }
}

impl Shown for Sampled<'_> {
    fn pose(&mut self, secs: f64, model: &mut ModelPose, weights: &mut [f32]) {
        self.posed.pose_at(self.clip, secs, Wrap::Clamp);
        model.matrices.clone_from(&self.posed.model.matrices);
        sample_morphs(self.clip, secs, Wrap::Clamp, weights);
    }
}

/// The points of a figure's skin; of a figure without a mesh, three points around each joint.
struct Points<'a> {
    asset: &'a Asset,
    posed: PosedMesh<'a>,
    skinned: SkinnedMesh,
    around: Vec<(usize, Vec3)>,
}

impl<'a> Points<'a> {
    fn new(asset: &'a Asset) -> Self {
        let mut posed = PosedMesh::new(&asset.rig, &asset.mesh);
        posed.pose(asset.rig.rest_pose());
        let mut around = Vec::new();
        if asset.mesh.is_empty() {
            for joint in 0..asset.rig.len() {
                // As those of the encoder: docs/methods/motion-stream.md, part 1.
                let at = posed.model.position(joint);
                let children =
                    (joint + 1..asset.rig.len()).filter(|c| asset.rig.parent(*c) == Some(joint));
                let ends = children.chain(asset.rig.parent(joint));
                let length = ends.map(|end| posed.model.position(end).distance(at));
                let away = (length.fold(0.0, f32::max) / 2.0).clamp(0.03, 0.15);
                let inverse = posed.model.matrices[joint].inverse();
                let points = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| at + away * axis);
                around.extend(points.map(|p| (joint, inverse.transform_point3(p))));
            }
        }
        Self {
            asset,
            posed,
            skinned: SkinnedMesh::new(&asset.mesh),
            around,
        }
    }

    fn at(&mut self, shown: &mut dyn Shown, secs: f64) -> Vec<Vec3> {
        let mut weights = self.asset.mesh.morph_weights.clone();
        shown.pose(secs, &mut self.posed.model, &mut weights);
        if self.asset.mesh.is_empty() {
            let model = &self.posed.model;
            let point = |(joint, at): &(usize, Vec3)| model.matrices[*joint].transform_point3(*at);
            return self.around.iter().map(point).collect();
        }
        self.posed.skin(&weights, &mut self.skinned);
        self.skinned.positions.clone()
    }
}

/// Compares a motion with the clip that it stands for.
pub(super) fn errors(asset: &Asset, clip: &Clip, shown: &mut dyn Shown) -> Errors {
    let mut points = Points::new(asset);
    let mut truth = Sampled::new(asset, clip);
    let mut most = |halves: std::iter::StepBy<std::ops::Range<usize>>| {
        let mut most = 0.0_f32;
        for half in halves {
            let secs = half as f64 / (2.0 * f64::from(clip.rate_hz()));
            let expected = points.at(&mut truth, secs);
            let found = points.at(shown, secs);
            let apart = expected.iter().zip(&found).map(|(a, b)| a.distance(*b));
            most = apart.fold(most, f32::max);
        }
        1e3 * f64::from(most)
    };
    let last = 2 * (clip.frames() - 1);
    Errors {
        frames_mm: most((0..last + 1).step_by(2)),
        between_mm: most((1..last.max(1)).step_by(2)),
    }
}

/// Model matrices at rest.
pub(super) fn at_rest(asset: &Asset) -> Vec<Affine3A> {
    let mut posed = PosedMesh::new(&asset.rig, &asset.mesh);
    posed.pose(asset.rig.rest_pose());
    posed.model.matrices
}
