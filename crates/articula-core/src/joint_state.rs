//! Whether each joint moves, holds still, or is on its way between the two.
//!
//! Source: thesis 5.1 (active and passive joints), 5.2 (transitions by linear blending of
//! quaternions with a settable time). Differs: what a passive joint shows is a policy, an
//! interrupted transition starts from the rotation then shown, and translations and scales
//! follow the same states.

use crate::joint_set::JointSet;
use crate::math::{Transform, nlerp};
use crate::pose::LocalPose;
use glam::{Quat, Vec3};

/// State of one joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum JointState {
    /// Shows the clip.
    #[default]
    Active,
    /// On its way from the clip to what it will hold.
    ToPassive,
    /// Shows what it holds.
    Passive,
    /// On its way from what it held back to the clip.
    ToActive,
}

/// What a passive joint shows.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum PassivePolicy {
    /// The transform that was shown when it became passive.
    #[default]
    HoldLast,
    /// The rest pose.
    Rest,
    /// A key pose that the caller gives (see [`JointStates::set_key_pose`]).
    KeyPose,
    /// As `HoldLast`, then fading to rest over this time.
    BlendToRest {
        /// Duration of the fade in seconds.
        secs: f32,
    },
}

/// Shape of a transition over its duration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Ease {
    /// Constant speed, as in the thesis.
    Linear,
    /// Starts and ends at rest.
    #[default]
    Smoothstep,
}

/// How joints change between active and passive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransitionOptions {
    /// Duration in seconds; 0 changes at once.
    pub secs: f32,
    /// Shape over that duration.
    pub ease: Ease,
    /// What a passive joint shows.
    pub policy: PassivePolicy,
}

impl Default for TransitionOptions {
    /// 200 ms, smooth, holding the last transform.
    fn default() -> Self {
        Self {
            secs: 0.2,
            ease: Ease::Smoothstep,
            policy: PassivePolicy::HoldLast,
        }
    }
}

#[derive(Debug, Clone, Copy)]
struct Slot {
    state: JointState,
    /// Time of the last change of state.
    since: f64,
    /// What is, or will be, held.
    hold: Transform,
    /// What the clip lacked of the shown transform when a transition to passive began; not
    /// identity only where it interrupted another transition.
    offset: Transform,
}

/// States of all joints of one character, and what they show.
#[derive(Debug, Clone)]
pub struct JointStates {
    opts: TransitionOptions,
    rest: LocalPose,
    key_pose: LocalPose,
    slots: Vec<Slot>,
    shown: LocalPose,
}

impl JointStates {
    /// All joints active, showing the rest pose. Allocates; everything later does not.
    pub fn new(rest: &LocalPose, opts: TransitionOptions) -> Self {
        let slots = (0..rest.rotations.len())
            .map(|j| Slot {
                state: JointState::Active,
                since: 0.0,
                hold: rest.get(j),
                offset: Transform::IDENTITY,
            })
            .collect();
        Self {
            opts,
            rest: rest.clone(),
            key_pose: rest.clone(),
            slots,
            shown: rest.clone(),
        }
    }

    /// Sets what [`PassivePolicy::KeyPose`] shows.
    ///
    /// # Panics
    /// If the pose is of another rig.
    pub fn set_key_pose(&mut self, pose: &LocalPose) {
        self.key_pose.copy_from(pose);
    }

    /// State of one joint.
    pub fn state(&self, joint: usize) -> JointState {
        self.slots[joint].state
    }

    /// What is shown now.
    pub fn shown(&self) -> &LocalPose {
        &self.shown
    }

    /// Joints that need the clip's value at the next step: all but the passive ones.
    pub fn sampled(&self) -> JointSet {
        (0..self.slots.len())
            .filter(|&j| self.slots[j].state != JointState::Passive)
            .collect()
    }

    /// Asks one joint to become passive. Nothing happens if it is, or is on its way.
    pub fn passivate(&mut self, joint: usize, now_secs: f64, clip: &Transform) {
        let shown = self.shown.get(joint);
        let hold = match self.opts.policy {
            PassivePolicy::HoldLast | PassivePolicy::BlendToRest { .. } => shown,
            PassivePolicy::Rest => self.rest.get(joint),
            PassivePolicy::KeyPose => self.key_pose.get(joint),
        };
        let slot = &mut self.slots[joint];
        if matches!(slot.state, JointState::Passive | JointState::ToPassive) {
            return;
        }
        slot.offset = match slot.state {
            JointState::ToActive => difference(clip, &shown),
            _ => Transform::IDENTITY,
        };
        slot.hold = hold;
        slot.since = now_secs;
        slot.state = if self.opts.secs > 0.0 {
            JointState::ToPassive
        } else {
            JointState::Passive
        };
    }

    /// Asks one joint to become active. Nothing happens if it is, or is on its way.
    pub fn activate(&mut self, joint: usize, now_secs: f64) {
        let shown = self.shown.get(joint);
        let slot = &mut self.slots[joint];
        if matches!(slot.state, JointState::Active | JointState::ToActive) {
            return;
        }
        slot.hold = shown;
        slot.since = now_secs;
        slot.state = if self.opts.secs > 0.0 {
            JointState::ToActive
        } else {
            JointState::Active
        };
    }

    /// Makes exactly the joints of `active` active, the others passive: thesis 5.1's `Ref` and
    /// `Simp` on the difference of two sets, the joints of both untouched.
    pub fn request(&mut self, active: &JointSet, now_secs: f64, clip: &LocalPose) {
        for joint in 0..self.slots.len() {
            if active.contains(joint) {
                self.activate(joint, now_secs);
            } else {
                self.passivate(joint, now_secs, &clip.get(joint));
            }
        }
    }

    /// Shows the clip's value on a passive joint and holds it from now on (a key of a held
    /// joint, without transition).
    pub(crate) fn show(&mut self, joint: usize, value: Transform, now_secs: f64) {
        let slot = &mut self.slots[joint];
        slot.state = JointState::Passive;
        slot.since = now_secs;
        slot.hold = value;
        self.shown.set(joint, value);
    }

    /// Advances all joints to a time and gives what they show. `clip` holds the clip's values
    /// of at least the joints of [`JointStates::sampled`]. Does not allocate.
    ///
    /// # Panics
    /// If the pose is of another rig.
    pub fn step(&mut self, now_secs: f64, clip: &LocalPose) -> &LocalPose {
        assert_eq!(
            clip.rotations.len(),
            self.slots.len(),
            "the pose is of another rig"
        );
        for (j, slot) in self.slots.iter_mut().enumerate() {
            let age = (now_secs - slot.since) as f32;
            let done = self.opts.secs <= 0.0 || age >= self.opts.secs;
            let s = ease(self.opts.ease, age / self.opts.secs.max(1e-6));
            slot.state = match slot.state {
                JointState::ToPassive if done => JointState::Passive,
                JointState::ToActive if done => JointState::Active,
                state => state,
            };
            let value = match slot.state {
                JointState::Active => clip.get(j),
                JointState::Passive => {
                    let held_secs = (age - self.opts.secs).max(0.0);
                    self.opts
                        .policy
                        .held(&slot.hold, &self.rest.get(j), held_secs)
                }
                JointState::ToPassive => blend(&compose(&clip.get(j), &slot.offset), &slot.hold, s),
                JointState::ToActive => blend(&slot.hold, &clip.get(j), s),
            };
            self.shown.set(j, value);
        }
        &self.shown
    }
}

impl PassivePolicy {
    fn held(self, hold: &Transform, rest: &Transform, age_secs: f32) -> Transform {
        match self {
            Self::BlendToRest { secs } => blend(
                hold,
                rest,
                ease(Ease::Smoothstep, age_secs / secs.max(1e-6)),
            ),
            _ => *hold,
        }
    }
}

fn ease(ease: Ease, u: f32) -> f32 {
    let u = u.clamp(0.0, 1.0);
    match ease {
        Ease::Linear => u,
        Ease::Smoothstep => u * u * (3.0 - 2.0 * u),
    }
}

fn blend(a: &Transform, b: &Transform, s: f32) -> Transform {
    Transform {
        translation: a.translation.lerp(b.translation, s),
        rotation: nlerp(a.rotation, b.rotation, s),
        scale: a.scale.lerp(b.scale, s),
    }
}

/// What must follow `from` to give `to`, component by component.
fn difference(from: &Transform, to: &Transform) -> Transform {
    Transform {
        translation: to.translation - from.translation,
        rotation: from.rotation.conjugate() * to.rotation,
        scale: Vec3::ONE + to.scale - from.scale,
    }
}

fn compose(t: &Transform, offset: &Transform) -> Transform {
    let rotation: Quat = t.rotation * offset.rotation;
    Transform {
        translation: t.translation + offset.translation,
        rotation,
        scale: t.scale + offset.scale - Vec3::ONE,
    }
}

/// A ladder of nested levels with a cap, as thesis 5.1 refines and simplifies. Level 0 is the
/// finest.
///
/// The cap is `h(d)`, the finest level that a device allows; it comes from the device's benchmark.
/// Differs: the thesis counts levels from the coarsest, so its cap is the highest number.
#[derive(Debug, Clone, PartialEq)]
pub struct LoaRange {
    levels: Vec<JointSet>,
    finest_allowed: usize,
    current: usize,
}

/// The joints that change between two levels of a [`LoaRange`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LoaTransition {
    /// Joints that become active (`Ref`).
    pub refine: JointSet,
    /// Joints that become passive (`Simp`).
    pub simplify: JointSet,
}

impl LoaRange {
    /// Takes the joints of each level, finest first, and starts at the finest level that is
    /// allowed, or at the coarsest if that lies beyond it. `None` without any level.
    pub fn new(levels: Vec<JointSet>, finest_allowed: usize) -> Option<Self> {
        let coarsest = levels.len().checked_sub(1)?;
        let finest_allowed = finest_allowed.min(coarsest);
        Some(Self {
            levels,
            finest_allowed,
            current: finest_allowed,
        })
    }

    /// The level now.
    pub fn level(&self) -> usize {
        self.current
    }

    /// The joints of the level now.
    pub fn joints(&self) -> &JointSet {
        &self.levels[self.current]
    }

    /// Goes to a level, or to the finest that is allowed if the level is finer, and says which
    /// joints change. A level beyond the coarsest is the coarsest.
    pub fn request(&mut self, level: usize) -> LoaTransition {
        let before = self.levels[self.current];
        let coarsest = self.levels.len() - 1;
        self.current = level.clamp(self.finest_allowed, coarsest);
        let after = self.levels[self.current];
        LoaTransition {
            refine: after.difference(&before),
            simplify: before.difference(&after),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::angle_between;

    fn one() -> LocalPose {
        LocalPose::from_iter([Transform::IDENTITY])
    }

    fn turned(radians: f32) -> LocalPose {
        let mut pose = one();
        pose.rotations[0] = Quat::from_rotation_y(radians);
        pose
    }

    fn opts(policy: PassivePolicy) -> TransitionOptions {
        TransitionOptions {
            policy,
            ..TransitionOptions::default()
        }
    }

    #[test]
    fn passes_through_all_four_states() {
        let mut s = JointStates::new(&one(), opts(PassivePolicy::HoldLast));
        s.step(0.0, &turned(0.1));
        s.passivate(0, 0.0, &turned(0.1).get(0));
        assert_eq!(s.state(0), JointState::ToPassive);
        s.step(0.1, &turned(0.2));
        // Half-way: the middle of the clip's 0.2 and the held 0.1.
        assert!(angle_between(s.shown().rotations[0], Quat::from_rotation_y(0.15)) < 1e-3);
        s.step(0.25, &turned(0.3));
        assert_eq!(s.state(0), JointState::Passive);
        assert!(angle_between(s.shown().rotations[0], Quat::from_rotation_y(0.1)) < 1e-5);
        assert!(s.sampled().is_empty());
        s.activate(0, 0.3);
        assert_eq!(s.state(0), JointState::ToActive);
        s.step(0.6, &turned(0.4));
        assert_eq!(s.state(0), JointState::Active);
        assert_eq!(s.shown(), &turned(0.4));
    }

    #[test]
    fn policies_hold_what_they_say() {
        let passive_at = |policy, key: f32| {
            let mut s = JointStates::new(
                &one(),
                TransitionOptions {
                    secs: 0.0,
                    ..opts(policy)
                },
            );
            s.set_key_pose(&turned(key));
            s.step(0.0, &turned(0.5));
            s.passivate(0, 0.0, &turned(0.5).get(0));
            s.step(10.0, &turned(0.9));
            s.shown().rotations[0]
        };
        let near = |q: Quat, radians: f32| angle_between(q, Quat::from_rotation_y(radians)) < 1e-5;
        assert!(near(passive_at(PassivePolicy::HoldLast, 0.7), 0.5));
        assert!(near(passive_at(PassivePolicy::Rest, 0.7), 0.0));
        assert!(near(passive_at(PassivePolicy::KeyPose, 0.7), 0.7));
        assert!(near(
            passive_at(PassivePolicy::BlendToRest { secs: 5.0 }, 0.7),
            0.0
        ));
    }

    #[test]
    fn a_ladder_changes_only_the_difference_and_never_passes_its_cap() {
        let levels = vec![JointSet::first(5), JointSet::first(2), JointSet::EMPTY];
        let mut ladder = LoaRange::new(levels, 1).unwrap();
        assert_eq!((ladder.level(), ladder.joints().len()), (1, 2));
        assert_eq!(ladder.request(0), LoaTransition::default(), "the cap holds");
        let down = ladder.request(7);
        assert_eq!(ladder.level(), 2, "beyond the coarsest is the coarsest");
        assert_eq!((down.refine.len(), down.simplify.len()), (0, 2));
        let up = ladder.request(1);
        assert_eq!((up.refine.len(), up.simplify.len()), (2, 0));
        assert!(LoaRange::new(vec![], 3).is_none());
    }
}
