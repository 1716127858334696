//! The two-step metric of the thesis, a baseline: error matrix and distance threshold.
//!
//! Source: thesis 5.2; reconstruction and limits in `docs/methods/motion-lod.md` part 3. The matrix
//! is computed by [`thesis`](super::thesis); this is the step that runs while the clip plays.

use articula_core::joint_state::{JointState, JointStates};
use articula_core::{LocalPose, Mismatch};

/// Normalised error of every joint at every frame.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ErrorMatrix {
    joints: usize,
    values: Vec<f32>,
}

impl ErrorMatrix {
    /// Creates a matrix from `joints` values per frame.
    ///
    /// # Errors
    /// A [`Mismatch`] if the values are not whole frames.
    pub(crate) fn new(joints: usize, values: Vec<f32>) -> Result<Self, Mismatch> {
        if joints == 0 || !values.len().is_multiple_of(joints) {
            let what = format!(
                "{} values are not a whole number of frames of {joints} joints",
                values.len()
            );
            return Err(Mismatch::new("values", what));
        }
        Ok(Self { joints, values })
    }

    /// Errors of all joints at a frame.
    pub(crate) fn frame(&self, frame: usize) -> &[f32] {
        &self.values[frame * self.joints..(frame + 1) * self.joints]
    }
}

/// Shape of the threshold between the closest and the farthest view.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ThresholdCurve {
    /// As printed: `(d/d_max)^2 thr_max + ((d_max - d)/d_max) thr_init`. It falls near the viewer
    /// before it rises.
    #[default]
    Literal,
    /// `thr_init + (thr_max - thr_init) u^2`, `u` from 0 at `d_min` to 1 at `d_max`, as the text
    /// describes.
    Fixed,
}

/// Threshold on the normalised error as a function of distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Threshold {
    /// Threshold at the closest view.
    pub thr_init: f32,
    /// Threshold at the farthest view.
    pub thr_max: f32,
    /// Closest view in metres (used by [`ThresholdCurve::Fixed`]).
    pub d_min_metres: f32,
    /// Farthest view in metres.
    pub d_max_metres: f32,
    /// Shape of the threshold between them.
    pub curve: ThresholdCurve,
}

impl Default for Threshold {
    /// The thesis' tight setting, for distances of 3.5 to 16 m.
    fn default() -> Self {
        Self {
            thr_init: 1e-4,
            thr_max: 1e-3,
            d_min_metres: 3.5,
            d_max_metres: 16.0,
            curve: ThresholdCurve::Literal,
        }
    }
}

impl Threshold {
    /// The threshold at a distance, in metres, of the camera from the skeleton's root.
    pub(crate) fn at(&self, distance_metres: f32) -> f32 {
        match self.curve {
            ThresholdCurve::Literal => {
                let x = distance_metres / self.d_max_metres;
                x * x * self.thr_max + (1.0 - x) * self.thr_init
            }
            ThresholdCurve::Fixed => {
                let span = self.d_max_metres - self.d_min_metres;
                let u = ((distance_metres - self.d_min_metres) / span).clamp(0.0, 1.0);
                self.thr_init + (self.thr_max - self.thr_init) * u * u
            }
        }
    }
}

/// Switches joints at one frame, literally as in the thesis: an active joint whose error is below
/// the threshold becomes passive, a passive one above it becomes active.
///
/// # Panics
/// If the matrix has fewer joints than the pose, or does not have the frame.
pub(crate) fn switch(
    matrix: &ErrorMatrix,
    frame: usize,
    threshold: f32,
    states: &mut JointStates,
    now_secs: f64,
    clip: &LocalPose,
) {
    for (joint, error) in matrix
        .frame(frame)
        .iter()
        .enumerate()
        .take(clip.rotations.len())
    {
        match states.state(joint) {
            JointState::Active if *error < threshold => {
                states.passivate(joint, now_secs, &clip.get(joint));
            }
            JointState::Passive if *error > threshold => states.activate(joint, now_secs),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::joint_state::TransitionOptions;
    use articula_core::{Transform, angle_between};
    use glam::Quat;

    /// Test 2 of `docs/methods/motion-lod.md` part 10.
    #[test]
    fn the_literal_curve_dips_where_paper_says() {
        for ratio in [1.0f32, 10.0] {
            let t = Threshold {
                thr_init: 1e-3,
                thr_max: 1e-3 * ratio,
                ..Threshold::default()
            };
            let dip_at = t.d_max_metres * t.thr_init / (2.0 * t.thr_max);
            let depth = t.thr_init / (4.0 * t.thr_max);
            assert!((t.at(dip_at) / t.thr_init - (1.0 - depth)).abs() < 1e-5);
            assert!(t.at(dip_at) < t.at(dip_at - 0.1) && t.at(dip_at) < t.at(dip_at + 0.1));
            assert_eq!(t.at(0.0), t.thr_init);
            assert!((t.at(t.d_max_metres) / t.thr_max - 1.0).abs() < 1e-6);
        }
    }

    /// Test 2 of `docs/methods/motion-lod.md` part 10.
    #[test]
    fn the_fixed_curve_never_falls() {
        let t = Threshold {
            curve: ThresholdCurve::Fixed,
            ..Threshold::default()
        };
        let at: Vec<f32> = (0..200).map(|i| t.at(i as f32 * 0.1)).collect();
        assert!(at.windows(2).all(|w| w[1] >= w[0]));
        assert_eq!((t.at(3.5), t.at(16.0)), (1e-4, 1e-3));
    }

    #[test]
    fn a_slow_turn_is_never_followed_by_the_thesis() {
        // One degree per second for a minute.
        let wanted = |i: usize| {
            let turned = Transform {
                rotation: Quat::from_rotation_x((i as f32 / 30.0).to_radians()),
                ..Transform::IDENTITY
            };
            LocalPose::from_iter([turned])
        };
        // The thesis compares neighbouring frames. Its values are divided by the clip's maximum;
        // one quick joint in the same clip puts the slow one permanently below every threshold.
        let slow_of_quick = (1.0f32 / 30.0).to_radians() / 2.0f32.to_radians() * 0.01;
        let frames = 60 * 30 + 1;
        let matrix = ErrorMatrix::new(1, vec![slow_of_quick; frames]).unwrap();
        let rest = LocalPose::from_iter([Transform::IDENTITY]);
        let at_once = TransitionOptions {
            secs: 0.0,
            ..TransitionOptions::default()
        };
        let mut states = JointStates::new(&rest, at_once);
        let mut worst: f32 = 0.0;
        for i in 0..frames {
            let (secs, pose) = (i as f64 / 30.0, wanted(i));
            switch(&matrix, i, 1e-3, &mut states, secs, &pose);
            let shown = states.step(secs, &pose).rotations[0];
            worst = worst.max(angle_between(shown, pose.rotations[0]));
        }
        assert_eq!(states.state(0), JointState::Passive);
        assert!(
            worst > 59.0f32.to_radians(),
            "frozen at the first frame, {worst} rad away at last"
        );
    }
}
