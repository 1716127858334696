//! Viewport, camera and pixels per metre.
//!
//! Source: `docs/methods/motion-lod.md` part 0. A length of one metre at view depth `z`,
//! perpendicular to the viewing direction, spans `height / (2 z tan(fov / 2))` pixels.

use crate::Libm;
use glam::{Quat, Vec2, Vec3};

/// Size and field of view of the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viewport {
    /// Width in pixels.
    pub width_px: f32,
    /// Height in pixels.
    pub height_px: f32,
    /// Vertical field of view in radians.
    pub fov_y_radians: f32,
}

impl Default for Viewport {
    /// 1280 x 720 at 45 degrees.
    fn default() -> Self {
        Self {
            width_px: 1280.0,
            height_px: 720.0,
            fov_y_radians: std::f32::consts::FRAC_PI_4,
        }
    }
}

impl Viewport {
    /// Number of pixels that one metre spans at a depth in metres; depths below a millimetre count
    /// as a millimetre, so the result is finite.
    pub fn pixels_per_metre(&self, depth_m: f32) -> f32 {
        self.height_px / (2.0 * depth_m.max(1e-3) * (0.5 * self.fov_y_radians).libm_tan())
    }
}

/// A perspective camera, in the space of its subject.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Position of the eye in metres.
    pub eye: Vec3,
    /// World-from-camera rotation; the camera looks along its own -Z, +Y up.
    pub orientation: Quat,
    /// Picture that it projects onto.
    pub viewport: Viewport,
}

impl Camera {
    /// A camera at `eye` that looks at `target`, upright. Looking straight up or down, or at its
    /// own position, it has a fixed heading.
    pub fn looking_at(eye: Vec3, target: Vec3, viewport: Viewport) -> Self {
        let back = (eye - target).try_normalize().unwrap_or(Vec3::Z);
        let up = if back.cross(Vec3::Y).length_squared() < 1e-8 {
            Vec3::Z
        } else {
            Vec3::Y
        };
        let right = up.cross(back).normalize();
        let basis = glam::Mat3::from_cols(right, back.cross(right), back);
        Self {
            eye,
            orientation: Quat::from_mat3(&basis),
            viewport,
        }
    }

    /// Returns a point in camera space: x right, y up, and depth in z, positive ahead; metres.
    pub fn view(&self, point: Vec3) -> Vec3 {
        let p = self.orientation.conjugate() * (point - self.eye);
        Vec3::new(p.x, p.y, -p.z)
    }

    /// Returns the pixel position (origin at the top left, y down) and depth of a point. Points
    /// nearer than a millimetre, or behind, are projected as if they were a millimetre away.
    pub fn project(&self, point: Vec3) -> (Vec2, f32) {
        let p = self.view(point);
        let scale = self.viewport.pixels_per_metre(p.z);
        let x = 0.5 * self.viewport.width_px + scale * p.x;
        let y = 0.5 * self.viewport.height_px - scale * p.y;
        (Vec2::new(x, y), p.z)
    }

    /// Viewing direction.
    pub fn forward(&self) -> Vec3 {
        self.orientation * Vec3::NEG_Z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_per_metre_by_hand() {
        // At 45 degrees and 720 px a plane 10 m away is 2 * 10 * tan(22.5) = 8.2843 m high.
        let viewport = Viewport::default();
        assert!((viewport.pixels_per_metre(10.0) - 720.0 / 8.284_271).abs() < 1e-3);
    }

    #[test]
    fn projects_to_the_middle_and_agrees_with_pixels_per_metre() {
        let camera = Camera::looking_at(Vec3::new(0.0, 1.0, 5.0), Vec3::Y, Viewport::default());
        let (middle, depth) = camera.project(Vec3::Y);
        assert!((middle - Vec2::new(640.0, 360.0)).length() < 1e-3);
        assert!((depth - 5.0).abs() < 1e-5);
        let (right, _) = camera.project(Vec3::new(1.0, 1.0, 0.0));
        let expected = camera.viewport.pixels_per_metre(5.0);
        assert!(
            (right.x - 640.0 - expected).abs() < 1e-2,
            "+x is to the right"
        );
        let (up, _) = camera.project(Vec3::new(0.0, 2.0, 0.0));
        assert!(up.y < 360.0, "+y is up");
    }

    #[test]
    fn looking_straight_down_is_finite() {
        let camera = Camera::looking_at(Vec3::Y * 3.0, Vec3::ZERO, Viewport::default());
        assert!(camera.project(Vec3::X).0.is_finite());
        assert!((camera.forward() - Vec3::NEG_Y).length() < 1e-5);
    }
}
