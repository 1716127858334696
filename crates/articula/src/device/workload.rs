//! The size of a grade, as counted.

use serde::Serialize;

/// Seconds of the clip from one frame to the next: that of the lowest rate that is looked for, so that the
/// content does not depend on the time that it takes.
pub(super) const FRAME_SECS: f64 = 1.0 / 25.0;

/// The size of a grade, as counted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Workload {
    /// Number of figures.
    pub figures: usize,
    /// Joints that are sampled, of all figures.
    pub joints: usize,
    /// Vertices that are skinned.
    pub vertices: usize,
    /// Pixels of the picture.
    pub pixels: usize,
}
