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
