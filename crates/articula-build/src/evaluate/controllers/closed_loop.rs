//! Held keys with which a child cancels the error of its ancestors.
//!
//! Source: `docs/methods/motion-lod.md` 4.4. Joints are processed parents first, by the model-space
//! error of each joint under its *shown* parent; a renewed joint takes the local rotation that
//! gives it its true model-space rotation.

use articula_core::playback::{ControlResult, FrameContext, MotionController};
use articula_core::{JointSet, LocalPose, Rig, angle_between};
use glam::Quat;

/// Holds each of some joints while its model-space error stays within its limit.
#[derive(Debug, Clone)]
pub(in crate::evaluate) struct ClosedLoop<'a> {
    rig: &'a Rig,
    moving: JointSet,
    /// Limit of each joint in radians.
    radians: Vec<f32>,
    held: Vec<Quat>,
    true_model: Vec<Quat>,
    shown_model: Vec<Quat>,
}

impl<'a> ClosedLoop<'a> {
    pub(in crate::evaluate) fn new(rig: &'a Rig, moving: JointSet, radians: Vec<f32>) -> Self {
        let still = vec![Quat::IDENTITY; rig.len()];
        Self {
            rig,
            moving,
            radians,
            held: still.clone(),
            true_model: still.clone(),
            shown_model: still,
        }
    }
}

impl MotionController for ClosedLoop<'_> {
    fn due(&mut self, frame: &FrameContext<'_>) -> JointSet {
        frame.allowed
    }

    fn control(
        &mut self,
        frame: &FrameContext<'_>,
        due: &JointSet,
        wanted: &LocalPose,
        shown: &mut LocalPose,
    ) -> ControlResult {
        let mut updated = JointSet::EMPTY;
        for joint in 0..self.rig.len() {
            let parent = self.rig.parent(joint);
            let above = |models: &[Quat]| parent.map_or(Quat::IDENTITY, |p| models[p]);
            // What an articulation holds counts as it is shown.
            let local = if due.contains(joint) {
                wanted.rotations[joint]
            } else {
                shown.rotations[joint]
            };
            self.true_model[joint] = above(&self.true_model) * local;
            let parent = above(&self.shown_model);
            let error = angle_between(parent * self.held[joint], self.true_model[joint]);
            if frame.cut || !self.moving.contains(joint) {
                self.held[joint] = local;
            } else if error > self.radians[joint] {
                let own = parent.conjugate() * self.true_model[joint];
                self.held[joint] = own.normalize();
                updated.insert(joint);
            }
            self.shown_model[joint] = parent * self.held[joint];
        }
        for joint in frame.allowed.iter() {
            shown.set(joint, wanted.get(joint));
            shown.rotations[joint] = self.held[joint];
        }
        ControlResult {
            updated,
            ..ControlResult::default()
        }
    }
}
