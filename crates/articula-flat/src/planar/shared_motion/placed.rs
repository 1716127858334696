//! A motion by frame, and its inverse.

use crate::planar::keyed_motion::KeyedMotion;
use glam::{DAffine2, DMat2, DVec2};

/// A motion in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Placed {
    to_picture: DAffine2,
    to_shape: DAffine2,
    /// Greatest error on the picture, in x or y, of an error of 1 in both coordinates of a shape.
    growth: f64,
}

impl Placed {
    /// The picture itself.
    pub(crate) const STILL: Self = Self {
        to_picture: DAffine2::IDENTITY,
        to_shape: DAffine2::IDENTITY,
        growth: 1.0,
    };

    /// A motion in each frame of a clip.
    pub(crate) fn of(motion: &KeyedMotion, frames: usize) -> Vec<Self> {
        (0..frames)
            .map(|f| Self::new(motion.at(f as f64)))
            .collect()
    }

    /// A map; its inverse is not finite where it is degenerate.
    pub(super) fn new(to_picture: DAffine2) -> Self {
        let DMat2 { x_axis, y_axis } = to_picture.matrix2;
        Self {
            to_picture,
            to_shape: to_picture.inverse(),
            growth: (x_axis.abs() + y_axis.abs()).max_element(),
        }
    }

    /// Coordinates of a shape for a place on the picture, grid steps.
    pub(crate) fn to_shape(self, place: DVec2) -> DVec2 {
        self.to_shape.transform_point2(place)
    }

    /// Place on the picture of a point of a shape, grid steps.
    pub(crate) fn to_picture(self, point: DVec2) -> DVec2 {
        self.to_picture.transform_point2(point)
    }

    /// Tolerance of each coordinate of a shape for a tolerance on the picture.
    pub(crate) fn tolerance(self, on_picture: f64) -> f64 {
        on_picture / self.growth
    }
}
