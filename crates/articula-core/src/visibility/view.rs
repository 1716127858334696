//! A view: its frustum, the pixels that a metre spans, and what cannot be seen for walls.

use super::density::PixelDensity;
use super::frustum::{Frustum, Tangents};
use crate::view::Camera;
use glam::{Quat, Vec2, Vec3};
use std::ops::Range;

/// Maximum of a cull margin in metres, so that no infinite margin times a turn of 0 gives NaN.
pub(super) const FARTHEST_METRES: f32 = 1e18;

/// One view of the world: a camera, an eye of a headset, a mirror, a shadow map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View<'a> {
    pub(super) frustum: Frustum,
    pub(super) density: PixelDensity,
    pub(super) cull_margin_metres: f32,
    pub(super) cull_margin_radians: f32,
    pub(super) occluded: &'a [f32],
}

impl<'a> View<'a> {
    /// A view with its frustum and its pixels per metre. If these are not positive and finite it
    /// sees nothing.
    pub(super) fn new(frustum: Frustum, density: PixelDensity) -> Self {
        Self {
            frustum: if density.is_valid() {
                frustum
            } else {
                Frustum::NOTHING
            },
            density,
            cull_margin_metres: 0.0,
            cull_margin_radians: 0.0,
            occluded: &[],
        }
    }

    /// The view of a perspective camera.
    pub fn of(camera: &Camera) -> Self {
        let (at_one_metre, tangents) = (
            camera.viewport.pixels_per_metre(1.0),
            Tangents::of(&camera.viewport),
        );
        let density = PixelDensity::perspective(at_one_metre, tangents);
        Self::new(Frustum::of(camera), density)
    }

    /// The view of a picture that need not be centred on the viewing direction, such as that of an
    /// eye of a headset. The orientation is world from camera, looking along -Z; one metre spans
    /// `pixels_at_one_metre` pixels at a depth of one metre. An invalid camera sees nothing.
    pub fn off_axis(
        eye: Vec3,
        orientation: Quat,
        tangents: Tangents,
        pixels_at_one_metre: f32,
    ) -> Self {
        let density = PixelDensity::perspective(pixels_at_one_metre, tangents);
        Self::new(Frustum::perspective(eye, orientation, tangents), density)
    }

    /// The view of a parallel projection, such as that of a shadow map: a beam of the given half
    /// width and half height in metres, in which one metre spans `pixels_per_metre` pixels at any
    /// depth.
    pub fn parallel(eye: Vec3, orientation: Quat, half_size: Vec2, pixels_per_metre: f32) -> Self {
        let density = PixelDensity::Everywhere(pixels_per_metre);
        let beam = Frustum::orthographic(eye, orientation, half_size.x, half_size.y);
        Self::new(beam, density)
    }

    /// Limits the view to a range of depths in metres. By default a view begins at its eye and has
    /// no far end: a body before a renderer's near plane must still move, since its shadow or its
    /// hand may reach into view. A depth below zero lets a parallel projection see behind its eye.
    #[must_use]
    pub fn with_depth_range(self, depths_metres: Range<f32>) -> Self {
        let Range { start, end } = depths_metres;
        Self {
            frustum: self.frustum.with_near(start).with_far(end),
            ..self
        }
    }

    /// Sets the cull margin: the distance and the angle by which the camera may move and turn until
    /// the next test. Bodies that this could bring into view are [`Visibility::Margin`](super::Visibility::Margin).
    #[must_use]
    pub fn with_cull_margin(self, cull_margin_metres: f32, cull_margin_radians: f32) -> Self {
        Self {
            cull_margin_metres: at_most(cull_margin_metres, FARTHEST_METRES),
            // No turn takes a point farther than to the other side of the eye.
            cull_margin_radians: at_most(cull_margin_radians, 2.0),
            ..self
        }
    }

    /// Sets the occluded fraction of each body in this view, 0 to 1, in the order of the bodies.
    /// From 1 on a body in the view is [`Visibility::Margin`](super::Visibility::Margin) instead of visible. Missing entries
    /// and NaN count as 0.
    #[must_use]
    pub fn with_occluded(self, occluded: &'a [f32]) -> Self {
        Self { occluded, ..self }
    }
}

/// Clamps to 0 and `most`; NaN gives 0.
pub(super) fn at_most(value: f32, most: f32) -> f32 {
    if value > 0.0 { value.min(most) } else { 0.0 }
}
