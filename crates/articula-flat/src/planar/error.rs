//! Errors of clips that are converted, each with its remedy.

use crate::error::PictureError;
use articula_core::Cancelled;
use thiserror::Error;

/// Error of the conversion of a clip to 2D.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum PlanarError {
    /// A vertex position is not finite.
    #[error(
        "frame {frame}: the position of vertex {vertex} is not finite; check the clip and the \
         skin weights"
    )]
    NotFinite {
        /// Frame of the clip.
        frame: usize,
        /// Vertex of the mesh.
        vertex: u32,
    },
    /// A vertex lies behind the camera or too close in front of it.
    #[error(
        "frame {frame}: vertex {vertex} is not in front of the camera, which is inside the \
         character; move the camera away"
    )]
    BehindCamera {
        /// Frame of the clip.
        frame: usize,
        /// Vertex of the mesh.
        vertex: u32,
    },
    /// The mesh has more triangles than can be converted.
    #[error("{found} triangles, the limit is {most}; choose a coarser level or fewer triangles")]
    TooManyTriangles {
        /// Triangles of the mesh.
        found: usize,
        /// Maximum number of triangles.
        most: usize,
    },
    /// The clip has more frames than can be converted.
    #[error(
        "{found} frames, the limit is {most}; choose a shorter part or fewer frames per second"
    )]
    TooManyFrames {
        /// Frames of the clip.
        found: usize,
        /// Maximum number of frames.
        most: usize,
    },
    /// There are more distinct sets of overlapping triangles than the limit.
    #[error(
        "more than {most} pairs of triangles overlap; choose fewer triangles or frames, or a \
         smaller picture"
    )]
    TooManyOverlaps {
        /// Maximum number of distinct sets.
        most: usize,
    },
    /// The clip has no frames.
    #[error("the clip has no frame; choose another clip or a longer part of it")]
    NoFrames,
    /// No triangle is visible in any frame.
    #[error("no triangle is visible in any frame; turn the camera or show other meshes")]
    NothingVisible,
    /// Arguments that do not belong together.
    #[error("{at}: {what}")]
    Mismatch {
        /// Name of the argument.
        at: &'static str,
        /// Description of what was found and what was expected.
        what: String,
    },
    /// The caller cancelled the work ([`articula_core::Progress`]).
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// An intermediate picture could not be made.
    #[error(transparent)]
    Picture(#[from] PictureError),
}
