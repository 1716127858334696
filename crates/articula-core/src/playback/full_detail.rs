//! Full detail: every joint is sampled in every frame, or as many as a budget allows.

use super::controller::{ControlResult, FrameContext, MotionController};
use crate::joint_set::JointSet;
use crate::pose::LocalPose;

/// Samples all allowed joints in every frame. Where [`FrameContext::max_joints`] allows fewer, they
/// take turns in the order of the rig, so that none waits for longer than the others.
#[derive(Debug, Clone, Copy, Default)]
pub struct FullDetail {
    /// Joint whose turn is next.
    next: usize,
}

impl MotionController for FullDetail {
    fn due(&mut self, frame: &FrameContext<'_>) -> JointSet {
        if frame.cut || frame.allowed.len() <= frame.max_joints {
            return frame.allowed;
        }
        let mut due = JointSet::EMPTY;
        let next = self.next;
        let later = frame.allowed.iter().filter(|j| *j >= next);
        let sooner = frame.allowed.iter().filter(|j| *j < next);
        for joint in later.chain(sooner).take(frame.max_joints) {
            due.insert(joint);
            self.next = joint + 1;
        }
        due
    }

    fn control(
        &mut self,
        frame: &FrameContext<'_>,
        due: &JointSet,
        wanted: &LocalPose,
        shown: &mut LocalPose,
    ) -> ControlResult {
        for joint in due.iter() {
            shown.set(joint, wanted.get(joint));
        }
        ControlResult {
            updated: *due,
            bound_px: frame.allowed.difference(due).is_empty().then_some(0.0),
            ..ControlResult::default()
        }
    }
}
