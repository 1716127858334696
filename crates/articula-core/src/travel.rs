//! The way of a figure over the ground and its heading, which no joint of an articulation holds.
//!
//! Source: `docs/methods/motion-lod.md` parts 0 and 2: root motion is never a joint. Where a clip
//! stores it in the root joint or in the nodes above, a passive root keeps its translation and its
//! turn about the vertical, on top of the rotation that it holds.

use crate::joint_set::JointSet;
use crate::math::{Transform, normalised};
use crate::rig::Rig;
use glam::Quat;

/// Returns the part of a rotation that is about the vertical: the twist of its swing-twist
/// decomposition. A rotation by half a circle about a level axis has none and yields the identity.
pub fn heading(turn: Quat) -> Quat {
    let length = (turn.y * turn.y + turn.w * turn.w).sqrt();
    if length < 1e-9 {
        return Quat::IDENTITY;
    }
    Quat::from_xyzw(0.0, turn.y / length, 0.0, turn.w / length)
}

/// Returns the local rotation of a passive root: `hold`, turned about the vertical of the model as
/// `wanted` is. `above` is the model-from-parent rotation of the joint at rest.
pub fn hold_with_heading(above: Quat, wanted: Quat, hold: Quat) -> Quat {
    let turn = above * wanted * hold.conjugate() * above.conjugate();
    normalised(above.conjugate() * heading(turn) * above * hold)
}

/// The root of a rig and the nodes above it, which carry the whole figure.
#[derive(Debug, Clone)]
pub(crate) struct Carriers {
    /// Joint and the model-from-parent rotation at rest, from the root upwards.
    joints: Vec<(usize, Quat)>,
}

impl Carriers {
    pub(crate) fn new(rig: &Rig) -> Self {
        let parents = |joint: usize| std::iter::successors(rig.parent(joint), |j| rig.parent(*j));
        let above = |joint: usize| {
            let rest = &rig.rest_pose().rotations;
            parents(joint).fold(Quat::IDENTITY, |turn, p| rest[p] * turn)
        };
        let chain = std::iter::once(rig.root()).chain(parents(rig.root()));
        Self {
            joints: chain.map(|j| (j, above(j))).collect(),
        }
    }

    /// The joints as a set.
    pub(crate) fn set(&self) -> JointSet {
        self.joints.iter().map(|(joint, _)| *joint).collect()
    }

    /// What a carrier shows instead of the transform `held`: the translation and heading of
    /// `wanted` on top of it. `None` for other joints.
    pub(crate) fn carried(
        &self,
        joint: usize,
        held: &Transform,
        wanted: &Transform,
    ) -> Option<Transform> {
        let (_, above) = self.joints.iter().find(|(j, _)| *j == joint)?;
        Some(Transform {
            translation: wanted.translation,
            rotation: hold_with_heading(*above, wanted.rotation, held.rotation),
            scale: held.scale,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::angle_between;
    use std::f32::consts::PI;

    #[test]
    fn the_heading_of_a_turn_by_hand() {
        for angle in [-3.0f32, -0.5, 0.0, 1.0, 3.1] {
            let turn = Quat::from_rotation_y(angle);
            for turn in [turn, -turn, turn * Quat::from_rotation_x(0.4)] {
                // Leaning on top does not change it, and q and -q are one rotation.
                assert!(angle_between(heading(turn), Quat::from_rotation_y(angle)) < 1e-5);
            }
        }
        let over = heading(Quat::from_rotation_x(PI));
        assert!(angle_between(over, Quat::IDENTITY) < 1e-6);
        assert_eq!(heading(Quat::from_xyzw(1.0, 0.0, 0.0, 0.0)), Quat::IDENTITY);
    }

    #[test]
    fn a_held_tilt_turns_with_the_figure_about_the_vertical_of_the_model() {
        // Below a node that is turned by a quarter about x, the vertical is another axis.
        let above = Quat::from_rotation_x(0.5 * PI);
        let hold = Quat::from_rotation_x(0.1);
        let turned = above.conjugate() * Quat::from_rotation_y(0.7) * above;
        let shown = hold_with_heading(above, turned * Quat::from_rotation_x(0.3), hold);
        assert!(angle_between(shown, turned * hold) < 1e-3);
        let shown = hold_with_heading(Quat::IDENTITY, Quat::from_rotation_y(0.7), hold);
        assert!(angle_between(shown, Quat::from_rotation_y(0.7) * hold) < 1e-3);
    }
}
