//! States of joints: active, passive, or in transition between the two.
//!
//! Source: thesis 5.1 (active and passive joints) and 5.2 (transitions by linear blending of
//! quaternions over a settable time), `docs/methods/motion-lod.md` part 2. Extensions to the
//! thesis: the transform of a passive joint is a policy, an interrupted transition starts from the
//! transform then shown, translations and scales follow the same states, and the root keeps its way
//! over the ground and its heading in every state.

use crate::articulation::Complexity;
use crate::joint_set::JointSet;
use crate::loa::complexity;
use crate::math::{Transform, nlerp};
use crate::pose::LocalPose;
use crate::rig::Rig;
use crate::travel::Carriers;
use glam::{Quat, Vec3};

/// Whether a joint is active (follows the clip), passive (held), or in transition between both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum JointState {
    /// Follows the clip.
    #[default]
    Active,
    /// In transition from the clip to the held transform.
    ToPassive,
    /// Shows the held transform.
    Passive,
    /// In transition from the held transform to the clip.
    ToActive,
}

/// The transform that a passive joint shows.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum PassivePolicy {
    /// The transform that was shown when the joint became passive.
    #[default]
    HoldLast,
    /// The rest pose.
    Rest,
    /// A key pose given by the caller (see [`JointStates::set_key_pose`]).
    KeyPose,
    /// As `HoldLast`, then a fade to the rest pose.
    BlendToRest {
        /// Duration of the fade in seconds.
        secs: f32,
    },
}

/// Easing curve of a transition.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Ease {
    /// Constant speed, as in the thesis.
    Linear,
    /// Smoothstep `u² (3 - 2u)`: zero speed at start and end.
    #[default]
    Smoothstep,
}

/// Options of transitions between active and passive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransitionOptions {
    /// Duration in seconds; 0 changes the state immediately.
    pub secs: f32,
    /// Easing curve over the duration.
    pub ease: Ease,
    /// The transform that a passive joint shows.
    pub policy: PassivePolicy,
}

impl Default for TransitionOptions {
    /// 200 ms, smoothstep, hold the last transform.
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
    /// Time of the last change of state, seconds.
    since: f64,
    /// The transform that is held, or will be after the transition.
    hold: Transform,
    /// Difference from the clip's transform to the one shown when a transition to passive began;
    /// not the identity only if it interrupted another transition.
    offset: Transform,
}

/// The joint states of one character and the pose that results from them.
#[derive(Debug, Clone)]
pub struct JointStates {
    opts: TransitionOptions,
    rest: LocalPose,
    key_pose: LocalPose,
    slots: Vec<Slot>,
    shown: LocalPose,
    /// The root and the nodes above it, if they travel in every state.
    carriers: Option<Carriers>,
}

impl JointStates {
    /// Creates states with all joints active, showing the rest pose. Allocates; of the other
    /// methods only [`JointStates::with_travel`] does.
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
            carriers: None,
        }
    }

    /// Lets the root of the rig, and the nodes above it, keep the translation and the heading of
    /// the clip in every state; they are then always among the joints of
    /// [`JointStates::sampled`].
    ///
    /// # Panics
    /// If the rig has another number of joints.
    #[must_use]
    pub fn with_travel(mut self, rig: &Rig) -> Self {
        assert_eq!(
            rig.len(),
            self.slots.len(),
            "the rig must be that of the states"
        );
        self.carriers = Some(Carriers::new(rig));
        self
    }

    /// Sets the pose shown by [`PassivePolicy::KeyPose`].
    ///
    /// # Panics
    /// If the pose belongs to another rig.
    pub fn set_key_pose(&mut self, pose: &LocalPose) {
        self.key_pose.copy_from(pose);
    }

    /// Returns the state of one joint.
    pub fn state(&self, joint: usize) -> JointState {
        self.slots[joint].state
    }

    /// Returns the pose shown after the last step.
    pub fn shown(&self) -> &LocalPose {
        &self.shown
    }

    /// Returns the joints whose clip transform is needed by the next step: all but the passive
    /// ones, and those that travel.
    pub fn sampled(&self) -> JointSet {
        let awake = self.in_state(|state| state != JointState::Passive);
        awake.union(&self.travelling())
    }

    /// Returns the joints that travel in every state.
    pub fn travelling(&self) -> JointSet {
        let carriers = self.carriers.as_ref().map(Carriers::set);
        carriers.unwrap_or_default()
    }

    /// Returns the joints in transition.
    pub fn in_transition(&self) -> JointSet {
        self.in_state(|s| matches!(s, JointState::ToActive | JointState::ToPassive))
    }

    fn in_state(&self, holds: impl Fn(JointState) -> bool) -> JointSet {
        (0..self.slots.len())
            .filter(|&j| holds(self.slots[j].state))
            .collect()
    }

    /// Starts with exactly the joints of `active` active and all others passive, without a
    /// transition.
    ///
    /// # Panics
    /// If the pose belongs to another rig.
    pub fn start(&mut self, active: &JointSet, now_secs: f64, clip: &LocalPose) {
        self.shown.copy_from(clip);
        for joint in 0..self.slots.len() {
            let hold = self.held_by_policy(joint);
            self.slots[joint] = Slot {
                state: if active.contains(joint) {
                    JointState::Active
                } else {
                    JointState::Passive
                },
                // The transition is over.
                since: now_secs - f64::from(self.opts.secs),
                hold,
                offset: Transform::IDENTITY,
            };
        }
        self.step(now_secs, clip);
    }

    /// The transform that a joint holds if it becomes passive now.
    fn held_by_policy(&self, joint: usize) -> Transform {
        match self.opts.policy {
            PassivePolicy::HoldLast | PassivePolicy::BlendToRest { .. } => self.shown.get(joint),
            PassivePolicy::Rest => self.rest.get(joint),
            PassivePolicy::KeyPose => self.key_pose.get(joint),
        }
    }

    /// Starts the transition of a joint to passive. Does nothing in the states `Passive` and
    /// `ToPassive`.
    pub fn passivate(&mut self, joint: usize, now_secs: f64, clip: &Transform) {
        let shown = self.shown.get(joint);
        let hold = self.held_by_policy(joint);
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

    /// Starts the transition of a joint to active. Does nothing in the states `Active` and
    /// `ToActive`.
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

    /// Makes exactly the joints of `active` active and all others passive: `Ref` and `Simp` of
    /// thesis 5.1 on the differences of two sets; joints that already have their state are
    /// untouched.
    pub fn request(&mut self, active: &JointSet, now_secs: f64, clip: &LocalPose) {
        for joint in 0..self.slots.len() {
            if active.contains(joint) {
                self.activate(joint, now_secs);
            } else {
                self.passivate(joint, now_secs, &clip.get(joint));
            }
        }
    }

    /// Shows a transform on a passive joint without a transition and holds it from now on (a key of
    /// a held joint).
    pub(crate) fn show(&mut self, joint: usize, value: Transform, now_secs: f64) {
        let slot = &mut self.slots[joint];
        slot.state = JointState::Passive;
        slot.since = now_secs;
        slot.hold = value;
        self.shown.set(joint, value);
    }

    /// Advances all joints to a time and returns the resulting pose. `clip` holds the clip's
    /// transforms of at least the joints of [`JointStates::sampled`]. Does not allocate.
    ///
    /// # Panics
    /// If the pose belongs to another rig.
    pub fn step(&mut self, now_secs: f64, clip: &LocalPose) -> &LocalPose {
        assert_eq!(
            clip.rotations.len(),
            self.slots.len(),
            "the pose must belong to this rig"
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
            let carried = match (&self.carriers, slot.state) {
                (None, _) | (_, JointState::Active) => None,
                (Some(carriers), _) => carriers.carried(j, &value, &clip.get(j)),
            };
            self.shown.set(j, carried.unwrap_or(value));
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

/// The transform that, composed with `from`, gives `to`, component by component.
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

/// Nested joint sets, one for each level of articulation, with the current level and the finest
/// level allowed. Level 0 is the finest. Source: refinement and simplification of thesis 5.1.
///
/// The limit is `h(d)`, the finest level that the benchmark of a device allows. The thesis counts
/// levels from the coarsest, so its limit is the highest number.
#[derive(Debug, Clone, PartialEq)]
pub struct LoaRange {
    levels: Vec<JointSet>,
    finest_allowed: usize,
    current: usize,
}

/// The joints that change state between two levels of a [`LoaRange`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LoaTransition {
    /// Joints that become active (`Ref`).
    pub refine: JointSet,
    /// Joints that become passive (`Simp`).
    pub simplify: JointSet,
}

impl LoaRange {
    /// Creates a range from the joints of each level, finest first, at the finest allowed level, or
    /// at the coarsest if the limit is coarser than all levels. `None` if there is no level.
    pub fn new(levels: Vec<JointSet>, finest_allowed: usize) -> Option<Self> {
        let coarsest = levels.len().checked_sub(1)?;
        let finest_allowed = finest_allowed.min(coarsest);
        Some(Self {
            levels,
            finest_allowed,
            current: finest_allowed,
        })
    }

    /// Creates a range of the named levels of a rig, from `loa(VeryHigh)`, level 0, to `loa(None)`,
    /// level 6.
    pub fn named(rig: &Rig, finest_allowed: usize) -> Self {
        let finest_first = Complexity::ALL.into_iter().rev();
        let levels: Vec<JointSet> = finest_first.map(|c| complexity(rig, c)).collect();
        let finest_allowed = finest_allowed.min(levels.len() - 1);
        Self {
            levels,
            finest_allowed,
            current: finest_allowed,
        }
    }

    /// Creates a range of one level.
    pub fn one(joints: JointSet) -> Self {
        Self {
            levels: vec![joints],
            finest_allowed: 0,
            current: 0,
        }
    }

    /// Returns the current level.
    pub fn level(&self) -> usize {
        self.current
    }

    /// Returns the joints of the current level.
    pub fn joints(&self) -> &JointSet {
        &self.levels[self.current]
    }

    /// Changes to a level, clamped to the range from the finest allowed to the coarsest, and
    /// returns the joints that change state.
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
        // Half-way between the clip's 0.2 and the held 0.1.
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
    fn a_range_changes_only_the_difference_and_never_passes_its_cap() {
        let levels = vec![JointSet::first(5), JointSet::first(2), JointSet::EMPTY];
        let mut range = LoaRange::new(levels, 1).unwrap();
        assert_eq!((range.level(), range.joints().len()), (1, 2));
        assert_eq!(range.request(0), LoaTransition::default(), "the cap holds");
        let down = range.request(7);
        assert_eq!(range.level(), 2, "beyond the coarsest is the coarsest");
        assert_eq!((down.refine.len(), down.simplify.len()), (0, 2));
        let up = range.request(1);
        assert_eq!((up.refine.len(), up.simplify.len()), (2, 0));
        assert!(LoaRange::new(vec![], 3).is_none());
    }
}
