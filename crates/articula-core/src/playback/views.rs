//! The views of a frame, from which pixels per metre and directions follow.

use crate::view::Camera;
use glam::Vec3;

/// The views that show a figure in a frame. All are in the figure's model space.
#[derive(Debug, Clone, Copy)]
pub enum FigureViews<'a> {
    /// Perspective cameras. Without any, no error is seen.
    Cameras(&'a [Camera]),
    /// Views with one scale for the whole figure: parallel projection, or weak perspective.
    Parallel {
        /// Pixels per metre.
        pixels_per_metre: f32,
        /// Distance of the nearest view to the root in metres.
        distance_metres: f32,
        /// Unit directions from the figure to each view.
        directions: &'a [Vec3],
    },
}
