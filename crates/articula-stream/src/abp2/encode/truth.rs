//! The motion to be coded: local values of every joint and morph target at every frame.

use crate::abp2::pose_unit::Kind;
use articula_core::{Clip, LocalPose, Mesh, Rig, Track};
use glam::{DQuat, Quat, Vec3};
use std::ops::Range;

/// Local values at every frame; index `frame * joints + joint`, and the same of morph targets.
#[derive(Debug, Clone)]
pub(super) struct Truth {
    pub(super) frames: usize,
    pub(super) joints: usize,
    pub(super) targets: usize,
    pub(super) rotations: Vec<Quat>,
    pub(super) translations: Vec<Vec3>,
    pub(super) scales: Vec<Vec3>,
    pub(super) weights: Vec<f32>,
}

impl Truth {
    pub(super) fn new(rig: &Rig, mesh: &Mesh, clip: &Clip) -> Self {
        let (frames, joints) = (clip.frames(), rig.len());
        let targets = mesh.morph_weights.len();
        let rest = rig.rest_pose();
        let mut truth = Self {
            frames,
            joints,
            targets,
            rotations: rest.rotations.repeat(frames),
            translations: rest.translations.repeat(frames),
            scales: rest.scales.repeat(frames),
            weights: mesh.morph_weights.repeat(frames),
        };
        let tracks = clip.tracks();
        spread(&tracks.rotations, &mut truth.rotations, joints);
        spread(&tracks.translations, &mut truth.translations, joints);
        spread(&tracks.scales, &mut truth.scales, joints);
        spread(&tracks.morphs, &mut truth.weights, targets);
        truth
    }

    /// The same values with others at every frame: what was decoded.
    pub(super) fn pose(&self, frame: usize, out: &mut LocalPose) {
        let of_frame = frame * self.joints..(frame + 1) * self.joints;
        out.rotations
            .copy_from_slice(&self.rotations[of_frame.clone()]);
        out.translations
            .copy_from_slice(&self.translations[of_frame.clone()]);
        out.scales.copy_from_slice(&self.scales[of_frame]);
    }

    /// Weights of the morph targets at a frame.
    pub(super) fn weights(&self, frame: usize) -> &[f32] {
        &self.weights[frame * self.targets..(frame + 1) * self.targets]
    }

    /// Gives a track at some frames the value of the frame before them.
    pub(super) fn hold(&mut self, kind: Kind, target: usize, frames: Range<usize>) {
        let before = frames.start - 1;
        let (joints, targets) = (self.joints, self.targets);
        for frame in frames {
            let [from, to] = [before, frame].map(|frame| frame * joints + target);
            match kind {
                Kind::Rotation => self.rotations[to] = self.rotations[from],
                Kind::Translation => self.translations[to] = self.translations[from],
                Kind::Scale => self.scales[to] = self.scales[from],
                Kind::Morph => {
                    let [from, to] = [before, frame].map(|frame| frame * targets + target);
                    self.weights[to] = self.weights[from];
                }
            }
        }
    }

    /// The rotation of a joint at a frame in double precision.
    pub(super) fn rotation(&self, frame: usize, joint: usize) -> DQuat {
        self.rotations[frame * self.joints + joint]
            .as_dquat()
            .normalize()
    }
}

fn spread<T: Copy>(tracks: &[Track<T>], out: &mut [T], width: usize) {
    for track in tracks {
        let target = usize::from(track.target);
        if target >= width {
            continue;
        }
        for (frame, out) in out.chunks_mut(width).enumerate() {
            out[target] = track.values[frame.min(track.values.len() - 1)];
        }
    }
}
