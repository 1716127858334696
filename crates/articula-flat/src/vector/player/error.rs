//! Errors of the player's container.

use thiserror::Error;

/// Error of decoding a container.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum PlayerError {
    /// The first bytes are not those of a container.
    #[error("not a player clip: it does not begin with ARTV")]
    NotAClip,
    /// The version is not supported.
    #[error(
        "version {0} of the player clip is not supported; write the clip again with this version \
         of Articula"
    )]
    Version(u8),
    /// The Deflate stream is malformed.
    #[error("the compressed part of the clip is damaged")]
    Compression,
    /// The container ends too early.
    #[error("unexpected end of the clip")]
    Truncated,
    /// The uncompressed size exceeds the limit in bytes.
    #[error("the clip decompresses to more than {0} bytes")]
    TooLarge(usize),
    /// A number of elements exceeds its limit.
    #[error("{found} {what}, the limit is {most}")]
    TooMany {
        /// Kind of element.
        what: &'static str,
        /// Number in the file.
        found: usize,
        /// Maximum number.
        most: usize,
    },
    /// The picture of the clip cannot be decoded.
    #[error("the picture of the clip cannot be read: {0}")]
    Picture(String),
    /// A value is invalid.
    #[error("the clip is malformed: {0}")]
    Malformed(&'static str),
}
