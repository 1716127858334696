//! Errors of baking impostors, one variant per cause.

use crate::error::PictureError;
use articula_core::{Cancelled, Mismatch};
use thiserror::Error;

/// Error of baking impostors.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ImpostorError {
    /// Arguments do not belong together, or an option is out of range.
    #[error("{0}")]
    Mismatch(#[from] Mismatch),
    /// A picture could not be made.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// The caller cancelled the work ([`articula_core::Progress`]).
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// There is nothing to show: no vertex with a finite position, or no extent.
    #[error("there is no mesh to show; give a file with a mesh or hide fewer meshes")]
    Nothing,
    /// Not even the coarsest pictures are within the bound.
    #[error(
        "the coarsest pictures need {needed} bytes, the limit is {limit}; raise it or bake fewer \
         clips"
    )]
    LimitExceeded {
        /// Bytes of the coarsest pictures.
        needed: usize,
        /// The limit.
        limit: usize,
    },
}

/// Returns an [`ImpostorError::Mismatch`].
pub(super) fn refuse(at: impl Into<String>, what: impl Into<String>) -> ImpostorError {
    ImpostorError::Mismatch(Mismatch::new(at, what))
}
