//! Projection from metres to pixels: perspective, or parallel at a fixed scale.
//!
//! Source: `docs/methods/motion-lod.md` part 0. A parallel view at `pixels_per_metre` is the weak
//! perspective of the error tables: all depths have the same scale.

use articula_core::Camera;
use glam::{Vec2, Vec3, Vec4};

/// Kind of projection: perspective or parallel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Projection {
    /// Perspective with the field of view of the camera's viewport.
    #[default]
    Perspective,
    /// Every metre spans the same number of pixels at any depth, also behind the camera.
    Parallel {
        /// Pixels per metre.
        pixels_per_metre: f32,
    },
}

/// A camera with its projection; maps points to the screen and back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Screen {
    camera: Camera,
    projection: Projection,
    middle: Vec2,
    /// Pixels that a metre spans at depth 1 (perspective) or anywhere (parallel).
    scale: f32,
    /// The camera's axes, so that a ray needs no quaternion product.
    right: Vec3,
    up: Vec3,
    forward: Vec3,
}

/// A ray from the camera, parameterised by depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ray {
    /// Point at depth 0.
    pub origin: Vec3,
    /// Change of position for one metre of depth (longer than one metre off the axis).
    pub direction: Vec3,
}

impl Screen {
    /// Combines a camera and a projection.
    pub fn new(camera: &Camera, projection: Projection) -> Self {
        let middle = 0.5 * Vec2::new(camera.viewport.width_px, camera.viewport.height_px);
        let scale = match projection {
            Projection::Perspective => camera.viewport.pixels_per_metre(1.0),
            Projection::Parallel { pixels_per_metre } => pixels_per_metre,
        };
        Self {
            camera: *camera,
            projection,
            middle,
            scale,
            right: camera.orientation * Vec3::X,
            up: camera.orientation * Vec3::Y,
            forward: camera.forward(),
        }
    }

    /// Homogeneous corner of a point, as [`crate::item_buffer::ItemBuffer`] takes it.
    pub(crate) fn corner(&self, point: Vec3) -> Vec4 {
        let p = self.camera.view(point);
        let scale = self.scale;
        let (nearness, w) = match self.projection {
            Projection::Perspective => (1.0, p.z),
            Projection::Parallel { .. } => (-p.z, 1.0),
        };
        let x = self.middle.x * w + scale * p.x;
        let y = self.middle.y * w - scale * p.y;
        Vec4::new(x, y, nearness, w)
    }

    /// Returns the screen position in pixels; `None` for a point behind a perspective camera.
    pub fn place(&self, point: Vec3) -> Option<Vec2> {
        let corner = self.corner(point);
        (corner.w > 1e-3).then(|| Vec2::new(corner.x, corner.y) / corner.w)
    }

    /// Returns the pixels that one metre spans at the depth of a point.
    pub fn pixels_per_metre_at(&self, point: Vec3) -> f32 {
        match self.projection {
            Projection::Perspective => self.scale / self.camera.view(point).z.max(1e-3),
            Projection::Parallel { .. } => self.scale,
        }
    }

    /// Direction from a point towards the eye, of any length.
    pub(crate) fn eye_of(&self, point: Vec3) -> Vec3 {
        match self.projection {
            Projection::Perspective => self.camera.eye - point,
            Projection::Parallel { .. } => -self.forward,
        }
    }

    /// Ray of all points that appear at a screen position.
    pub(crate) fn ray(&self, at: Vec2) -> Ray {
        let offset = (at - self.middle) / self.scale;
        let across = self.right * offset.x - self.up * offset.y;
        match self.projection {
            Projection::Perspective => Ray {
                origin: self.camera.eye,
                direction: self.forward + across,
            },
            Projection::Parallel { .. } => Ray {
                origin: self.camera.eye + across,
                direction: self.forward,
            },
        }
    }

    /// Nearness of a point at a depth, as the item buffer stores it.
    pub(crate) fn nearness_of(&self, depth_m: f32) -> f32 {
        match self.projection {
            Projection::Perspective => 1.0 / depth_m,
            Projection::Parallel { .. } => -depth_m,
        }
    }

    /// Returns the camera.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::Viewport;

    fn camera() -> Camera {
        Camera::looking_at(
            Vec3::new(2.0, 1.5, 4.0),
            Vec3::new(0.0, 1.0, 0.0),
            Viewport::default(),
        )
    }

    #[test]
    fn perspective_agrees_with_the_camera() {
        let screen = Screen::new(&camera(), Projection::Perspective);
        for point in [Vec3::ZERO, Vec3::new(0.3, 1.8, -0.4), Vec3::X] {
            let (expected, depth) = camera().project(point);
            assert!((screen.place(point).unwrap() - expected).length() < 1e-3);
            let corner = screen.corner(point);
            assert!((corner.z / corner.w - screen.nearness_of(depth)).abs() < 1e-6);
        }
        assert_eq!(screen.place(Vec3::new(4.0, 2.0, 8.0)), None);
    }

    #[test]
    fn parallel_scale_does_not_depend_on_depth() {
        let pixels_per_metre = 100.0;
        let screen = Screen::new(&camera(), Projection::Parallel { pixels_per_metre });
        let target = Vec3::new(0.0, 1.0, 0.0);
        let right = camera().orientation * Vec3::X;
        let far = camera().forward() * 7.0;
        let place = screen.place(target + right + far).unwrap();
        assert!((place - Vec2::new(740.0, 360.0)).length() < 1e-3);
    }

    #[test]
    fn rays_lead_back_to_their_points() {
        let parallel = Projection::Parallel {
            pixels_per_metre: 80.0,
        };
        for projection in [Projection::Perspective, parallel] {
            let screen = Screen::new(&camera(), projection);
            let point = Vec3::new(-0.5, 0.7, 0.2);
            let ray = screen.ray(screen.place(point).unwrap());
            let again = ray.origin + ray.direction * camera().view(point).z;
            assert!((again - point).length() < 1e-5);
        }
    }
}
