//! Reduction of clips to a selection of moving joints, and the savings.

use crate::error::{Context, Error, Result};
use crate::open::CharacterFile;
use articula_build::{ClipSize, clip_size, hold_joints_in_clip};
use articula_core::joint_state::PassivePolicy;
use articula_core::loa::{LoaExpression, Selection, with_ancestors};
use articula_core::source::RawClip;
use articula_core::{JointSet, Rig};
use serde::Serialize;
use std::ops::AddAssign;

/// Selection of the joints that keep their motion in all clips, and the pose of the others.
#[derive(Debug, Clone)]
pub struct JointReduction {
    /// The joints that move.
    pub moving: MovingJoints,
    /// Whether all ancestors of moving joints move too.
    pub with_ancestors: bool,
    /// Pose of held joints.
    pub passive: PassivePolicy,
}

/// Selection of the joints that keep their motion; resolved against each character.
#[derive(Debug, Clone)]
pub enum MovingJoints {
    /// The joints selected by an expression, such as `loa(Low) + zone(hands)`.
    LoaExpression(LoaExpression),
    /// The joints of a saved selection.
    Selection(Selection),
}

/// Amount of joint animation; morph weights are not counted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct AnimationSize {
    /// Number of joints of the skin with a channel of more than one key in any clip.
    pub joints_animated: usize,
    /// Number of channels that drive joints.
    pub channels: usize,
    /// Number of keys in these channels.
    pub keys: usize,
    /// Size of times and values of all keys as 32-bit floats, in bytes.
    pub animation_bytes: usize,
}

/// Savings from holding joints.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct JointsReduced {
    /// Number of joints of the skins.
    pub joints: usize,
    /// Number of them that move.
    pub joints_active: usize,
    /// Amount of animation before.
    pub before: AnimationSize,
    /// Amount of animation after.
    pub after: AnimationSize,
    /// Fraction of the animation's bytes saved, 0 to 1.
    pub saved: f64,
}

/// Clips in which joints are held, and their sizes.
#[derive(Debug, Clone, PartialEq)]
pub struct JointsHeld {
    /// The reduced clips, in the order of the input.
    pub clips: Vec<RawClip>,
    /// Size of the input clips.
    pub before: AnimationSize,
    /// Size of `clips`.
    pub after: AnimationSize,
}

impl AddAssign<ClipSize> for AnimationSize {
    fn add_assign(&mut self, size: ClipSize) {
        self.channels += size.channels;
        self.keys += size.keys;
        self.animation_bytes += size.bytes;
    }
}

/// Holds every joint that is not in `active`, according to `policy`. Nodes that are not joints of a
/// skin keep their motion.
pub fn hold_joints(
    rig: &Rig,
    clips: &[RawClip],
    active: &JointSet,
    policy: PassivePolicy,
) -> JointsHeld {
    let plain = rig.all().difference(rig.skin_joints());
    let active = active.union(&plain);
    let (mut before, mut after) = (AnimationSize::default(), AnimationSize::default());
    let reduced = clips.iter().map(|clip| {
        before += clip_size(clip);
        let out = hold_joints_in_clip(rig, clip, &active, policy);
        after += clip_size(&out);
        out
    });
    let reduced: Vec<RawClip> = reduced.collect();
    let listed = rig.skin_joints();
    before.joints_animated = animated(clips, listed);
    after.joints_animated = animated(&reduced, listed);
    JointsHeld {
        clips: reduced,
        before,
        after,
    }
}

impl JointsHeld {
    /// Returns the fraction of the animation's bytes saved, 0 to 1.
    pub fn saved(&self) -> f64 {
        let bytes = |size: AnimationSize| size.animation_bytes as f64;
        1.0 - bytes(self.after) / bytes(self.before).max(1.0)
    }
}

/// Number of moving joints among those listed; of all if none is.
fn animated(clips: &[RawClip], listed: &JointSet) -> usize {
    let channels = clips.iter().flat_map(|c| &c.channels);
    let moving = channels.filter(|c| c.property.is_of_joint() && c.times_secs.len() > 1);
    let moving = moving.map(|c| c.target).collect::<JointSet>();
    if listed.is_empty() {
        return moving.len();
    }
    moving.intersection(listed).len()
}

impl JointReduction {
    /// Reduces all clips of a character.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if there is no clip; [`Error::Argument`] or [`Error::Unsupported`] at
    /// "selection" if the character has no such joints.
    pub fn apply(&self, opened: &mut CharacterFile) -> Result<JointsReduced> {
        let place = opened.name().to_owned();
        if opened.character().clips.is_empty() {
            let what = "clips: the file has no clip to reduce";
            return Err(Error::unsuited(what)).context(place);
        }
        let rig = Rig::new(&opened.character().skeleton, opened.articulation()).context(place)?;
        let mut active = self.moving.joints(&rig).context("selection")?;
        if self.with_ancestors {
            active = with_ancestors(&rig, &active);
        }
        let held = hold_joints(&rig, &opened.character().clips, &active, self.passive);
        let reduced = JointsReduced {
            joints: rig.skin_joints().len(),
            joints_active: active.intersection(rig.skin_joints()).len(),
            before: held.before,
            after: held.after,
            saved: held.saved(),
        };
        opened.set_clips(held.clips);
        Ok(reduced)
    }
}

impl MovingJoints {
    fn joints(&self, rig: &Rig) -> Result<JointSet> {
        match self {
            Self::LoaExpression(expression) => expression
                .joints(rig)
                .map_err(|e| Error::argument(e.to_string())),
            Self::Selection(selection) => selection
                .joints(rig)
                .map_err(|e| Error::unsuited(e.to_string())),
        }
    }
}
