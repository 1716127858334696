//! Eyeballs: they turn, come out, and their pupils grow.

use super::super::fap_values::FapValues;
use articula_core::fap_table::LOW_FAPS;
use glam::{Quat, Vec3};

/// Radians of an angle unit.
const ANGLE_UNIT: f32 = 1e-5;
/// Radius of a pupil by that of its iris, in indoor light.
const PUPIL: f32 = 0.4;

/// An eyeball.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Eyeball {
    pub(super) vertices: Vec<u32>,
    pub(super) centre: Vec3,
}

/// Parameters of one eyeball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Gaze {
    turn: Quat,
    /// How far it comes out, metres.
    thrust: f32,
    /// How much the radius of the pupil grows, metres.
    growth: f32,
    /// Radius of the iris, metres.
    iris: f32,
}

impl Gaze {
    /// That of the left (0) or right (1) eye, with the separation of the eyes and the diameter of the
    /// iris, metres.
    pub(super) fn of(values: &FapValues, side: usize, separation: f32, iris: f32) -> Self {
        debug_assert!(LOW_FAPS.contains(&(29 + side)));
        let (yaw, pitch) = (values.get(23 + side), values.get(25 + side));
        Self {
            turn: Quat::from_rotation_y(yaw * ANGLE_UNIT)
                * Quat::from_rotation_x(pitch * ANGLE_UNIT),
            thrust: values.get(27 + side) * separation / 1024.0,
            growth: 0.5 * values.get(29 + side) * iris / 1024.0,
            iris: 0.5 * iris,
        }
    }

    /// Displacement of a place, relative to the centre of the eyeball.
    pub(super) fn displacement(&self, from: Vec3) -> Vec3 {
        self.turn * self.dilated(from) - from + self.thrust * Vec3::Z
    }

    /// The place at which the ring around the pupil has grown: along the ball, most at the rim of the
    /// pupil, not at all at its middle and at the rim of the iris.
    fn dilated(&self, from: Vec3) -> Vec3 {
        let radius = from.truncate().length();
        if self.growth == 0.0 || from.z <= 0.0 || radius >= self.iris || radius == 0.0 {
            return from;
        }
        let pupil = PUPIL * self.iris;
        let share = match radius < pupil {
            true => radius / pupil,
            false => (self.iris - radius) / (self.iris - pupil),
        };
        // The pupil neither vanishes nor reaches the rim of the iris.
        let growth = self.growth.clamp(-0.8 * pupil, 0.8 * (self.iris - pupil));
        let to = (radius + share * growth) / radius * from.truncate();
        let depth = (from.length_squared() - to.length_squared())
            .max(0.0)
            .sqrt();
        to.extend(depth)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gaze(values: &[(usize, f32)]) -> Gaze {
        let mut all = FapValues::default();
        for (fap, value) in values {
            all.0[fap - 3] = *value;
        }
        Gaze::of(&all, 0, 0.06, 0.01)
    }

    #[test]
    fn an_eyeball_comes_out_and_turns() {
        let out = gaze(&[(27, 102.4)]).displacement(Vec3::new(0.001, 0.002, 0.01));
        assert!((out - 0.006 * Vec3::Z).length() < 1e-6);
        let quarter = std::f32::consts::FRAC_PI_2 / ANGLE_UNIT;
        let left = gaze(&[(23, quarter)]).displacement(0.01 * Vec3::Z);
        assert!((left - Vec3::new(0.01, 0.0, -0.01)).length() < 1e-6);
    }

    #[test]
    fn pupils_grow_along_the_ball() {
        // The pupil has a radius of 2 mm, and becomes 1 mm wider: 0.5 mm on each side.
        let gaze = gaze(&[(29, 102.4)]);
        let rim = Vec3::new(0.002, 0.0, 0.0118);
        let moved = rim + gaze.displacement(rim);
        assert!((moved.x - 0.0025).abs() < 1e-6 && (moved.length() - rim.length()).abs() < 1e-7);
        for still in [
            Vec3::new(0.0, 0.0, 0.012),
            Vec3::new(0.005, 0.0, 0.011),
            Vec3::new(0.002, 0.0, -0.0118),
        ] {
            assert!(gaze.displacement(still).length() < 1e-9, "{still}");
        }
    }
}
