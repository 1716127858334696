//! One rotation for each run of frames: key poses, and the clusters of Ahn and Wohn.

use crate::motion_error::keys::Segment;
use articula_core::playback::{ControlResult, FrameContext, MotionController};
use articula_core::{JointSet, LocalPose};

/// Shows the rotation of the run that holds the frame.
#[derive(Debug, Clone)]
pub(in crate::evaluate) struct Segments {
    /// Runs of each joint in the order of their frames; none for a joint that is not controlled.
    joints: Vec<Vec<Segment>>,
}

impl Segments {
    pub(in crate::evaluate) fn new(joints: Vec<Vec<Segment>>) -> Self {
        Self { joints }
    }
}

impl MotionController for Segments {
    fn due(&mut self, _: &FrameContext<'_>) -> JointSet {
        JointSet::EMPTY
    }

    fn control(
        &mut self,
        frame: &FrameContext<'_>,
        _: &JointSet,
        _: &LocalPose,
        shown: &mut LocalPose,
    ) -> ControlResult {
        let mut result = ControlResult::default();
        let at = frame.clip.map_or(0, |clip| clip.at.before);
        for joint in frame.allowed.iter() {
            let runs = &self.joints[joint];
            let started = runs.partition_point(|run| run.start <= at);
            let Some(run) = started.checked_sub(1).map(|last| &runs[last]) else {
                continue;
            };
            shown.rotations[joint] = run.key;
            if run.start == at {
                result.updated.insert(joint);
                result.keys_read += 1;
            }
        }
        result
    }
}
