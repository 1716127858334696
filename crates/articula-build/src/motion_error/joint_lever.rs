//! Levers of joints: displacement of the skin by a held joint, in metres and as projected to a
//! view.
//!
//! Source: `docs/methods/motion-lod.md` 4.1 to 4.3, ours. A joint that shows rotation `b` in place
//! of `a` moves the skin attached to it by at most its lever times the angle between them.

use articula_core::{SecondMoment, angle_between};
use glam::{Quat, Vec3};

/// Extent of the skin that one joint moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointLever {
    /// Maximum distance from the joint of the skin that it moves, in the rest pose, metres; at
    /// least one centimetre.
    pub rest_metres: f32,
    /// Maximum distance of that skin in any pose, metres: the longest weighted path along the
    /// bones. An upper bound where `rest_metres` is an estimate, because a chain that is bent at
    /// rest can stretch.
    pub reach_metres: f32,
    /// Mean of `x x^T` over the skin below the joint, `x` the offset from the joint at rest in the
    /// joint's own frame; square metres.
    pub second_moment: SecondMoment,
    /// Fraction of the skin's area that the joint moves, 0 to 1.
    pub skin_share: f32,
}

impl JointLever {
    /// Minimum lever, so that the skin around a leaf joint counts.
    pub(crate) const FLOOR_METRES: f32 = 0.01;

    /// Upper bound, by the lever at rest, on the displacement of the skin if `shown` is used in
    /// place of `wanted`, metres.
    pub(crate) fn held_error(&self, shown: Quat, wanted: Quat) -> f32 {
        self.rest_metres * angle_between(shown, wanted)
    }

    /// The same, projected along `view`, a unit direction in the joint's frame: reduced by the part
    /// of the motion along the line of sight, root mean square over the skin. A joint without skin
    /// is not reduced.
    pub(crate) fn projected_error(&self, shown: Quat, wanted: Quat, view: Vec3) -> f32 {
        let part = self.second_moment.seen_fraction(shown, wanted, view);
        self.held_error(shown, wanted) * part
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_held_rotation_moves_the_skin_by_angle_times_lever() {
        let lever = JointLever {
            rest_metres: 2.0,
            reach_metres: 3.0,
            // One point ahead of the joint along X.
            second_moment: SecondMoment::of([(Vec3::X, 1.0)]),
            skin_share: 1.0,
        };
        let turned = Quat::from_rotation_z(0.3);
        assert!((lever.held_error(Quat::IDENTITY, turned) - 0.6).abs() < 1e-5);
        assert_eq!(lever.held_error(turned, turned), 0.0);
        // The point moves along Y: seen in full along Z, not at all along Y.
        let small = Quat::from_rotation_z(1e-3);
        let along_z = lever.projected_error(Quat::IDENTITY, small, Vec3::Z);
        assert!((along_z / lever.held_error(Quat::IDENTITY, small) - 1.0).abs() < 1e-2);
        let along_y = lever.projected_error(Quat::IDENTITY, small, Vec3::Y);
        assert!(along_y < 0.05 * along_z);
    }
}
