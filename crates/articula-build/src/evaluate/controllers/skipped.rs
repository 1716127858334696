//! Every n-th frame: held until the next, or interpolated to it.

use articula_core::playback::{ControlResult, FrameContext, MotionController};
use articula_core::{JointSet, LocalPose, nlerp};
use glam::Quat;

/// Renews all joints at every n-th frame of a clip.
#[derive(Debug, Clone)]
pub(in crate::evaluate) struct Skipped {
    every: usize,
    /// Rotation of each joint at each frame, if frames in between are interpolated.
    ahead: Option<Vec<Vec<Quat>>>,
}

impl Skipped {
    /// Holds for `every` frames; `ahead` are the rotations by frame and joint for an ideal
    /// interpolation, which knows the next key.
    pub(in crate::evaluate) fn new(every: usize, ahead: Option<Vec<Vec<Quat>>>) -> Self {
        Self { every, ahead }
    }
}

impl MotionController for Skipped {
    fn due(&mut self, frame: &FrameContext<'_>) -> JointSet {
        let Some(clip) = frame.clip else {
            return frame.allowed;
        };
        let at = clip.at.before;
        let is_key = at.is_multiple_of(self.every);
        let is_end = self.ahead.is_some() && at + 1 == clip.clip.frames();
        if is_key || is_end || frame.cut {
            frame.allowed
        } else {
            JointSet::EMPTY
        }
    }

    fn control(
        &mut self,
        frame: &FrameContext<'_>,
        due: &JointSet,
        wanted: &LocalPose,
        shown: &mut LocalPose,
    ) -> ControlResult {
        let mut updated = due.intersection(&frame.allowed);
        let at = frame.clip.map_or(0, |clip| clip.at.before);
        for joint in frame.allowed.iter() {
            match &self.ahead {
                Some(ahead) if !at.is_multiple_of(self.every) && at + 1 < ahead.len() => {
                    updated.remove(joint);
                    let key = at - at % self.every;
                    let next = (key + self.every).min(ahead.len() - 1);
                    let u = (at - key) as f32 / (next - key) as f32;
                    shown.rotations[joint] = nlerp(ahead[key][joint], ahead[next][joint], u);
                }
                _ if updated.contains(joint) => shown.set(joint, wanted.get(joint)),
                _ => {}
            }
        }
        ControlResult {
            updated,
            ..ControlResult::default()
        }
    }
}
