//! Errors of the player's container.

use thiserror::Error;

/// Error of decoding a container.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum PlayerError {
    /// The first bytes are not those of a container.
    #[error("not a clip of the player: it does not begin with ARTV")]
    NotAClip,
    /// The version is not supported.
    #[error("version {0} of the player's clip is not known here; write it anew")]
    Version(u8),
    /// The Deflate stream is malformed.
    #[error("the compressed part of the clip is damaged")]
    Compression,
    /// The container ends too early.
    #[error("the clip ends too early")]
    Truncated,
    /// The uncompressed size exceeds the limit in bytes.
    #[error("the clip uncompresses to more than {0} bytes")]
    TooLarge(usize),
    /// A number of elements exceeds its limit.
    #[error("{found} {what} are more than {most}")]
    TooMany {
        /// Kind of element.
        what: &'static str,
        /// Number in the file.
        found: usize,
        /// Maximum number.
        most: usize,
    },
    /// A value is invalid.
    #[error("the clip is malformed: {0}")]
    Malformed(&'static str),
}
