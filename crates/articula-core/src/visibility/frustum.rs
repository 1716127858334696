//! View frustum: the space between four sides, from a near depth to a far one.
//!
//! The near depth is that of the eye unless given, and there is no far depth unless given: a body
//! between the eye and a renderer's near plane must still move, since its shadow or its hand may
//! reach into view.

use crate::Libm;
use crate::view::{Camera, Viewport};
use glam::{Quat, Vec3, Vec4};

/// Tangents of the angles between the viewing direction and the sides of a picture.
///
/// Headsets give the four angles of each eye; they differ from side to side. One may be negative,
/// as long as the picture is not empty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tangents {
    /// Tangent of the angle to the left side.
    pub left: f32,
    /// Tangent of the angle to the right side.
    pub right: f32,
    /// Tangent of the angle to the lower side.
    pub down: f32,
    /// Tangent of the angle to the upper side.
    pub up: f32,
}

impl Tangents {
    /// Tangents of a picture that is centred on the viewing direction.
    pub(crate) fn of(viewport: &Viewport) -> Self {
        let up = (0.5 * viewport.fov_y_radians).libm_tan();
        let side = up * viewport.width_px / viewport.height_px;
        Self {
            left: side,
            right: side,
            down: up,
            up,
        }
    }
}

/// View frustum of a camera, in world space.
///
/// A frustum of invalid values (NaN, an empty picture or one half a turn wide) sees nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frustum {
    pub(crate) eye: Vec3,
    pub(crate) forward: Vec3,
    /// Inward unit normal and offset: a point `p` is inside where
    /// `normal . (p - eye) + offset >= 0`. Relative to the eye, so that precision is kept far from
    /// the origin of the world.
    pub(crate) sides: [Vec4; 4],
    pub(crate) near_metres: f32,
    pub(crate) far_metres: f32,
}

impl Frustum {
    /// The frustum that sees nothing.
    pub(crate) const NOTHING: Self = Self {
        eye: Vec3::ZERO,
        forward: Vec3::NAN,
        sides: [Vec4::NAN; 4],
        near_metres: 0.0,
        far_metres: f32::MAX,
    };

    /// Frustum of a perspective camera.
    pub(crate) fn of(camera: &Camera) -> Self {
        let tangents = Tangents::of(&camera.viewport);
        Self::perspective(camera.eye, camera.orientation, tangents)
    }

    /// Frustum from a point through a picture that need not be centred; the orientation is world
    /// from camera, looking along -Z.
    pub(crate) fn perspective(eye: Vec3, orientation: Quat, tangents: Tangents) -> Self {
        let Tangents {
            left,
            right,
            down,
            up,
        } = tangents;
        let is_picture = left + right > 0.0 && down + up > 0.0;
        let side = |x: f32, y: f32, tangent: f32| Vec3::new(x, y, -tangent).normalize().extend(0.0);
        let sides = [
            side(1.0, 0.0, left),
            side(-1.0, 0.0, right),
            side(0.0, 1.0, down),
            side(0.0, -1.0, up),
        ];
        Self::new(eye, orientation, sides, is_picture)
    }

    /// Frustum of a parallel projection: a beam of the given half width and half height in metres.
    pub(crate) fn orthographic(
        eye: Vec3,
        orientation: Quat,
        half_width: f32,
        half_height: f32,
    ) -> Self {
        let is_picture = half_width > 0.0 && half_height > 0.0;
        let sides = [
            Vec3::X.extend(half_width),
            Vec3::NEG_X.extend(half_width),
            Vec3::Y.extend(half_height),
            Vec3::NEG_Y.extend(half_height),
        ];
        Self::new(eye, orientation, sides, is_picture)
    }

    /// Returns the frustum with a near depth. A depth below zero lets a parallel projection see
    /// behind its eye.
    #[must_use]
    pub(crate) fn with_near(self, near_metres: f32) -> Self {
        Self {
            near_metres,
            ..self
        }
    }

    /// Returns the frustum with a far depth.
    #[must_use]
    pub(crate) fn with_far(self, far_metres: f32) -> Self {
        Self {
            far_metres: far_metres.min(f32::MAX),
            ..self
        }
    }

    /// Depth of a point along the viewing direction, metres; negative behind the eye.
    #[cfg(test)]
    pub(crate) fn depth(&self, point: Vec3) -> f32 {
        self.forward.dot(point - self.eye)
    }

    /// Distance of a point from the axis through the eye along the viewing direction, metres.
    #[cfg(test)]
    pub(crate) fn aside(&self, point: Vec3) -> f32 {
        let at = point - self.eye;
        (at - self.forward * self.forward.dot(at)).length()
    }

    /// Whether a sphere may be visible: true for every sphere that reaches inside, and for a few
    /// beyond a corner. The plain version of [`crate::visibility::cull`] for one body.
    #[cfg(test)]
    pub(crate) fn meets(&self, centre: Vec3, radius: f32) -> bool {
        let depth = self.depth(centre);
        let inside = |side: &Vec4| {
            let normal = side.truncate();
            normal.dot(centre - self.eye) + side.w >= -radius
        };
        // An infinite depth or NaN passes no comparison.
        depth.abs() <= f32::MAX
            && depth + radius >= self.near_metres
            && depth - radius <= self.far_metres
            && self.sides.iter().all(inside)
    }

    /// Whether a point is visible.
    #[cfg(test)]
    pub(crate) fn contains(&self, point: Vec3) -> bool {
        self.meets(point, 0.0)
    }

    fn new(eye: Vec3, orientation: Quat, sides: [Vec4; 4], is_picture: bool) -> Self {
        let orientation = orientation.normalize();
        let turned = sides.map(|s| (orientation * s.truncate()).extend(s.w));
        let is_finite =
            eye.is_finite() && orientation.is_finite() && turned.iter().all(|s| s.is_finite());
        if !(is_picture && is_finite) {
            return Self::NOTHING;
        }
        Self {
            eye,
            forward: orientation * Vec3::NEG_Z,
            sides: turned,
            ..Self::NOTHING
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn camera() -> Camera {
        Camera::looking_at(Vec3::Z * 5.0, Vec3::ZERO, Viewport::default())
    }

    #[test]
    fn edges_by_hand() {
        // 5 m away 45 degrees show 2 * 5 * tan(22.5) = 4.1421 m of height, 16:9 of it in width.
        let frustum = Frustum::of(&camera());
        let (half_height, half_width) = (2.071, 3.681);
        for (point, seen) in [
            (Vec3::Y * half_height, true),
            (Vec3::Y * (half_height + 0.002), false),
            (Vec3::NEG_X * half_width, true),
            (Vec3::NEG_X * (half_width + 0.004), false),
            (Vec3::Z * 4.999, true),
            (Vec3::Z * 5.001, false),
            (Vec3::NEG_Z * 1e6, true),
        ] {
            assert_eq!(frustum.contains(point), seen, "{point}");
        }
        assert!(frustum.meets(Vec3::Z * 6.0, 1.001), "reaches the eye");
        assert!(!frustum.meets(Vec3::Z * 6.0, 0.999));
        let cut = frustum.with_near(1.0).with_far(9.0);
        assert!(!cut.contains(Vec3::Z * 4.5) && cut.contains(Vec3::Z * 3.5));
        assert!(!cut.contains(Vec3::NEG_Z * 5.0) && cut.meets(Vec3::NEG_Z * 5.0, 1.01));
    }

    #[test]
    fn a_headset_sees_more_to_one_side() {
        let tangents = Tangents {
            left: 1.0,
            right: 0.5,
            down: 1.0,
            up: 0.8,
        };
        let frustum = Frustum::perspective(Vec3::ZERO, Quat::IDENTITY, tangents);
        let at = |x: f32, y: f32| frustum.contains(Vec3::new(x, y, -1.0));
        assert!(at(-0.99, 0.0) && !at(-1.01, 0.0) && at(0.49, 0.0) && !at(0.51, 0.0));
        assert!(at(0.0, -0.99) && !at(0.0, -1.01) && at(0.0, 0.79) && !at(0.0, 0.81));
    }

    #[test]
    fn a_beam_does_not_widen() {
        let sun = Frustum::orthographic(Vec3::Y * 10.0, Quat::IDENTITY, 2.0, 1.0);
        for depth in [0.0, 100.0] {
            assert!(sun.contains(Vec3::new(1.99, 10.99, -depth)));
            assert!(!sun.contains(Vec3::new(2.01, 10.0, -depth)));
        }
        assert!(!sun.contains(Vec3::new(0.0, 10.0, 3.0)));
        assert!(
            sun.with_near(-5.0).contains(Vec3::new(0.0, 10.0, 3.0)),
            "behind its eye, where it is told so"
        );
    }

    #[test]
    fn what_is_no_camera_sees_nothing() {
        let hostile = |change: &dyn Fn(&mut Camera)| {
            let mut camera = camera();
            change(&mut camera);
            Frustum::of(&camera)
        };
        for frustum in [
            hostile(&|c| c.eye.x = f32::NAN),
            hostile(&|c| c.eye.y = f32::INFINITY),
            hostile(&|c| c.orientation = Quat::from_xyzw(0.0, 0.0, 0.0, 0.0)),
            hostile(&|c| c.viewport.fov_y_radians = 0.0),
            hostile(&|c| c.viewport.fov_y_radians = f32::NAN),
            hostile(&|c| c.viewport.fov_y_radians = 4.0),
            hostile(&|c| c.viewport.width_px = 0.0),
            hostile(&|c| c.viewport.height_px = 0.0),
            Frustum::orthographic(Vec3::ZERO, Quat::IDENTITY, f32::INFINITY, 1.0),
        ] {
            for point in [Vec3::ZERO, Vec3::Z * 4.0, Vec3::NAN, Vec3::INFINITY] {
                assert!(!frustum.contains(point));
            }
        }
        let frustum = Frustum::of(&camera());
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert!(!frustum.contains(Vec3::splat(bad)));
            assert!(!frustum.contains(Vec3::new(0.0, 0.0, bad)));
        }
    }

    proptest! {
        /// A point is inside exactly if it projects into the picture.
        #[test]
        fn agrees_with_the_projection(
            eye in prop::array::uniform3(-20.0f32..20.0),
            target in prop::array::uniform3(-20.0f32..20.0),
            point in prop::array::uniform3(-30.0f32..30.0),
        ) {
            let [eye, target, point] = [eye, target, point].map(Vec3::from);
            prop_assume!(eye.distance(target) > 0.1);
            let camera = Camera::looking_at(eye, target, Viewport::default());
            let (px, depth) = camera.project(point);
            let size = glam::Vec2::new(1280.0, 720.0);
            let margin = px.min_element().min((size - px).min_element());
            // Within half a pixel of an edge, or 10 cm of the eye, rounding decides.
            prop_assume!(margin.abs() > 0.5 && depth.abs() > 0.1);
            prop_assert_eq!(Frustum::of(&camera).contains(point), margin > 0.0 && depth > 0.0);
        }
    }
}
