//! Hold: a joint is renewed as soon as its error exceeds the tolerance, tested at every frame.
//!
//! Source: `docs/methods/motion-lod.md` 4.2; the drift controller without hysteresis, dwell time and
//! transitions.

use crate::motion_error::hull::JointHull;
use crate::motion_error::joint_lever::JointLever;
use articula_core::playback::{ControlResult, FrameContext, MotionController};
use articula_core::{JointSet, LocalPose, Rig};
use glam::{Quat, Vec3};

/// A view whose line of sight does not count.
#[derive(Debug, Clone)]
pub(in crate::evaluate) struct HeldView<'a> {
    pub(in crate::evaluate) rig: &'a Rig,
    /// Unit direction to the view in model space.
    pub(in crate::evaluate) direction: Vec3,
    /// Hulls whose outlines are compared; `None` for the part of the lever's error that is seen.
    pub(in crate::evaluate) hulls: Option<&'a [JointHull]>,
}

/// Tests every joint against its lever at every frame.
#[derive(Debug, Clone)]
pub(in crate::evaluate) struct Held<'a> {
    levers: &'a [JointLever],
    tolerance_metres: f32,
    view: Option<HeldView<'a>>,
    /// True model-space rotations, needed for a view.
    models: Vec<Quat>,
}

impl<'a> Held<'a> {
    pub(in crate::evaluate) fn new(
        levers: &'a [JointLever],
        tolerance_metres: f32,
        view: Option<HeldView<'a>>,
    ) -> Self {
        Self {
            models: vec![Quat::IDENTITY; levers.len()],
            levers,
            tolerance_metres,
            view,
        }
    }

    fn error(&self, joint: usize, shown: Quat, wanted: Quat) -> f32 {
        let lever = &self.levers[joint];
        match &self.view {
            Some(view) => {
                let in_joint = self.models[joint].conjugate() * view.direction;
                match view.hulls {
                    Some(hulls) => hulls[joint].outline_error(shown, wanted, in_joint),
                    None => lever.projected_error(shown, wanted, in_joint),
                }
            }
            None => lever.held_error(shown, wanted),
        }
    }
}

impl MotionController for Held<'_> {
    fn due(&mut self, frame: &FrameContext<'_>) -> JointSet {
        frame.allowed
    }

    fn control(
        &mut self,
        frame: &FrameContext<'_>,
        due: &JointSet,
        wanted: &LocalPose,
        shown: &mut LocalPose,
    ) -> ControlResult {
        if let Some(view) = &self.view {
            for joint in 0..view.rig.len() {
                // What an articulation holds counts as it is shown.
                let local = if due.contains(joint) {
                    wanted.rotations[joint]
                } else {
                    shown.rotations[joint]
                };
                let above = view.rig.parent(joint).map(|p| self.models[p]);
                self.models[joint] = above.map_or(local, |above| above * local);
            }
        }
        let mut updated = JointSet::EMPTY;
        for joint in due.iter() {
            let (held, now) = (shown.rotations[joint], wanted.rotations[joint]);
            let tolerance = self.tolerance_metres * frame.attention[joint];
            if frame.cut || self.error(joint, held, now) > tolerance {
                shown.set(joint, wanted.get(joint));
                updated.insert(joint);
            }
        }
        ControlResult {
            updated,
            ..ControlResult::default()
        }
    }
}
