//! What can be wrong with a clip that is to be converted, each with its mend.

use crate::error::PictureError;
use articula_core::Cancelled;
use thiserror::Error;

/// Why a clip cannot be converted to 2D.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum PlanarError {
    /// A vertex has no finite place.
    #[error(
        "frame {frame}: vertex {vertex} is not at a finite place; mend the clip or the skin weights"
    )]
    NotFinite {
        /// Frame of the clip.
        frame: usize,
        /// Vertex of the mesh.
        vertex: u32,
    },
    /// A vertex lies behind the camera or just before it.
    #[error(
        "frame {frame}: vertex {vertex} is not before the camera, which stands inside the character; move the camera away"
    )]
    BehindCamera {
        /// Frame of the clip.
        frame: usize,
        /// Vertex of the mesh.
        vertex: u32,
    },
    /// More triangles than can be converted.
    #[error("{found} triangles are more than {most}; choose a level or fewer triangles")]
    TooManyTriangles {
        /// Triangles of the mesh.
        found: usize,
        /// The most that are converted.
        most: usize,
    },
    /// More frames than can be converted.
    #[error("{found} frames are more than {most}; choose a shorter part or fewer frames a second")]
    TooManyFrames {
        /// Frames of the clip.
        found: usize,
        /// The most that are converted.
        most: usize,
    },
    /// Triangles lie over each other in more ways than are counted.
    #[error(
        "triangles lie over each other in more than {most} ways; choose fewer triangles or frames, or a smaller picture"
    )]
    TooManyOverlaps {
        /// The most that are counted.
        most: usize,
    },
    /// There is no frame.
    #[error("the clip has no frame; choose another clip or a longer part of it")]
    NoFrames,
    /// No triangle is seen in any frame.
    #[error("no triangle is seen in any frame; turn the camera or show other meshes")]
    NothingSeen,
    /// No setting makes a file that small.
    #[error(
        "the smallest file has {least} bytes, the budget is {budget}; ask for fewer triangles, fewer frames a second, or the player profile"
    )]
    BudgetTooSmall {
        /// Size of the smallest file that was made.
        least: u64,
        /// The budget.
        budget: u64,
    },
    /// The caller paired things that do not fit.
    #[error("{at}: {what}")]
    Mismatch {
        /// Which argument.
        at: &'static str,
        /// What was found and what was expected.
        what: String,
    },
    /// The caller ended the work ([`articula_core::Progress`]).
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A picture on the way could not be made.
    #[error(transparent)]
    Picture(#[from] PictureError),
}
