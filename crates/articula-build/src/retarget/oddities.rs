//! What is odd about a clip, whatever it is transferred to.

use super::RetargetFigure;
use super::motion::{JUMP_RADIANS, Motion};
use super::rest::Rest;
use crate::clip_edit::heading::yaw;
use crate::sampling_rate::source_rate_hz;
use articula_core::Mismatch;
use articula_core::source::{RawClip, Skeleton};

/// Greatest angle of a joint against its parent between the ends of a clip that repeats.
const SAME_RADIANS: f32 = 0.15;
/// Least angle by which a joint moves between them.
const MOVED_RADIANS: f32 = 0.2;
/// Number of frames of the short look at a clip.
const LOOKS: usize = 9;
/// Times of the first two frames of a clip beyond which it is no capture, seconds.
const MAX_STEP_SECS: f32 = 0.25;

/// A figure at rest, whose clips are looked at.
#[derive(Debug)]
pub struct ClipOddities<'a> {
    skeleton: &'a Skeleton,
    rest: Rest,
}

impl<'a> ClipOddities<'a> {
    /// Takes a figure without its clips.
    ///
    /// # Errors
    /// A [`Mismatch`] if skeleton and articulation do not belong together.
    pub fn new(figure: &RetargetFigure<'a>) -> Result<Self, Mismatch> {
        Ok(Self {
            skeleton: figure.skeleton,
            rest: Rest::new(figure, "figure")?,
        })
    }

    /// The mapped joint that turns the farthest between the first two frames of a clip, and its angle in
    /// radians, if it turns much farther than any joint does between other frames; `None` if not.
    ///
    /// O(joints), and O(frames x joints) if the first step is a large one.
    ///
    /// # Errors
    /// A [`Mismatch`] if the clip does not belong to the figure, or is longer than can be sampled.
    pub fn first_frame_jump(&self, clip: &RawClip) -> Result<Option<(usize, f32)>, Mismatch> {
        let rest = &self.rest;
        let Some(step_secs) = first_step_secs(clip).filter(|secs| *secs <= MAX_STEP_SECS) else {
            return Ok(None);
        };
        let begin = self.at(clip, vec![0.0, step_secs])?;
        let jumps = |joint: usize| begin.turned(rest, [0, 1], joint) > JUMP_RADIANS;
        if !mapped(rest).any(jumps) {
            return Ok(None);
        }
        // Frames of a capture are its keys: no other rate needs to be looked for.
        let rate_hz = Some(source_rate_hz(clip));
        let motion = Motion::new(clip, self.skeleton, rest, rate_hz)?;
        Ok(motion.first_frame_jump(rest))
    }

    /// The turn of a clip about the vertical from its beginning to its end, in radians from -pi to pi,
    /// towards the left of the figure, if it is a greater one than this; `None` unless it ends in the pose in
    /// which it begins and moves in between.
    ///
    /// O(joints).
    ///
    /// # Errors
    /// As [`ClipOddities::first_frame_jump`].
    pub fn turn_of_repeat(&self, clip: &RawClip, above: f32) -> Result<Option<f32>, Mismatch> {
        let rest = &self.rest;
        let Some(root) = rest.find("humanoid_root") else {
            return Ok(None);
        };
        let limbs: Vec<usize> = mapped(rest).filter(|joint| *joint != root).collect();
        let turned = |motion: &Motion, to: usize, joint: usize| motion.turned(rest, [0, to], joint);
        let ends = self.at(clip, vec![0.0, clip.duration_secs])?;
        let turn = yaw(ends.deltas(1)[root] * ends.deltas(0)[root].inverse());
        let returns = || limbs.iter().all(|j| turned(&ends, 1, *j) < SAME_RADIANS);
        if turn.abs() <= above || !returns() {
            return Ok(None);
        }
        let time = |look: usize| clip.duration_secs * look as f32 / (LOOKS - 1) as f32;
        let between = self.at(clip, (0..LOOKS - 1).map(time).collect())?;
        let moves = |look| {
            limbs
                .iter()
                .any(|j| turned(&between, look, *j) > MOVED_RADIANS)
        };
        Ok((1..LOOKS - 1).any(moves).then_some(turn))
    }

    fn at(&self, clip: &RawClip, times_secs: Vec<f32>) -> Result<Motion, Mismatch> {
        Motion::at(clip, self.skeleton, &self.rest, times_secs)
    }
}

fn mapped(rest: &Rest) -> impl Iterator<Item = usize> {
    (0..rest.len()).filter(|joint| rest.hanim[*joint].is_some())
}

/// The time of the second key of the channel that has it first.
fn first_step_secs(clip: &RawClip) -> Option<f32> {
    let second = clip.channels.iter().filter_map(|c| c.times_secs.get(1));
    second.copied().filter(|secs| *secs > 0.0).reduce(f32::min)
}
