//! Camera placement: the closest camera from which a character fills the picture.

use articula_core::{Camera, Viewport};
use glam::Vec3;

/// Free margin around the character, as a fraction of its size.
const MARGIN: f32 = 0.06;

/// An axis-aligned box, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Minimum corner.
    pub low: Vec3,
    /// Maximum corner.
    pub high: Vec3,
}

impl Bounds {
    /// Returns the smallest box around other boxes, such as the skinned bounds of a clip's frames;
    /// `None` if there are none. Boxes that are not finite are ignored.
    pub fn around(boxes: impl IntoIterator<Item = (Vec3, Vec3)>) -> Option<Self> {
        boxes
            .into_iter()
            .filter(|(low, high)| low.is_finite() && high.is_finite())
            .map(|(low, high)| Self { low, high })
            .reduce(|a, b| Self {
                low: a.low.min(b.low),
                high: a.high.max(b.high),
            })
    }

    /// Returns the centre.
    pub fn middle(&self) -> Vec3 {
        0.5 * (self.low + self.high)
    }

    /// Returns the eight corners.
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|i| {
            let pick = |bit: usize, low: f32, high: f32| if i >> bit & 1 == 0 { low } else { high };
            Vec3::new(
                pick(0, self.low.x, self.high.x),
                pick(1, self.low.y, self.high.y),
                pick(2, self.low.z, self.high.z),
            )
        })
    }
}

/// Returns a camera that looks at the centre of the bounds, from the closest distance at which it
/// sees all of them.
///
/// `azimuth_radians` turns the camera around the character (a quarter turn shows its left side),
/// `elevation_radians` raises it.
pub fn orbit_view(
    bounds: &Bounds,
    azimuth_radians: f32,
    elevation_radians: f32,
    viewport: Viewport,
) -> Camera {
    let (turn_sin, turn_cos) = azimuth_radians.sin_cos();
    let (lift_sin, lift_cos) = elevation_radians.sin_cos();
    let toward = Vec3::new(lift_cos * turn_sin, lift_sin, lift_cos * turn_cos);
    let middle = bounds.middle();
    let aimed = Camera::looking_at(middle + toward, middle, viewport);
    // Half the view's height and width at depth one.
    let tall = (0.5 * viewport.fov_y_radians).tan();
    let wide = tall * viewport.width_px / viewport.height_px;
    let distance = |corner: Vec3| {
        let p = aimed.orientation.conjugate() * (corner - middle);
        let needed = (p.x.abs() / wide).max(p.y.abs() / tall);
        p.z + needed * (1.0 + 2.0 * MARGIN)
    };
    let distance = bounds.corners().into_iter().map(distance);
    let distance = distance.fold(0.1, f32::max);
    Camera {
        eye: middle + toward * distance,
        ..aimed
    }
}

/// Returns the closest camera of a direction that sees all points, with a margin around them;
/// `None` if no point is finite. Angles as in [`orbit_view`].
pub fn tight_view(
    points: impl IntoIterator<Item = Vec3>,
    azimuth_radians: f32,
    elevation_radians: f32,
    viewport: Viewport,
) -> Option<Camera> {
    let mut view = TightView::new(azimuth_radians, elevation_radians, viewport);
    points.into_iter().for_each(|p| view.add(p));
    view.camera()
}

/// Accumulates points and finds the closest camera of a direction that sees all of them, with the
/// margin around them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TightView {
    aimed: Camera,
    /// Half the view's width and height at depth one, less the margin.
    half: [f32; 2],
    /// Maximum extent of the points to the right, left, top and bottom, along each side of the
    /// view.
    reach: [f32; 4],
    /// Depth of the nearest point, relative to the origin.
    nearest: f32,
}

impl TightView {
    /// Starts without points. Angles as in [`orbit_view`].
    pub(crate) fn new(azimuth_radians: f32, elevation_radians: f32, viewport: Viewport) -> Self {
        let (turn_sin, turn_cos) = azimuth_radians.sin_cos();
        let (lift_sin, lift_cos) = elevation_radians.sin_cos();
        let toward = Vec3::new(lift_cos * turn_sin, lift_sin, lift_cos * turn_cos);
        let tall = (0.5 * viewport.fov_y_radians).tan() / (1.0 + 2.0 * MARGIN);
        Self {
            aimed: Camera::looking_at(toward, Vec3::ZERO, viewport),
            half: [tall * viewport.width_px / viewport.height_px, tall],
            reach: [f32::NEG_INFINITY; 4],
            nearest: f32::INFINITY,
        }
    }

    /// Adds a point that must be in view; points that are not finite are ignored.
    pub(crate) fn add(&mut self, point: Vec3) {
        if !point.is_finite() {
            return;
        }
        let p = self.aimed.orientation.conjugate() * point;
        let [wide, tall] = self.half;
        // A point at depth d is inside if |offset| <= half * d; its depth is minus z.
        let reaches = [
            p.x + wide * p.z,
            -p.x + wide * p.z,
            p.y + tall * p.z,
            -p.y + tall * p.z,
        ];
        for (most, reach) in self.reach.iter_mut().zip(reaches) {
            *most = most.max(reach);
        }
        self.nearest = self.nearest.min(-p.z);
    }

    /// Returns the camera; `None` without points.
    pub(crate) fn camera(&self) -> Option<Camera> {
        if !self.nearest.is_finite() {
            return None;
        }
        let [right, left, up, down] = self.reach;
        let [wide, tall] = self.half;
        let across = Vec3::new(0.5 * (right - left), 0.5 * (up - down), 0.0);
        let back = (0.5 * (right + left) / wide).max(0.5 * (up + down) / tall);
        // Stays in front of the points, however thin they are.
        let back = back.max(0.1 - self.nearest);
        let place = across + Vec3::Z * back;
        Some(Camera {
            eye: self.aimed.orientation * place,
            ..self.aimed
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERSON: Bounds = Bounds {
        low: Vec3::new(-0.4, 0.0, -0.2),
        high: Vec3::new(0.4, 1.8, 0.3),
    };

    #[test]
    fn front_view_by_hand() {
        // 1.8 m on a plane at z = 0.3 fill 1 / 1.12 of the height at depth
        // 0.9 * 1.12 / tan(22.5 degrees) = 2.43354.
        let camera = orbit_view(&PERSON, 0.0, 0.0, Viewport::default());
        assert!((camera.eye - Vec3::new(0.0, 0.9, 0.3 + 2.433_54)).length() < 1e-4);
        assert!((camera.forward() - Vec3::NEG_Z).length() < 1e-6);
    }

    #[test]
    fn every_corner_is_inside_from_every_side_and_one_is_near_the_edge() {
        for step in 0..24 {
            let azimuth = step as f32 * 0.3;
            let elevation = (step % 5) as f32 * 0.2 - 0.3;
            let camera = orbit_view(&PERSON, azimuth, elevation, Viewport::default());
            let mut most = 0.0f32;
            for corner in PERSON.corners() {
                let (at, depth) = camera.project(corner);
                assert!(depth > 0.0);
                let x = (at.x / 640.0 - 1.0).abs();
                let y = (at.y / 360.0 - 1.0).abs();
                most = most.max(x).max(y);
            }
            assert!(most <= 1.0 && most > 0.8, "{most} at {azimuth}");
        }
    }

    #[test]
    fn a_tight_view_touches_two_opposite_margins() {
        let viewport = Viewport {
            width_px: 400.0,
            height_px: 400.0,
            ..Viewport::default()
        };
        for azimuth in [0.0, 0.7, 3.0] {
            let mut view = TightView::new(azimuth, 0.2, viewport);
            assert!(view.camera().is_none());
            let points = PERSON.corners();
            points.into_iter().for_each(|p| view.add(p));
            view.add(Vec3::NAN);
            let camera = view.camera().unwrap();
            let places = points.map(|p| camera.project(p).0 / 400.0);
            let low = places.into_iter().reduce(glam::Vec2::min).unwrap();
            let high = places.into_iter().reduce(glam::Vec2::max).unwrap();
            // The margin is a fraction of the visible size: 0.06 / 1.12 of the picture.
            let margin = 0.06 / 1.12;
            assert!((low.min_element() - margin).abs() < 1e-3, "{low}");
            assert!((high.max_element() - (1.0 - margin)).abs() < 1e-3, "{high}");
            assert!((low.y - margin).abs() < 1e-3 && (high.y + margin - 1.0).abs() < 1e-3);
        }
    }

    #[test]
    fn bounds_join_and_leave_out_what_is_no_number() {
        let boxes = [
            (Vec3::ZERO, Vec3::ONE),
            (Vec3::NAN, Vec3::ONE),
            (Vec3::NEG_ONE, Vec3::ZERO),
        ];
        let all = Bounds::around(boxes).unwrap();
        assert_eq!((all.low, all.high), (Vec3::NEG_ONE, Vec3::ONE));
        assert_eq!(Bounds::around([]), None);
    }
}
