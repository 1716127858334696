//! What can be wrong with the player's container.

use thiserror::Error;

/// Why bytes are no clip of the player.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum PlayerError {
    /// It does not begin as a container does.
    #[error("not a clip of the player: it does not begin with ARTV")]
    NotAClip,
    /// Written in a form that is not known here.
    #[error("version {0} of the player's clip is not known here; write it anew")]
    Version(u8),
    /// The Deflate stream does not hold.
    #[error("the compressed part of the clip is damaged")]
    Compression,
    /// It ends too early.
    #[error("the clip ends too early")]
    Truncated,
    /// It uncompresses to more than is read.
    #[error("the clip uncompresses to more than {0} bytes")]
    TooLarge(usize),
    /// More of something than is read.
    #[error("{found} {what} are more than {most}")]
    TooMany {
        /// What it is.
        what: &'static str,
        /// How many it says.
        found: usize,
        /// The most that are read.
        most: usize,
    },
    /// Something in it cannot be.
    #[error("the clip is malformed: {0}")]
    Malformed(&'static str),
}
