//! Pixels that a displacement of one metre may span, anywhere in a bound.
//!
//! Source: `docs/metrics.md`, "Pixels per metre of a bound". In camera space a point at depth `z` and
//! `l` metres from the axis is displaced by `d` metres, to a depth `z'`. In the picture it moves by
//! `f |(dx, dy) - dz (x, y) / z| / z'` pixels, which is at most `f d sqrt(1 + (l / z)^2) / z'`, by
//! Cauchy and Schwarz. Depths are at least the nearest depth of the bound, and `l` is at most its
//! greatest distance from the axis; where the point is in the picture, `sqrt(1 + (l / z)^2)` is at
//! most the secant of the angle to its farthest corner.

use super::frustum::Tangents;

/// Minimum depth in metres; smaller depths count as this, so that a camera inside a body gets
/// finite pixels per metre.
pub const MIN_DEPTH_METRES: f32 = 0.1;

/// Number of pixels that a displacement of one metre may span.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum PixelDensity {
    /// Perspective.
    Perspective {
        /// Value on the axis at a depth of one metre; it falls with depth and rises towards the
        /// sides of the picture.
        at_one_metre: f32,
        /// Cosine of the angle between the axis and the farthest corner of the picture.
        corner_cosine: f32,
    },
    /// Parallel projection: value at any place.
    Everywhere(f32),
}

impl PixelDensity {
    /// The density of a perspective picture.
    pub(super) fn perspective(at_one_metre: f32, tangents: Tangents) -> Self {
        let across = tangents.left.abs().max(tangents.right.abs());
        let up = tangents.down.abs().max(tangents.up.abs());
        Self::Perspective {
            at_one_metre,
            corner_cosine: 1.0 / (1.0 + across * across + up * up).sqrt(),
        }
    }

    /// Whether it is a positive number at any depth.
    pub(super) fn is_valid(self) -> bool {
        let most = self.most();
        most > 0.0 && most <= f32::MAX
    }

    /// Number of metres for which no shorter displacement spans a pixel, of points that are at least
    /// `depth_metres` deep and at most `aside_metres` from the axis. Depths below
    /// [`MIN_DEPTH_METRES`] count as that.
    pub(super) fn metres_per_px(self, depth_metres: f32, aside_metres: f32) -> f32 {
        match self {
            Self::Perspective {
                at_one_metre,
                corner_cosine,
            } => {
                let depth = depth_metres.max(MIN_DEPTH_METRES);
                let along = (depth * depth + aside_metres * aside_metres).sqrt();
                // A distance beyond all numbers gives 0.
                depth * (1.0 / at_one_metre) * (depth / along).max(corner_cosine)
            }
            Self::Everywhere(pixels) => 1.0 / pixels,
        }
    }

    /// The reciprocal of [`PixelDensity::metres_per_px`].
    pub(super) fn at(self, depth_metres: f32, aside_metres: f32) -> f32 {
        1.0 / self.metres_per_px(depth_metres, aside_metres)
    }

    /// Value beyond which it never rises.
    pub(super) fn most(self) -> f32 {
        match self {
            Self::Perspective {
                at_one_metre,
                corner_cosine,
            } => at_one_metre / (MIN_DEPTH_METRES * corner_cosine),
            Self::Everywhere(pixels) => pixels,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere::Sphere;
    use crate::view::{Camera, Viewport};
    use crate::visibility::look::{BoxSight, look_at_box, look_at_one};
    use crate::visibility::{View, Visibility};
    use glam::{Quat, Vec3};
    use proptest::prelude::*;

    const TANGENTS: Tangents = Tangents {
        left: 1.0,
        right: 0.5,
        down: 2.0,
        up: -0.25,
    };

    #[test]
    fn by_hand() {
        let density = PixelDensity::perspective(600.0, TANGENTS);
        // 3 m deep and 4 m aside is 5 m away: 600 / 3 * 5 / 3 pixels.
        assert!((density.at(3.0, 4.0) - 1000.0 / 3.0).abs() < 1e-3);
        assert!((density.at(3.0, 0.0) - 200.0).abs() < 1e-3);
        // The corner at (1, 2) is sqrt(6) away at a depth of 1; nothing aside of it is seen.
        let corner = 200.0 * 6f32.sqrt();
        assert!((density.at(3.0, 1e9) - corner).abs() < 1e-2);
        assert!((density.at(3.0, f32::MAX) - corner).abs() < 1e-2);
        assert!((density.at(-1.0, 1e9) - density.most()).abs() < 1.0);
        assert_eq!(PixelDensity::Everywhere(20.0).at(3.0, 4.0), 20.0);
    }

    fn vector(size: f32) -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-size..size).prop_map(Vec3::from)
    }

    /// A camera, wide or narrow.
    fn camera() -> impl Strategy<Value = Camera> {
        let viewport = (200.0f32..2000.0, 200.0f32..2000.0, 0.1f32..2.5);
        (vector(10.0), vector(3.0), viewport).prop_map(|(eye, turn, (width, height, fov))| Camera {
            eye,
            orientation: Quat::from_scaled_axis(turn),
            viewport: Viewport {
                width_px: width,
                height_px: height,
                fov_y_radians: fov,
            },
        })
    }

    /// A body that the camera sees, at a depth and a place relative to the picture.
    fn body(camera: &Camera, (depth, across, up): (f32, f32, f32), radius: f32) -> Sphere {
        let tangent = (0.5 * camera.viewport.fov_y_radians).tan();
        let side = tangent * camera.viewport.width_px / camera.viewport.height_px;
        let at = Vec3::new(across * side * depth, up * tangent * depth, -depth);
        Sphere {
            centre: camera.eye + camera.orientation * at,
            radius,
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// No two points of a bound, one of them in the picture, are farther apart on the screen
        /// than its pixels per metre say, however near, far aside or large the bound is.
        #[test]
        fn bounds_every_displacement_inside_of_a_bound(
            camera in camera(),
            place in (0.2f32..40.0, -1.5f32..1.5, -1.5f32..1.5),
            radius in 0.05f32..5.0,
            from in vector(1.0),
            to in vector(1.0),
            part in prop_oneof![Just(1e-3f32), Just(0.05), 0.0f32..1.0],
        ) {
            let bound = body(&camera, place, radius);
            let seen = look_at_one(&[View::of(&camera)], bound);
            if seen.visibility != Visibility::Visible {
                return Ok(());
            }
            let inside = |v: Vec3| bound.centre + v * (radius / v.length().max(1.0));
            let from = inside(from);
            let to = from + (inside(to) - from) * part;
            let ((a, depth), (b, other)) = (camera.project(from), camera.project(to));
            let size = glam::Vec2::new(camera.viewport.width_px, camera.viewport.height_px);
            let shown = |p: glam::Vec2| p.cmpge(glam::Vec2::ZERO).all() && p.cmple(size).all();
            if depth.min(other) < MIN_DEPTH_METRES || !(shown(a) || shown(b)) {
                return Ok(());
            }
            // Rounding of positions up to 60 m from the origin, and of pixels.
            let noise = 2e-5 * seen.pixels_per_metre + 1e-3;
            let most = from.distance(to) * seen.pixels_per_metre * 1.0001 + noise;
            prop_assert!(a.distance(b) <= most, "{} above {most}", a.distance(b));
        }

        /// What holds for a box holds for all bounds in it.
        #[test]
        fn a_box_has_the_bodies_within_its_range(
            camera in camera(),
            place in (0.2f32..60.0, -1.2f32..1.2, -1.2f32..1.2),
            half in prop::array::uniform3(0.01f32..20.0),
            inside in prop::collection::vec((vector(1.0), 0.0f32..1.0), 1..8),
        ) {
            let half = Vec3::from(half);
            let centre = body(&camera, place, 0.0).centre;
            let views = [View::of(&camera)];
            let bodies = inside.iter().map(|(at, share)| {
                // The room that is left to each side of the centre.
                let room = (half * (Vec3::ONE - at.abs())).min_element();
                Sphere { centre: centre + half * *at, radius: room * share }
            });
            let sight = look_at_box(&views, centre - half, centre + half);
            for bound in bodies {
                let seen = look_at_one(&views, bound);
                match sight {
                    BoxSight::Nothing => prop_assert_eq!(seen.visibility, Visibility::Hidden),
                    BoxSight::Some => {}
                    BoxSight::All([low, high]) => {
                        prop_assert_eq!(seen.visibility, Visibility::Visible);
                        let metres = 1.0 / seen.pixels_per_metre;
                        prop_assert!(low <= metres && metres <= high, "{metres} outside of {low} to {high}");
                    }
                }
            }
        }
    }
}
