//! Second moments of the skin of a joint: the mean displacement by a small rotation, as a whole and
//! as projected to a view.
//!
//! Source: `docs/methods/motion-lod.md` 4.1.

use crate::math::rotation_vector;
use glam::{Mat3, Quat, Vec3};

/// Mean of `x x^T` over the skin of a joint, `x` the offset from the joint in its own frame, in
/// square metres: a symmetric 3x3 matrix as xx, yy, zz, xy, xz, yz.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SecondMoment([f32; 6]);

impl SecondMoment {
    /// Mean of `x x^T` over weighted points; zero if the weights sum to 0.
    pub fn of(points: impl IntoIterator<Item = (Vec3, f32)>) -> Self {
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
    fn matrix(self) -> Mat3 {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        Mat3::from_cols(
            Vec3::new(xx, xy, xz),
            Vec3::new(xy, yy, yz),
            Vec3::new(xz, yz, zz),
        )
    }

    /// Root mean square displacement of the skin for a small rotation given as a vector (axis
    /// times radians, in the joint's frame). Metres.
    pub fn rms(self, rotation: Vec3) -> f32 {
        let c = self.matrix();
        let trace = c.x_axis.x + c.y_axis.y + c.z_axis.z;
        let squared = trace * rotation.length_squared() - rotation.dot(c * rotation);
        squared.max(0.0).sqrt()
    }

    /// The same, projected along the unit direction `view`: `phi^2 (a^T (tr(C) I - C) a - (w x a)^T
    /// C (w x a))` with axis `a` and direction `w`, the total displacement less the part along the
    /// line of sight.
    pub fn projected_rms(self, rotation: Vec3, view: Vec3) -> f32 {
        let along = view.cross(rotation);
        let whole = self.rms(rotation);
        (whole * whole - along.dot(self.matrix() * along))
            .max(0.0)
            .sqrt()
    }

    /// Returns the fraction, 0 to 1, of the displacement that is seen along the unit direction
    /// `view` in the joint's frame if `shown` is used in place of `wanted`. A joint without skin
    /// is seen whole.
    pub fn seen_fraction(self, shown: Quat, wanted: Quat, view: Vec3) -> f32 {
        let rotation = rotation_vector(shown, wanted);
        let whole = self.rms(rotation);
        if whole > 0.0 {
            (self.projected_rms(rotation, view) / whole).min(1.0)
        } else {
            1.0
        }
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
