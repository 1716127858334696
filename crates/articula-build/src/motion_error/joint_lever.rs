//! Levers of joints: displacement of the skin by a held joint, in metres and as projected to a
//! view.
//!
//! Source: `docs/methods/motion-lod.md` 4.1 to 4.3, ours. A joint that shows rotation `b` in place
//! of `a` moves the skin attached to it by at most its lever times the angle between them.

use crate::rotation_vector::rotation_vector;
use articula_core::angle_between;
use glam::{Mat3, Quat, Vec3};

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
    pub(crate) second_moment: SecondMoment,
    /// Fraction of the skin's area that the joint moves, 0 to 1.
    pub skin_share: f32,
}

/// A symmetric 3x3 matrix: xx, yy, zz, xy, xz, yz.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct SecondMoment(pub(crate) [f32; 6]);

impl SecondMoment {
    /// Mean of `x x^T` over weighted points; zero if the weights sum to 0.
    pub(crate) fn of(points: impl IntoIterator<Item = (Vec3, f32)>) -> Self {
        let mut sums = [0.0f64; 6];
        let mut total = 0.0f64;
        for (p, w) in points {
            let (x, y, z, w) = (f64::from(p.x), f64::from(p.y), f64::from(p.z), f64::from(w));
            for (s, v) in sums
                .iter_mut()
                .zip([x * x, y * y, z * z, x * y, x * z, y * z])
            {
                *s += w * v;
            }
            total += w;
        }
        Self(sums.map(|s| if total > 0.0 { (s / total) as f32 } else { 0.0 }))
    }

    /// The full matrix.
    pub(crate) fn matrix(self) -> Mat3 {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        Mat3::from_cols(
            Vec3::new(xx, xy, xz),
            Vec3::new(xy, yy, yz),
            Vec3::new(xz, yz, zz),
        )
    }

    /// Root mean square displacement of the skin for a small rotation given as a vector (axis
    /// times radians, in the joint's frame). Metres.
    pub(crate) fn rms(self, rotation: Vec3) -> f32 {
        let c = self.matrix();
        let trace = c.x_axis.x + c.y_axis.y + c.z_axis.z;
        let squared = trace * rotation.length_squared() - rotation.dot(c * rotation);
        squared.max(0.0).sqrt()
    }

    /// The same, projected along the unit direction `view`: `phi^2 (a^T (tr(C) I - C) a - (w x a)^T
    /// C (w x a))` with axis `a` and direction `w`, the total displacement less the part along the
    /// line of sight.
    pub(crate) fn projected_rms(self, rotation: Vec3, view: Vec3) -> f32 {
        let along = view.cross(rotation);
        let whole = self.rms(rotation);
        (whole * whole - along.dot(self.matrix() * along))
            .max(0.0)
            .sqrt()
    }
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
        let rotation = rotation_vector(shown, wanted);
        let whole = self.second_moment.rms(rotation);
        let seen = self.second_moment.projected_rms(rotation, view);
        let part = if whole > 0.0 {
            (seen / whole).min(1.0)
        } else {
            1.0
        };
        self.held_error(shown, wanted) * part
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = Vec3> {
        (-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0).prop_map(|(x, y, z)| Vec3::new(x, y, z))
    }

    fn direction() -> impl Strategy<Value = Vec3> {
        point().prop_filter_map("direction", |p| p.try_normalize())
    }

    proptest! {
        /// Test 8 of `docs/methods/motion-lod.md` part 10: the formula against projecting the
        /// displacement of every point.
        #[test]
        fn second_moments_equal_brute_force(
            points in prop::collection::vec(point(), 5..60),
            axis in direction(),
            view in direction(),
        ) {
            let rotation = axis * 1e-3;
            let moment = SecondMoment::of(points.iter().map(|p| (*p, 1.0)));
            let formula = f64::from(moment.projected_rms(rotation, view)).powi(2);
            let (r, w) = (rotation.as_dvec3(), view.as_dvec3());
            let brute = points
                .iter()
                .map(|p| r.cross(p.as_dvec3()))
                .map(|d| (d - w * d.dot(w)).length_squared())
                .sum::<f64>()
                / points.len() as f64;
            // Relative to the unprojected motion: seen end-on, both terms cancel.
            let whole = points.iter().map(|p| r.cross(p.as_dvec3()).length_squared()).sum::<f64>()
                / points.len() as f64;
            prop_assert!((formula - brute).abs() <= 1e-5 * whole.max(1e-12), "{formula} {brute}");
        }
    }

    #[test]
    fn a_turn_seen_along_its_axis_shows_wholly_and_from_the_side_in_part() {
        // A point one metre along x, turned about z: it moves along y.
        let moment = SecondMoment::of([(Vec3::X, 2.0)]);
        let turn = Vec3::Z * 0.01;
        assert!((moment.projected_rms(turn, Vec3::Z) - 0.01).abs() < 1e-7);
        assert!((moment.projected_rms(turn, Vec3::X) - 0.01).abs() < 1e-7);
        assert!(moment.projected_rms(turn, Vec3::Y) < 1e-7);
    }
}
