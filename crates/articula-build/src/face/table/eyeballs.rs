//! Eyeballs: they turn, come out, and their pupils grow.

use super::super::fap_values::FapValues;
use articula_core::LibmQuat;
use articula_core::fap_table::ANGLE_UNIT;
use glam::{Quat, Vec3};

/// Least bulge of a ball that has a cornea: the farthest place in front by the mean of them.
const CORNEA: f32 = 1.02;
/// Radius of a pupil by that of its iris, in indoor light.
const PUPIL: f32 = 0.4;

/// An eyeball.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Eyeball {
    vertices: Vec<u32>,
    centre: Vec3,
    /// Rotation from the axis through the pupil to +Z.
    to_axis: Quat,
}

impl Eyeball {
    /// The eyeball of some vertices. The pupil is behind the middle of the cornea, where the ball bulges;
    /// a ball without a cornea looks along +Z.
    pub(super) fn new(vertices: Vec<u32>, centre: Vec3, positions: &[Vec3]) -> Self {
        let of = |v: &u32| positions[*v as usize] - centre;
        let in_front = || vertices.iter().map(of).filter(|p| p.z > 0.5 * p.length());
        let count = in_front().count().max(1) as f32;
        let mean = in_front().map(Vec3::length).sum::<f32>() / count;
        let most = in_front().map(Vec3::length).fold(mean, f32::max);
        let bulges = |p: &Vec3| p.length() > 0.5 * (mean + most);
        let middle: Vec3 = in_front().filter(bulges).map(Vec3::normalize).sum();
        let has_cornea = most > CORNEA * mean && middle != Vec3::ZERO;
        let axis = if has_cornea {
            middle.normalize()
        } else {
            Vec3::Z
        };
        Self {
            to_axis: Quat::from_rotation_arc(axis, Vec3::Z),
            vertices,
            centre,
        }
    }

    /// Sets the displacements of its vertices.
    pub(super) fn apply(&self, gaze: &Gaze, positions: &[Vec3], all: &mut [Vec3]) {
        for vertex in &self.vertices {
            let from = positions[*vertex as usize] - self.centre;
            all[*vertex as usize] = gaze.displacement(from, self.to_axis);
        }
    }
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
        let (yaw, pitch) = (values.get(23 + side), values.get(25 + side));
        Self {
            turn: Quat::libm_rotation_y(yaw * ANGLE_UNIT)
                * Quat::libm_rotation_x(pitch * ANGLE_UNIT),
            thrust: values.get(27 + side) * separation / 1024.0,
            growth: 0.5 * values.get(29 + side) * iris / 1024.0,
            iris: 0.5 * iris,
        }
    }

    /// Displacement of a place, relative to the centre of the eyeball, with the rotation from the axis
    /// through the pupil to +Z.
    fn displacement(&self, from: Vec3, to_axis: Quat) -> Vec3 {
        let dilated = if self.growth == 0.0 {
            from
        } else {
            to_axis.inverse() * self.dilated(to_axis * from)
        };
        self.turn * dilated - from + self.thrust * Vec3::Z
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
        let out = gaze(&[(27, 102.4)]).displacement(Vec3::new(0.001, 0.002, 0.01), Quat::IDENTITY);
        assert!((out - 0.006 * Vec3::Z).length() < 1e-6);
        let quarter = std::f32::consts::FRAC_PI_2 / ANGLE_UNIT;
        let left = gaze(&[(23, quarter)]).displacement(0.01 * Vec3::Z, Quat::IDENTITY);
        assert!((left - Vec3::new(0.01, 0.0, -0.01)).length() < 1e-6);
    }

    #[test]
    fn pupils_grow_along_the_ball() {
        // The pupil has a radius of 2 mm, and becomes 1 mm wider: 0.5 mm on each side.
        let gaze = gaze(&[(29, 102.4)]);
        let rim = Vec3::new(0.002, 0.0, 0.0118);
        let moved = rim + gaze.displacement(rim, Quat::IDENTITY);
        assert!((moved.x - 0.0025).abs() < 1e-6 && (moved.length() - rim.length()).abs() < 1e-7);
        for still in [
            Vec3::new(0.0, 0.0, 0.012),
            Vec3::new(0.005, 0.0, 0.011),
            Vec3::new(0.002, 0.0, -0.0118),
        ] {
            assert!(
                gaze.displacement(still, Quat::IDENTITY).length() < 1e-9,
                "{still}"
            );
        }
    }

    #[test]
    fn pupils_are_behind_the_cornea() {
        // A ball of 12 mm whose cornea bulges around a direction that looks a little aside.
        let axis = Vec3::new(0.1, 0.0, 1.0).normalize();
        let mut positions = Vec::new();
        for row in 0..=30 {
            for column in 0..60 {
                let (sin, cos) = (row as f32 / 30.0 * std::f32::consts::PI).sin_cos();
                let (y, x) = (column as f32 / 60.0 * std::f32::consts::TAU).sin_cos();
                let around = Quat::from_rotation_arc(Vec3::Z, axis);
                let radius = if row < 4 { 0.0132 } else { 0.012 };
                positions.push(radius * (around * Vec3::new(sin * x, sin * y, cos)));
            }
        }
        let all = (0..positions.len() as u32).collect();
        let eye = Eyeball::new(all, Vec3::ZERO, &positions);
        assert!((eye.to_axis * axis).angle_between(Vec3::Z) < 0.02);
        // The middle of the pupil stays where it is.
        let middle = gaze(&[(29, 102.4)]).displacement(0.0132 * axis, eye.to_axis);
        assert!(middle.length() < 2e-5, "{middle}");
        let ball: Vec<Vec3> = positions.iter().map(|p| 0.012 * p.normalize()).collect();
        let all = (0..ball.len() as u32).collect();
        assert_eq!(Eyeball::new(all, Vec3::ZERO, &ball).to_axis, Quat::IDENTITY);
    }
}
