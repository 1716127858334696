//! The metric of the thesis at run time: an error matrix and a threshold by distance.
//!
//! Source: thesis 5.2.2 and 7.2.3 (the frequency of the look-up by viewpoint); reconstruction and
//! limits in `docs/methods/motion-lod.md` part 3. The threshold is renewed at each look-up, so the
//! camera may move.

use super::controller::{ControlResult, FrameContext, MotionController};
use crate::Mismatch;
use crate::joint_set::JointSet;
use crate::joint_state::{JointState, JointStates, TransitionOptions};
use crate::key_table::TableHashes;
use crate::pose::LocalPose;
use crate::rig::Rig;
use std::sync::Arc;

/// Normalised error of every joint at every frame of a clip, or at every key of one that is sampled more densely.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorMatrix {
    joints: usize,
    values: Vec<f32>,
}

impl ErrorMatrix {
    /// Creates a matrix from `joints` values per frame.
    ///
    /// # Errors
    /// A [`Mismatch`] if the values are not whole frames.
    pub fn new(joints: usize, values: Vec<f32>) -> Result<Self, Mismatch> {
        if joints == 0 || !values.len().is_multiple_of(joints) {
            let what = format!(
                "{} values are not a whole number of frames of {joints} joints",
                values.len()
            );
            return Err(Mismatch::new("values", what));
        }
        Ok(Self { joints, values })
    }

    /// Number of joints.
    pub fn joints(&self) -> usize {
        self.joints
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.values.len() / self.joints
    }

    /// Errors of all joints at a frame; empty beyond the last.
    pub fn frame(&self, frame: usize) -> &[f32] {
        let from = (frame * self.joints).min(self.values.len());
        &self.values[from..(from + self.joints).min(self.values.len())]
    }
}

/// An error matrix that belongs to one clip, as assets store it.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorMatrixTable {
    /// Hashes of the rig, clip and mesh for which the matrix was made.
    pub hashes: TableHashes,
    /// Frames per second of the matrix: the rate of the clip's keys.
    pub rate_hz: f32,
    /// Normalised errors.
    pub matrix: ErrorMatrix,
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
    /// The same threshold at every distance.
    pub fn constant(value: f32) -> Self {
        Self {
            thr_init: value,
            thr_max: value,
            curve: ThresholdCurve::Fixed,
            ..Self::default()
        }
    }

    /// Returns the threshold at a distance, in metres, of the camera from the skeleton's root.
    pub fn at(&self, distance_metres: f32) -> f32 {
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

/// Switches joints literally as in the thesis: at each look-up an active joint whose error is below
/// the threshold becomes passive, a passive one above it becomes active. Passive joints hold their
/// last transform.
///
/// The metric needs a clip: in a blend, and where a layer moves a joint, joints are active.
#[derive(Debug, Clone)]
pub struct ThesisController {
    matrices: Vec<Option<Arc<ErrorMatrix>>>,
    /// Threshold by distance; may change in any frame.
    pub threshold: Threshold,
    lookup_every: usize,
    states: JointStates,
    /// Frames played, 0 before the first.
    frames: usize,
}

impl ThesisController {
    /// Creates a controller from the matrix of each clip of a model; the policy of `transition` is
    /// that of passive joints. The matrix is consulted in every `lookup_every`-th frame, at least
    /// 1. Allocates.
    pub fn new(
        rig: &Rig,
        matrices: Vec<Option<Arc<ErrorMatrix>>>,
        threshold: Threshold,
        lookup_every: usize,
        transition: TransitionOptions,
    ) -> Self {
        Self {
            matrices,
            threshold,
            lookup_every: lookup_every.max(1),
            states: JointStates::new(rig.rest_pose(), transition),
            frames: 0,
        }
    }

    /// States of the joints.
    pub fn states(&self) -> &JointStates {
        &self.states
    }

    /// Changes the states of joints by the errors of the frame.
    fn look_up(&mut self, frame: &FrameContext<'_>) {
        let threshold = self.threshold.at(frame.distance_metres);
        let clip = frame.clip.and_then(|clip| {
            let matrix = self.matrices.get(clip.index)?.as_ref()?;
            // Between two frames the figure moves as it does up to the later one.
            let moving = if clip.at.blend > 0.0 {
                clip.at.after
            } else {
                clip.at.before
            };
            // Matrices have a frame for each key, clips more where they are sampled more densely.
            let every = match matrix.frames() == clip.clip.frames() {
                true => 1,
                false => clip.clip.frames_per_key(),
            };
            let last = matrix.frames().saturating_sub(1);
            Some(matrix.frame(moving.div_ceil(every).min(last)))
        });
        for joint in frame.allowed.iter() {
            let error = clip.and_then(|errors| errors.get(joint));
            let error = error.filter(|_| !frame.layered.contains(joint));
            match (error, self.states.state(joint)) {
                (Some(error), JointState::Active) if *error < threshold => {
                    let shown = frame.shown.get(joint);
                    self.states.passivate(joint, frame.now_secs, &shown);
                }
                (Some(error), JointState::Passive) if *error > threshold => {
                    self.states.activate(joint, frame.now_secs);
                }
                (None, _) => self.states.activate(joint, frame.now_secs),
                _ => {}
            }
        }
    }
}

impl MotionController for ThesisController {
    fn due(&mut self, frame: &FrameContext<'_>) -> JointSet {
        if self.frames == 0 {
            return frame.allowed;
        }
        let in_clip = frame.clip.is_some();
        if self.frames.is_multiple_of(self.lookup_every) || !in_clip {
            self.look_up(frame);
        }
        self.states.sampled().intersection(&frame.allowed)
    }

    fn control(
        &mut self,
        frame: &FrameContext<'_>,
        _due: &JointSet,
        wanted: &LocalPose,
        shown: &mut LocalPose,
    ) -> ControlResult {
        if self.frames == 0 {
            self.states.start(&frame.allowed, frame.now_secs, wanted);
        } else {
            self.states.step(frame.now_secs, wanted);
        }
        self.frames += 1;
        for joint in frame.allowed.iter() {
            shown.set(joint, self.states.shown().get(joint));
        }
        ControlResult {
            updated: self.states.sampled().intersection(&frame.allowed),
            in_transition: self.states.in_transition().intersection(&frame.allowed),
            keys_read: 0,
            bound_px: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
