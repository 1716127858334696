//! Errors of streams, grouped by cause.

use articula_core::{MalformedBytes, Mismatch};
use thiserror::Error;

/// Error of reading a stream. The text names location, cause and expectation.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum StreamError {
    /// The bytes violate their format.
    #[error("{at}: {what}")]
    Malformed {
        /// Byte offset, or chunk.
        at: String,
        /// The fault, and what was expected.
        what: String,
    },
    /// The bytes are valid, but of a form that is not supported.
    #[error("{at}: {what} is not supported; {mend}")]
    Unsupported {
        /// Byte offset.
        at: String,
        /// The unsupported form.
        what: String,
        /// Remedy for the user.
        mend: String,
    },
    /// The stream would need more memory or time than the caller allows.
    #[error("{at}: {found} {which}, the limit is {limit}")]
    LimitExceeded {
        /// Byte offset, or chunk.
        at: String,
        /// The limit, in words.
        which: &'static str,
        /// Amount that the stream needs.
        found: u64,
        /// Amount that the caller allows.
        limit: u64,
    },
    /// Arguments do not fit each other.
    #[error(transparent)]
    Mismatch(#[from] Mismatch),
}

impl StreamError {
    /// Creates a [`StreamError::Malformed`].
    pub(crate) fn malformed(at: impl Into<String>, what: impl Into<String>) -> Self {
        Self::Malformed {
            at: at.into(),
            what: what.into(),
        }
    }
}

impl From<MalformedBytes> for StreamError {
    fn from(bad: MalformedBytes) -> Self {
        Self::malformed(format!("byte {}", bad.at), bad.what)
    }
}
