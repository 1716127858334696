//! Stored key frames at run time: each joint shows the keys of the nearest stored tolerance.
//!
//! Source: `docs/methods/motion-lod.md` 4.5 and part 9.

use super::controller::{ClipFrame, ControlResult, FrameContext, MotionController};
use crate::Mismatch;
use crate::attention::tolerance_metres;
use crate::clip::Clip;
use crate::joint_set::JointSet;
use crate::key_table::{KeyMode, KeyTable};
use crate::math::nlerp;
use crate::pose::LocalPose;
use glam::Quat;
use std::sync::Arc;

/// The key table of one clip, checked against it.
#[derive(Debug, Clone)]
pub struct StoredKeys {
    table: Arc<KeyTable>,
    /// Rotation track of each joint.
    tracks: Vec<Option<usize>>,
    /// Joints whose translation or scale changes over the clip, which the keys do not cover.
    shifted: JointSet,
}

impl StoredKeys {
    /// Pairs a table with the clip that it was made for.
    ///
    /// # Errors
    /// A [`Mismatch`] if frame rate, number of frames or number of joints differ, or a key lies
    /// outside the clip. The hashes are checked by [`KeyTable::check`].
    pub fn new(clip: &Clip, table: impl Into<Arc<KeyTable>>) -> Result<Self, Mismatch> {
        let table = table.into();
        let differs = |at: &str, found: String, expected: String| {
            (found != expected)
                .then(|| Mismatch::new(at, format!("{found}, the clip has {expected}")))
        };
        let of = |v: &dyn std::fmt::Display| v.to_string();
        let mismatch = differs("rate_hz", of(&table.rate_hz), of(&clip.rate_hz()))
            .or_else(|| differs("frames", of(&table.frames), of(&clip.frames())))
            .or_else(|| differs("keys", of(&table.keys.len()), of(&clip.joints())));
        if let Some(mismatch) = mismatch {
            return Err(mismatch);
        }
        let mut tracks = vec![None; clip.joints()];
        for (t, track) in clip.tracks().rotations.iter().enumerate() {
            tracks[usize::from(track.target)] = Some(t);
        }
        for (joint, levels) in table.keys.iter().enumerate() {
            let last = levels.iter().flatten().max().copied();
            let values = tracks[joint].map_or(0, |t| clip.tracks().rotations[t].values.len());
            if last.is_some_and(|key| key as usize >= values) {
                let what = "a key lies outside the clip's rotations of the joint";
                return Err(Mismatch::new(format!("keys[{joint}]"), what));
            }
        }
        let tracked = clip.tracks();
        let moved = tracked.translations.iter().chain(&tracked.scales);
        let moved = moved.filter(|t| t.values.windows(2).any(|w| w[0] != w[1]));
        Ok(Self {
            table,
            tracks,
            shifted: moved.map(|t| usize::from(t.target)).collect(),
        })
    }

    fn rotation(&self, clip: &Clip, joint: usize, frame: u32) -> Option<Quat> {
        let track = &clip.tracks().rotations[self.tracks[joint]?];
        track.values.get(frame as usize).copied()
    }
}

/// The key that a joint shows.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ShownKey {
    clip: usize,
    level: usize,
    key: u32,
    /// Whether it is blended with the next key.
    blended: bool,
}

/// Shows each joint by its stored keys, at the coarsest stored level within the tolerance of the
/// joint. Joints without keys, of too small a tolerance, or in a blend are sampled.
///
/// A held key is blended to the next one over the one frame of the clip before it, so that the
/// tolerance holds between frames too.
#[derive(Debug, Clone)]
pub struct TableController {
    tables: Vec<Option<StoredKeys>>,
    /// Tolerated displacement in pixels; may change in any frame.
    pub epsilon_px: f32,
    shares: Vec<f32>,
    shown: Vec<Option<ShownKey>>,
}

impl TableController {
    /// Creates a controller from the tables of each clip of a model and the share of the tolerance
    /// that each joint may use, 0 to 1. Allocates.
    pub fn new(tables: Vec<Option<StoredKeys>>, shares: Vec<f32>, epsilon_px: f32) -> Self {
        Self {
            tables,
            epsilon_px,
            shown: vec![None; shares.len()],
            shares,
        }
    }

    /// The stored level of a joint in a frame; `None` if it is to be sampled.
    fn level(&self, frame: &FrameContext<'_>, joint: usize) -> Option<usize> {
        let clip = frame.clip.filter(|_| !frame.layered.contains(joint))?;
        let keys = self.keys(&clip)?;
        if keys.table.keys[joint].first().is_none_or(Vec::is_empty) {
            return None;
        }
        keys.table.level_for(self.tolerance(frame, joint))
    }

    fn tolerance(&self, frame: &FrameContext<'_>, joint: usize) -> f32 {
        let attention = frame.attention[joint] * self.shares[joint];
        tolerance_metres(self.epsilon_px, attention, frame.pixels_per_metre[joint])
    }

    fn keys(&self, clip: &ClipFrame<'_>) -> Option<&StoredKeys> {
        self.tables.get(clip.index)?.as_ref()
    }

    /// What a joint shows by its keys: the key, its rotation, and the values read.
    fn keyed(
        &self,
        frame: &FrameContext<'_>,
        joint: usize,
        level: usize,
    ) -> Option<(ShownKey, Quat)> {
        let clip = frame.clip?;
        let keys = self.keys(&clip)?;
        let (key, next) = keys.table.span(joint, level, clip.at.before as u32)?;
        let from = keys.rotation(clip.clip, joint, key)?;
        // A held key ends one frame before the next.
        let start = match keys.table.mode {
            KeyMode::Hold => next.map_or(key, |next| next - 1),
            KeyMode::Linear => key,
        };
        let passed = clip.at.before as f32 - start as f32 + clip.at.blend;
        let blended_to = next.filter(|_| keys.table.mode == KeyMode::Linear || passed > 0.0);
        let rotation = match blended_to {
            Some(next) => {
                let to = keys.rotation(clip.clip, joint, next)?;
                nlerp(from, to, passed / (next - start) as f32)
            }
            None => from,
        };
        let shown = ShownKey {
            clip: clip.index,
            level,
            key,
            blended: keys.table.mode == KeyMode::Hold && blended_to.is_some(),
        };
        Some((shown, rotation))
    }
}

impl MotionController for TableController {
    fn due(&mut self, frame: &FrameContext<'_>) -> JointSet {
        let shifted = frame.clip.and_then(|clip| self.keys(&clip));
        let shifted = shifted.map_or(JointSet::EMPTY, |keys| keys.shifted);
        let is_due = |joint: &usize| {
            frame.cut
                || shifted.contains(*joint)
                || self.shown[*joint].is_none()
                || self.level(frame, *joint).is_none()
        };
        frame.allowed.iter().filter(is_due).collect()
    }

    fn control(
        &mut self,
        frame: &FrameContext<'_>,
        due: &JointSet,
        wanted: &LocalPose,
        shown: &mut LocalPose,
    ) -> ControlResult {
        let mut result = ControlResult::default();
        let mut bound = 0.0f32;
        for joint in frame.allowed.iter() {
            if due.contains(joint) {
                shown.set(joint, wanted.get(joint));
            }
            let level = self.level(frame, joint);
            let keyed = level.and_then(|level| self.keyed(frame, joint, level));
            if let Some((key, rotation)) = keyed {
                shown.rotations[joint] = rotation;
                bound = bound.max(self.tolerance(frame, joint) * frame.pixels_per_metre[joint]);
                if key.blended || self.shown[joint] != Some(key) {
                    result.updated.insert(joint);
                    result.keys_read += 1;
                }
            } else {
                result.updated.insert(joint);
            }
            self.shown[joint] = keyed.map(|(key, _)| key);
        }
        result.bound_px = Some(bound);
        result
    }
}
