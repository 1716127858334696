//! What can be wrong with a picture, sorted by blame.

use thiserror::Error;

/// Why a picture could not be made, read or written.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum PictureError {
    /// The bytes break the rules of their format.
    #[error("{at}: {what}")]
    Malformed {
        /// Which part of the picture file.
        at: &'static str,
        /// What was found and what was expected.
        what: String,
    },
    /// The bytes are of a format that is not read here.
    #[error("{what} is not supported; {mend}")]
    Unsupported {
        /// The format or feature.
        what: String,
        /// What the user can do.
        mend: String,
    },
    /// The picture would take more memory than is allowed.
    #[error("a picture of {width} x {height} with {samples} samples a pixel exceeds {limit}")]
    LimitExceeded {
        /// Width that was asked for, pixels.
        width: u32,
        /// Height that was asked for, pixels.
        height: u32,
        /// Samples a pixel.
        samples: u32,
        /// The limit, as words.
        limit: &'static str,
    },
    /// The caller paired things that do not fit.
    #[error("{at}: {what}")]
    Mismatch {
        /// Which argument.
        at: &'static str,
        /// What was found and what was expected.
        what: String,
    },
}
