//! Levels of articulation at run time: refinement and simplification with transitions.
//!
//! Source: thesis 5.1 (Refine and Simplify, the cap `h(d)` of the device, at which play starts) and
//! 5.2 (transitions); `docs/methods/motion-lod.md` part 2.

use super::controller::{ControlResult, FrameContext, MotionController};
use crate::joint_set::JointSet;
use crate::joint_state::{JointStates, LoaRange, LoaTransition, TransitionOptions};
use crate::pose::LocalPose;
use crate::rig::Rig;

/// Lets only the joints of an articulation move, and leaves the choice among these to another
/// controller: [`FullDetail`](super::FullDetail) where the articulation alone decides, a controller
/// with an error metric where it bounds what the metric may choose.
///
/// Joints that enter or leave the articulation do so in a transition. The root keeps its way over
/// the ground and its heading also while it is passive.
#[derive(Debug, Clone)]
pub struct LoaController<C> {
    range: LoaRange,
    articulation: JointSet,
    states: JointStates,
    /// The controller of the joints that may move.
    pub inner: C,
    /// What the inner controller shows.
    inner_shown: LocalPose,
    started: bool,
}

impl<C: MotionController> LoaController<C> {
    /// Creates a controller at the current level of a range. Allocates.
    pub fn new(rig: &Rig, range: LoaRange, opts: TransitionOptions, inner: C) -> Self {
        Self {
            articulation: *range.joints(),
            range,
            states: JointStates::new(rig.rest_pose(), opts).with_travel(rig),
            inner,
            inner_shown: rig.rest_pose().clone(),
            started: false,
        }
    }

    /// Sets the pose shown by [`PassivePolicy::KeyPose`](crate::joint_state::PassivePolicy::KeyPose).
    ///
    /// # Panics
    /// If the pose belongs to another rig.
    pub fn set_key_pose(&mut self, pose: &LocalPose) {
        self.states.set_key_pose(pose);
    }

    /// Changes to a level of the range, clamped to those that the device allows, from the next
    /// frame on; returns the joints that change state.
    pub fn request(&mut self, level: usize) -> LoaTransition {
        let before = self.articulation;
        self.range.request(level);
        self.articulate(*self.range.joints());
        LoaTransition {
            refine: self.articulation.difference(&before),
            simplify: before.difference(&self.articulation),
        }
    }

    /// Changes to any set of joints, from the next frame on.
    pub fn articulate(&mut self, joints: JointSet) {
        self.articulation = joints;
    }

    /// Joints that may move.
    pub fn articulation(&self) -> &JointSet {
        &self.articulation
    }

    /// Current level of the range.
    pub fn level(&self) -> usize {
        self.range.level()
    }

    /// States of the joints.
    pub fn states(&self) -> &JointStates {
        &self.states
    }

    /// The context of the inner controller: only what moves now is allowed.
    fn inside<'a>(&self, frame: &FrameContext<'a>) -> FrameContext<'a> {
        let awake = self.states.sampled().union(&self.articulation);
        FrameContext {
            allowed: if self.started {
                frame.allowed.intersection(&awake)
            } else {
                frame.allowed
            },
            ..*frame
        }
    }
}

impl<C: MotionController> MotionController for LoaController<C> {
    fn due(&mut self, frame: &FrameContext<'_>) -> JointSet {
        let inside = self.inside(frame);
        let due = self.inner.due(&inside);
        if !self.started {
            // What is held from the start on is the first pose.
            return inside.allowed;
        }
        // What carries the figure is always needed.
        due.union(&self.states.travelling())
    }

    fn control(
        &mut self,
        frame: &FrameContext<'_>,
        due: &JointSet,
        wanted: &LocalPose,
        shown: &mut LocalPose,
    ) -> ControlResult {
        let inside = self.inside(frame);
        let inner = &mut self.inner_shown;
        let mut result = self.inner.control(&inside, due, wanted, inner);
        // What carries the figure does so as wanted, whatever the metric holds.
        for joint in self
            .states
            .travelling()
            .difference(&self.articulation)
            .iter()
        {
            inner.set(joint, wanted.get(joint));
        }
        if self.started {
            self.states
                .request(&self.articulation, frame.now_secs, inner);
            self.states.step(frame.now_secs, inner);
        } else {
            self.started = true;
            self.states.start(&self.articulation, frame.now_secs, inner);
        }
        shown.copy_from(self.states.shown());
        let in_transition = self.states.in_transition();
        result.updated = result
            .updated
            .intersection(&self.articulation)
            .union(&in_transition);
        result.in_transition = result.in_transition.union(&in_transition);
        if !frame.allowed.difference(&self.articulation).is_empty() {
            result.bound_px = None;
        }
        result
    }
}
