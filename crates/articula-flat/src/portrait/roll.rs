//! Roll: the turn of the head in the plane of the picture, which vertices follow in 2D.

use glam::Vec2;

/// Steps of [`Roll::depths`] in one.
pub(super) const DEPTH_STEPS: f32 = 256.0;

/// How the vertices of a portrait follow a roll.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Roll {
    /// Part of a roll that each vertex takes, 0 to 255.
    pub(crate) tilts: Vec<u8>,
    /// Depth of the pivot by that of each vertex, less 1, in steps of 1/256: nearer vertices turn about a
    /// centre that is farther from the middle of the picture.
    pub(crate) depths: Vec<i8>,
    /// Whether a vertex with a part of the roll lies between the places without and with all of it, as skin
    /// between two joints does; else it turns by its part of the angle, as with several joints.
    pub(crate) blends: bool,
    /// Centre of roll, pixels.
    pub(crate) pivot: Vec2,
}

impl Roll {
    /// Turns places by an angle in degrees, counter-clockwise as seen. `middle` is that of the picture.
    pub(crate) fn turn(&self, places: &mut [Vec2], roll_degrees: f32, middle: Vec2) {
        // The picture's y axis points down, so counter-clockwise is a negative angle.
        let angle = -roll_degrees.to_radians();
        let from_middle = self.pivot - middle;
        for ((place, tilt), depth) in places.iter_mut().zip(&self.tilts).zip(&self.depths) {
            let part = f32::from(*tilt) / 255.0;
            let centre = self.pivot + from_middle * (f32::from(*depth) / DEPTH_STEPS);
            let turn = if self.blends { angle } else { part * angle };
            let turned = centre + Vec2::from_angle(turn).rotate(*place - centre);
            *place = if self.blends {
                place.lerp(turned, part)
            } else {
                turned
            };
        }
    }
}

/// Depth of a pivot by that of a vertex, less 1, in steps.
pub(super) fn depth_steps(pivot: f32, vertex: f32) -> i8 {
    ((pivot / vertex - 1.0) * DEPTH_STEPS)
        .round()
        .clamp(-128.0, 127.0) as i8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter turn about a pivot 10 pixels below the middle of the picture.
    fn quarter(blends: bool) -> Vec<Vec2> {
        let roll = Roll {
            tilts: vec![255, 0, 255],
            depths: vec![0, 0, depth_steps(2.0, 1.0)],
            blends,
            pivot: Vec2::new(0.0, 10.0),
        };
        let mut places = vec![Vec2::ZERO; 3];
        roll.turn(&mut places, 90.0, Vec2::ZERO);
        places
    }

    #[test]
    fn a_vertex_turns_about_the_pivot_at_its_depth() {
        for blends in [false, true] {
            let places = quarter(blends);
            // Up is negative y; counter-clockwise, what is above the pivot goes to the left.
            assert!(
                places[0].distance(Vec2::new(-10.0, 10.0)) < 1e-4,
                "{}",
                places[0]
            );
            assert_eq!(places[1], Vec2::ZERO);
            // At half the depth the pivot is seen nearly twice as far from the middle: 127 steps.
            let low = 10.0 * (1.0 + 127.0 / 256.0);
            assert!(
                places[2].distance(Vec2::new(-low, low)) < 1e-4,
                "{}",
                places[2]
            );
        }
    }

    #[test]
    fn skin_between_two_joints_lies_on_the_line_between() {
        let half = |blends| {
            let roll = Roll {
                tilts: vec![255, 51],
                depths: vec![0; 2],
                blends,
                pivot: Vec2::ZERO,
            };
            let mut places = vec![Vec2::new(0.0, -10.0); 2];
            roll.turn(&mut places, 90.0, Vec2::ZERO);
            places[1]
        };
        assert!(half(true).distance(Vec2::new(-2.0, -8.0)) < 1e-4);
        // A fifth of the angle.
        assert!((half(false).length() - 10.0).abs() < 1e-4);
        assert!((half(false).x + 10.0 * 18.0_f32.to_radians().sin()).abs() < 1e-4);
    }
}
