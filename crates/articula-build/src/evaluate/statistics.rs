//! Statistics of the error of a skin.

use articula_core::percentile;
use glam::Vec3;

/// Projected displacement of the skin: percentiles over frames of the 95th percentile over
/// vertices, at the worst azimuth. In metres, or for a given distance in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FrameErrors {
    /// Median over frames.
    pub p50: f32,
    /// 95th percentile over frames.
    pub p95: f32,
    /// Maximum over frames.
    pub max: f32,
}

/// Errors of one part of the body, in metres or for a given distance in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PartErrors {
    /// Percentiles over frames of the 95th percentile over the vertices of the part.
    pub frames: FrameErrors,
    /// Maximum over all vertices of the part and all frames.
    pub worst_vertex: f32,
}

/// Errors over all vertices and all frames, at the worst azimuth; in metres or for a given distance
/// in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SkinErrors {
    /// Maximum over all vertices and frames.
    pub worst_vertex: f32,
    /// The hands, below the wrists; `None` if they have no skin.
    pub hands: Option<PartErrors>,
    /// The head, with the face; of a character without a head joint the vertices that
    /// [`with_face`](super::ClipEvaluator::with_face) gives.
    pub face: Option<PartErrors>,
    /// The feet, below the ankles.
    pub feet: Option<PartErrors>,
}

impl PartErrors {
    fn scaled(self, factor: f32) -> Self {
        Self {
            frames: self.frames.scaled(factor),
            worst_vertex: self.worst_vertex * factor,
        }
    }
}

impl SkinErrors {
    /// Returns all errors times a factor, such as pixels per metre.
    #[must_use]
    pub fn scaled(self, factor: f32) -> Self {
        let part = |part: Option<PartErrors>| part.map(|part| part.scaled(factor));
        Self {
            worst_vertex: self.worst_vertex * factor,
            hands: part(self.hands),
            face: part(self.face),
            feet: part(self.feet),
        }
    }
}

impl FrameErrors {
    /// Returns all errors times a factor, such as pixels per metre.
    #[must_use]
    pub fn scaled(self, factor: f32) -> Self {
        Self {
            p50: self.p50 * factor,
            p95: self.p95 * factor,
            max: self.max * factor,
        }
    }

    /// Includes the errors of the frames of one more view.
    pub(super) fn add(&mut self, frames: &mut [f32]) {
        self.max = self.max.max(percentile(frames, 1.0));
        self.p95 = self.p95.max(percentile(frames, 0.95));
        self.p50 = self.p50.max(percentile(frames, 0.5));
    }
}

/// Length of an offset as a viewer in a direction sees it.
pub(super) fn across(offset: Vec3, view: Vec3) -> f32 {
    (offset - view * offset.dot(view)).length()
}
