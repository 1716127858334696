//! The drift controller in a playback: its error metric needs no tables and works on blends.

use super::controller::{ControlResult, FrameContext, MotionController};
use crate::drift::{DriftController, JointViewScales};
use crate::joint_set::JointSet;
use crate::pose::LocalPose;

fn scales<'a>(frame: &FrameContext<'a>) -> JointViewScales<'a> {
    JointViewScales {
        pixels_per_metre: frame.pixels_per_metre,
        attention: frame.attention,
    }
}

/// Bounds on speed are those of one clip, so every joint is tested while two clips are blended, and
/// every joint that a layer moves.
impl MotionController for DriftController {
    fn due(&mut self, frame: &FrameContext<'_>) -> JointSet {
        if frame.cut || frame.clip.is_none() {
            self.invalidate();
        }
        self.set_view_directions(frame.view_directions, frame.model);
        let due = DriftController::due(self, frame.now_secs, scales(frame));
        due.union(&frame.layered).intersection(&frame.allowed)
    }

    fn control(
        &mut self,
        frame: &FrameContext<'_>,
        due: &JointSet,
        wanted: &LocalPose,
        shown: &mut LocalPose,
    ) -> ControlResult {
        let due = due.intersection(&frame.allowed);
        let pose = self.step(frame.now_secs, scales(frame), &due, wanted);
        for joint in frame.allowed.iter() {
            shown.set(joint, pose.get(joint));
        }
        ControlResult {
            updated: *self.updated(),
            in_transition: self.states().in_transition(),
            keys_read: 0,
            bound_px: Some(self.options().bound_px()),
        }
    }
}
