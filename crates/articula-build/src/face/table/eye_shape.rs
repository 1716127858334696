//! The surface of an eye, of which lids stay outside.

use super::graph::smooth;
use articula_core::Libm;
use glam::Vec3;

/// Directions from the axis of the eye to behind it, of which the surface is known: one for each 5°.
const DIRECTIONS: usize = 25;
const DIRECTION: f32 = std::f32::consts::PI / 36.0;

/// Depths before the middle of an eye, by the distance from it, below which a place is beside the eye, and
/// above which it is in front of it.
const FRONT: [f32; 2] = [0.5, 0.8];

/// The surface of an eye, in the frame of the head, metres: its distance from the middle by the angle from its
/// axis, which points out of the face (+Z).
#[derive(Debug, Clone, PartialEq)]
pub struct EyeShape {
    /// Middle of the eye, metres.
    pub centre: Vec3,
    /// Empty where no eyeball is known.
    radii: Vec<f32>,
}

impl EyeShape {
    /// The surface of the outermost of some places.
    pub(super) fn new(centre: Vec3, places: impl Iterator<Item = Vec3>) -> Self {
        let mut radii: Vec<f32> = Vec::new();
        let mut most = [0.0_f32; DIRECTIONS];
        for place in places {
            let from = place - centre;
            if let Some(radius) = most.get_mut(direction(from).round() as usize) {
                *radius = radius.max(from.length());
            }
        }
        if let Some(first) = most.into_iter().find(|r| *r > 0.0) {
            // A direction without vertices is as far as the one before.
            let mut last = first;
            radii.extend(most.into_iter().map(|radius| {
                last = if radius > 0.0 { radius } else { last };
                last
            }));
        }
        Self { centre, radii }
    }

    /// Where no eyeball is known, the largest ball that has a distance from some places.
    pub(super) fn or_behind(mut self, places: impl Iterator<Item = Vec3>, distance: f32) -> Self {
        if self.radii.is_empty() {
            let away = places.map(|p| p.distance(self.centre));
            let nearest = away.fold(f32::INFINITY, f32::min);
            self.radii = vec![(nearest - distance).max(0.0)];
        }
        self
    }

    /// Returns the distance of the surface from the middle in a direction of any length, metres; 0 where no eyeball is known.
    pub fn radius(&self, from: Vec3) -> f32 {
        let at = direction(from);
        let index = at as usize;
        match self.radii.get(index..index + 2) {
            Some([a, b]) => a + (at - index as f32) * (b - a),
            _ => self.radii.last().copied().unwrap_or(0.0),
        }
    }

    /// Returns the offset that brings a place to a distance outside, zero if it is there already: to the
    /// front, and beside the eye along the radius.
    pub(super) fn out_of(&self, place: Vec3, distance: f32) -> Vec3 {
        let from = place - self.centre;
        let mut to = from;
        // The surface is not as far in every direction.
        for _ in 0..3 {
            let least = self.radius(to) + distance;
            let length = to.length();
            if length >= least || length == 0.0 {
                break;
            }
            let [beside, before] = FRONT;
            let aside = smooth((before - to.z / length) / (before - beside));
            let along = (aside * to.truncate()).extend(to.z);
            // The length of to + s along is the least one.
            let (square, mixed) = (along.length_squared(), to.dot(along));
            let rest = length * length - least * least;
            let s = ((mixed * mixed - square * rest).max(0.0).sqrt() - mixed) / square;
            to += s * along;
        }
        to - from
    }
}

/// Angle from the axis, in steps of the directions.
fn direction(from: Vec3) -> f32 {
    from.truncate().length().libm_atan2(from.z) / DIRECTION
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cornea_bulges() {
        // A ball of 1 m, with a bulge of 0.1 m within 15° around its axis.
        let places = (0..=36).map(|i| {
            let (sin, cos) = (i as f32 * DIRECTION).sin_cos();
            let radius = if i <= 3 { 1.1 } else { 1.0 };
            Vec3::new(0.0, radius * sin, radius * cos)
        });
        let eye = EyeShape::new(Vec3::ZERO, places);
        assert!((eye.radius(Vec3::Z) - 1.1).abs() < 1e-6);
        assert!((eye.radius(Vec3::Y) - 1.0).abs() < 1e-6);
        assert!((eye.radius(Vec3::new(1.0, 1.0, 0.1)) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn places_inside_come_out() {
        let eye = EyeShape::new(Vec3::ZERO, std::iter::once(Vec3::Z));
        // To the front, at the same height.
        let out = eye.out_of(Vec3::new(0.0, 0.3, 0.9), 0.02);
        assert_eq!(out.truncate(), glam::Vec2::ZERO);
        assert!((Vec3::new(0.0, 0.3, 0.9) + out).length() - 1.02 < 1e-6);
        // Beside the eye along the radius.
        let beside = eye.out_of(Vec3::new(0.0, 0.9, 0.0), 0.02);
        assert!((beside - 0.12 * Vec3::Y).length() < 1e-6, "{beside}");
        assert_eq!(eye.out_of(1.03 * Vec3::Y, 0.02), Vec3::ZERO);
    }

    #[test]
    fn without_eyeball_it_is_behind_the_lids() {
        let unknown = EyeShape::new(Vec3::Z, std::iter::empty());
        assert_eq!(unknown.radius(Vec3::Z), 0.0);
        let rims = [Vec3::new(1.0, 0.0, 1.0), 3.0 * Vec3::Z];
        let eye = unknown.or_behind(rims.into_iter(), 0.1);
        assert!((eye.radius(Vec3::X) - 0.9).abs() < 1e-6);
    }
}
