//! Errors of pictures, one variant per cause.

use thiserror::Error;

/// Error of making, reading or writing a picture.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum PictureError {
    /// The bytes violate their format.
    #[error("{at}: {what}")]
    Malformed {
        /// Part of the picture file.
        at: &'static str,
        /// Description of what was found and what was expected.
        what: String,
    },
    /// The format of the bytes is not supported.
    #[error("{what} is not supported; {mend}")]
    Unsupported {
        /// Name of the format or feature.
        what: String,
        /// What the user can do about it.
        mend: String,
    },
    /// The picture would need more memory than the limit.
    #[error("a picture of {width} x {height} with {samples} samples per pixel exceeds {limit}")]
    LimitExceeded {
        /// Requested width in pixels.
        width: u32,
        /// Requested height in pixels.
        height: u32,
        /// Samples per pixel.
        samples: u32,
        /// Description of the limit.
        limit: &'static str,
    },
    /// Arguments that do not belong together.
    #[error("{at}: {what}")]
    Mismatch {
        /// Name of the argument.
        at: &'static str,
        /// Description of what was found and what was expected.
        what: String,
    },
}
