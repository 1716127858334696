//! Why a portrait could not be made or drawn, sorted by blame.

use crate::error::PictureError;
use crate::planar::PlanarError;
use articula_core::{Cancelled, Mismatch};
use thiserror::Error;

/// Why a portrait could not be made or drawn.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum PortraitError {
    /// The caller paired things that do not fit, or gave an option out of its range.
    #[error("{0}")]
    Mismatch(#[from] Mismatch),
    /// A picture could not be made.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// The caller ended the work ([`articula_core::Progress`]).
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// No painting order could be found.
    #[error(transparent)]
    Planar(#[from] PlanarError),
    /// A vertex lies beside or behind the camera, or where it is no number.
    #[error("vertex {vertex} cannot be seen from the camera at yaw {yaw} degrees: {mend}")]
    NotInView {
        /// Vertex of the mesh.
        vertex: usize,
        /// The turn of the head, rounded.
        yaw: i32,
        /// What the user can do.
        mend: &'static str,
    },
    /// More than a 2D player can show.
    #[error("{count} {what}, at most {limit}: choose a coarser level of the mesh")]
    LimitExceeded {
        /// What there is too much of.
        what: &'static str,
        /// How many there are.
        count: usize,
        /// How many there may be.
        limit: usize,
    },
}

/// A [`PortraitError::Mismatch`] in one call.
pub(crate) fn refuse(at: impl Into<String>, what: impl Into<String>) -> PortraitError {
    PortraitError::Mismatch(Mismatch::new(at, what))
}
