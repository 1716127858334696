//! Root motion of a clip: translation and heading of the whole character, apart from the pose.
//!
//! Root motion is never a joint (`docs/methods/motion-lod.md` part 0): it advances at every level,
//! and for hidden characters too.

use crate::Libm;
use crate::Mismatch;
use glam::Vec3;

/// A root transform relative to a start: offset and turn about +Y.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RootDelta {
    /// Offset in metres, in the space of the start.
    pub offset: Vec3,
    /// Turn about +Y in radians, not wrapped.
    pub yaw_radians: f32,
}

impl RootDelta {
    /// This delta followed by `next`.
    #[must_use]
    pub(crate) fn then(self, next: Self) -> Self {
        Self {
            offset: self.offset + turned(next.offset, self.yaw_radians),
            yaw_radians: self.yaw_radians + next.yaw_radians,
        }
    }

    /// The inverse delta.
    #[must_use]
    pub(crate) fn inverse(self) -> Self {
        Self {
            offset: turned(-self.offset, -self.yaw_radians),
            yaw_radians: -self.yaw_radians,
        }
    }

    pub(crate) fn lerp(self, other: Self, t: f32) -> Self {
        Self {
            offset: self.offset.lerp(other.offset, t),
            yaw_radians: self.yaw_radians + (other.yaw_radians - self.yaw_radians) * t,
        }
    }
}

/// A vector turned about +Y.
fn turned(v: Vec3, radians: f32) -> Vec3 {
    if radians == 0.0 {
        return v;
    }
    let (sin, cos) = radians.libm_sin_cos();
    Vec3::new(cos * v.x + sin * v.z, v.y, cos * v.z - sin * v.x)
}

/// Root motion of one clip, sampled at a uniform rate from its first to its last frame.
#[derive(Debug, Clone, PartialEq)]
pub struct RootTrajectory {
    rate_hz: f32,
    places: Vec<RootDelta>,
}

impl RootTrajectory {
    /// Makes the trajectory from the root transform at each frame, relative to the first; turns are
    /// not wrapped.
    ///
    /// # Errors
    /// A [`Mismatch`] if `places` is empty or not finite, or the rate is not positive and finite.
    pub fn new(rate_hz: f32, places: Vec<RootDelta>) -> Result<Self, Mismatch> {
        if !(rate_hz.is_finite() && rate_hz > 0.0) {
            return Err(Mismatch::new(
                "rate_hz",
                format!("must be positive and finite, found {rate_hz}"),
            ));
        }
        let bad = |p: &RootDelta| !(p.offset.is_finite() && p.yaw_radians.is_finite());
        if places.is_empty() || places.iter().any(bad) {
            let what = "must hold at least one delta, and finite values only";
            return Err(Mismatch::new("places", what));
        }
        Ok(Self { rate_hz, places })
    }

    /// Frames per second.
    pub fn rate_hz(&self) -> f32 {
        self.rate_hz
    }

    /// Root transform at each frame, relative to the first.
    pub fn places(&self) -> &[RootDelta] {
        &self.places
    }

    /// Root transform at a time of the clip, interpolated linearly and clamped to its ends.
    pub fn at(&self, secs: f32) -> RootDelta {
        let last = self.places.len() - 1;
        let at = (secs * self.rate_hz).max(0.0).min(last as f32);
        let before = (at as usize).min(last);
        let after = (before + 1).min(last);
        self.places[before].lerp(self.places[after], at - before as f32)
    }

    /// Root motion from one time to another, with the clip's end passed `laps` times (negative:
    /// backwards).
    pub fn step(&self, from_secs: f32, to_secs: f32, laps: i32) -> RootDelta {
        let from = self.at(from_secs);
        if laps == 0 {
            let to = self.at(to_secs);
            return RootDelta {
                offset: turned(to.offset - from.offset, -from.yaw_radians),
                yaw_radians: to.yaw_radians - from.yaw_radians,
            };
        }
        let back = from.inverse();
        let start = self.places[0];
        let lap = start.inverse().then(self.places[self.places.len() - 1]);
        let lap = if laps < 0 { lap.inverse() } else { lap };
        // Back to the start, whole laps, then on to the end time.
        let mut way = back.then(start);
        for _ in 0..laps.unsigned_abs() {
            way = way.then(lap);
        }
        way.then(start.inverse().then(self.at(to_secs)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Affine3A, Quat};
    use proptest::prelude::*;
    use std::f32::consts::FRAC_PI_2;

    #[test]
    fn a_lap_goes_on_from_where_it_led() {
        // A metre ahead and a quarter turn to the left in a second.
        let end = RootDelta {
            offset: Vec3::Z,
            yaw_radians: FRAC_PI_2,
        };
        let path = RootTrajectory::new(1.0, vec![RootDelta::default(), end]).unwrap();
        let twice = path.step(0.0, 0.0, 2);
        assert!((twice.offset - Vec3::new(1.0, 0.0, 1.0)).length() < 1e-6);
        assert!((twice.yaw_radians - 2.0 * FRAC_PI_2).abs() < 1e-6);
        let back = path.step(0.0, 0.0, -2);
        let nothing = twice.then(back);
        assert!(nothing.offset.length() < 1e-6 && nothing.yaw_radians.abs() < 1e-6);
        // Steps that follow each other add up.
        let parts = path.step(0.2, 0.9, 0).then(path.step(0.9, 0.4, 1));
        let whole = path.step(0.2, 0.4, 1);
        assert!((parts.offset - whole.offset).length() < 1e-6);
    }

    #[test]
    fn between_frames_by_hand() {
        let place = |x, yaw_radians| RootDelta {
            offset: Vec3::X * x,
            yaw_radians,
        };
        let places = vec![place(0.0, 0.0), place(1.0, 0.5), place(5.0, 1.5)];
        let path = RootTrajectory::new(2.0, places.clone()).unwrap();
        assert_eq!((path.rate_hz(), path.places()), (2.0, &places[..]));
        for (secs, x, yaw) in [
            (-1.0, 0.0, 0.0),
            (0.25, 0.5, 0.25),
            (0.5, 1.0, 0.5),
            (0.875, 4.0, 1.25),
            (1.0, 5.0, 1.5),
            (100.0, 5.0, 1.5),
        ] {
            assert_eq!(path.at(secs), place(x, yaw), "{secs} s");
        }
    }

    fn matrix(delta: RootDelta) -> Affine3A {
        let rotation = Quat::from_rotation_y(delta.yaw_radians);
        Affine3A::from_rotation_translation(rotation, delta.offset)
    }

    fn delta() -> impl Strategy<Value = RootDelta> {
        let axis = || -2.0_f32..2.0;
        (axis(), axis(), axis(), -4.0_f32..4.0).prop_map(|(x, y, z, yaw_radians)| RootDelta {
            offset: Vec3::new(x, y, z),
            yaw_radians,
        })
    }

    proptest! {
        /// Deltas are rigid transforms, and a step over the end goes through the end and the start.
        #[test]
        fn steps_are_products_of_matrices(
            places in prop::collection::vec(delta(), 1..4),
            from in 0.0_f32..3.0,
            to in 0.0_f32..3.0,
            laps in -3_i32..4,
        ) {
            let (first, last) = (matrix(places[0]), matrix(places[places.len() - 1]));
            let path = RootTrajectory::new(1.0, places).unwrap();
            // To the far end, over the seam for each lap, and on from the near end.
            let (far, near) = if laps < 0 { (first, last) } else { (last, first) };
            let mut way = matrix(path.at(from)).inverse();
            for _ in 0..laps.unsigned_abs() {
                way = way * far * near.inverse();
            }
            way *= matrix(path.at(to));
            let found = path.step(from, to, laps);
            prop_assert!(matrix(found).abs_diff_eq(way, 1e-3), "{found:?}");
        }
    }

    #[test]
    fn refuses_what_is_no_path() {
        let at = |r: Result<RootTrajectory, Mismatch>| r.unwrap_err().at;
        assert_eq!(
            at(RootTrajectory::new(0.0, vec![RootDelta::default()])),
            "rate_hz"
        );
        assert_eq!(at(RootTrajectory::new(1.0, Vec::new())), "places");
        let bad = RootDelta {
            yaw_radians: f32::NAN,
            ..RootDelta::default()
        };
        assert_eq!(at(RootTrajectory::new(1.0, vec![bad])), "places");
    }
}
