//! Motion of a portrait: angles of the head and weights of expressions over time.

use super::head::{Head, HeadPose, PortraitExpression};
use articula_core::{Clip, ModelPose, Rig, Wrap, local_to_model, sample, sample_morphs};
use glam::Quat;

/// A clip of head angles and expression weights at a uniform rate.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PortraitClip {
    /// Name of the clip.
    pub name: String,
    /// Frames per second.
    pub rate_hz: f32,
    /// Angles of the head in each frame.
    pub poses: Vec<HeadPose>,
    /// Weights of all expressions of the portrait in each frame.
    pub weights: Vec<Vec<f32>>,
}

impl PortraitClip {
    /// Samples a clip of the character. An expression takes the weight of its first morph slot; the
    /// head's angles are those of its last joint relative to rest, or of the rig's root if the
    /// whole figure turns.
    ///
    /// # Panics
    /// If the clip belongs to another rig.
    pub fn sample(
        clip: &Clip,
        rig: &Rig,
        rest_weights: &[f32],
        head: &Head,
        expressions: &[PortraitExpression],
    ) -> Self {
        let joint = match head {
            Head::Joints(joints) => joints.last().copied(),
            Head::Whole { .. } => (!rig.is_empty()).then(|| rig.root()),
        };
        let orientation = |model: &ModelPose| -> Quat {
            joint.map_or(Quat::IDENTITY, |j| {
                model.matrices[j].to_scale_rotation_translation().1
            })
        };
        let mut local = rig.rest_pose().clone();
        let mut model = ModelPose::new(rig.len());
        local_to_model(rig, &local, &mut model);
        let rest = orientation(&model);
        let mut out = Self {
            name: clip.name.clone(),
            rate_hz: clip.rate_hz(),
            ..Self::default()
        };
        let all = rig.all();
        for frame in 0..clip.frames() {
            let time = frame as f64 / f64::from(clip.rate_hz());
            local.copy_from(rig.rest_pose());
            sample(clip, time, Wrap::Clamp, &all, &mut local);
            local_to_model(rig, &local, &mut model);
            out.poses
                .push(HeadPose::of_rotation(orientation(&model) * rest.inverse()));
            let mut weights = rest_weights.to_vec();
            sample_morphs(clip, time, Wrap::Clamp, &mut weights);
            let weight = |e: &PortraitExpression| {
                let first = e.morphs.iter().find(|(_, full)| *full != 0.0);
                let (slot, full) = first?;
                let slot = usize::from(*slot);
                Some((weights.get(slot)? - rest_weights.get(slot)?) / full)
            };
            let of = expressions.iter().map(|e| weight(e).unwrap_or(0.0));
            out.weights.push(of.collect());
        }
        out
    }

    /// Returns head angles and weights at a time, linear between frames and clamped at the ends.
    pub fn at(&self, time_secs: f32) -> (HeadPose, Vec<f32>) {
        let last = self.poses.len().saturating_sub(1);
        let at = (time_secs * self.rate_hz).clamp(0.0, last as f32);
        let before = at as usize;
        let after = (before + 1).min(last);
        let t = at - before as f32;
        let mix = |a: f32, b: f32| a + (b - a) * t;
        let (Some(p), Some(q)) = (self.poses.get(before), self.poses.get(after)) else {
            return (HeadPose::default(), Vec::new());
        };
        let pose = HeadPose {
            yaw_degrees: mix(p.yaw_degrees, q.yaw_degrees),
            pitch_degrees: mix(p.pitch_degrees, q.pitch_degrees),
            roll_degrees: mix(p.roll_degrees, q.roll_degrees),
        };
        let weights = self.weights[before].iter().zip(&self.weights[after]);
        (pose, weights.map(|(a, b)| mix(*a, *b)).collect())
    }

    pub(crate) fn check(&self, expressions: usize) -> Result<(), String> {
        if !(self.rate_hz.is_finite() && self.rate_hz > 0.0) {
            return Err(format!(
                "rate_hz must be positive and finite, found {}",
                self.rate_hz
            ));
        }
        if self.poses.is_empty() || self.poses.len() != self.weights.len() {
            let (poses, weights) = (self.poses.len(), self.weights.len());
            return Err(format!(
                "{poses} poses and {weights} weight lists, expected the same number, at least 1"
            ));
        }
        for (frame, (pose, weights)) in self.poses.iter().zip(&self.weights).enumerate() {
            if !pose.is_finite() || weights.iter().any(|w| !w.is_finite()) {
                return Err(format!("frame {frame} is not finite"));
            }
            if weights.len() != expressions {
                let found = weights.len();
                return Err(format!(
                    "frame {frame} has {found} weights, expected {expressions}"
                ));
            }
        }
        Ok(())
    }
}
