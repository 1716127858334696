//! What can be wrong with a stream, sorted by blame.

use articula_core::{MalformedBytes, Mismatch};
use thiserror::Error;

/// Why a stream could not be read. The text names what was found, what was expected and where.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum StreamError {
    /// The bytes break the rules of their form.
    #[error("{at}: {what}")]
    Malformed {
        /// Byte offset, or chunk.
        at: String,
        /// What was found and what was expected.
        what: String,
    },
    /// The bytes are good but of a form that we do not read.
    #[error("{at}: {what} is not supported; {mend}")]
    Unsupported {
        /// Byte offset.
        at: String,
        /// The form.
        what: String,
        /// What the user can do.
        mend: String,
    },
    /// The stream would take more memory or time than the caller allows.
    #[error("{at}: {found} {which}, the limit is {limit}")]
    LimitExceeded {
        /// Byte offset, or chunk.
        at: String,
        /// Which limit, as words.
        which: &'static str,
        /// What the stream asks for.
        found: u64,
        /// What the caller allows.
        limit: u64,
    },
    /// The caller paired what does not belong together.
    #[error(transparent)]
    Mismatch(#[from] Mismatch),
}

impl StreamError {
    /// A [`StreamError::Malformed`].
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
