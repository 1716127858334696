//! Errors of building or drawing a portrait, one variant per cause.

use crate::error::PictureError;
use crate::planar::PlanarError;
use articula_core::{Cancelled, Mismatch};
use thiserror::Error;

/// Error of building or drawing a portrait.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum PortraitError {
    /// Arguments do not belong together, or an option is out of range.
    #[error("{0}")]
    Mismatch(#[from] Mismatch),
    /// A picture could not be made.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// The caller cancelled the work ([`articula_core::Progress`]).
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The painting order could not be computed.
    #[error(transparent)]
    Planar(#[from] PlanarError),
    /// A vertex lies beside or behind the camera, or its position is not finite.
    #[error("vertex {vertex} is outside the view of the camera at yaw {yaw} degrees; {mend}")]
    NotInView {
        /// Vertex of the mesh.
        vertex: usize,
        /// Yaw of the head, rounded to degrees.
        yaw: i32,
        /// What the user can do about it.
        mend: &'static str,
    },
    /// The portrait exceeds a limit of the 2D player.
    #[error("{count} {what}, the limit is {limit}; choose a coarser level of the mesh")]
    LimitExceeded {
        /// Kind of element.
        what: &'static str,
        /// Number of elements.
        count: usize,
        /// Maximum number of elements.
        limit: usize,
    },
}

/// Returns a [`PortraitError::Mismatch`].
pub(crate) fn refuse(at: impl Into<String>, what: impl Into<String>) -> PortraitError {
    PortraitError::Mismatch(Mismatch::new(at, what))
}
