//! Limits on decoding, so that a hostile stream cannot exhaust memory or time.

use crate::error::StreamError;

/// Upper bounds that every decoder observes. The defaults admit any realistic character.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamLimits {
    /// Maximum size of a stream in bytes.
    pub bytes: u64,
    /// Maximum number of elements in all decoded arrays of one level together.
    pub elements: u64,
}

impl Default for StreamLimits {
    fn default() -> Self {
        Self {
            bytes: 1 << 30,
            elements: 1 << 28,
        }
    }
}

/// Upper bounds of a reader of descriptions. Besides, no element lies deeper than 64, has more than
/// 64 attributes or is within more than 64 namespace declarations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DescriptionLimits {
    /// Maximum size of a document in bytes.
    pub bytes: u64,
    /// Maximum number of elements of a document; it may have eight times as many attributes.
    pub nodes: u64,
}

impl Default for DescriptionLimits {
    fn default() -> Self {
        Self {
            bytes: 64 << 20,
            nodes: 1_000_000,
        }
    }
}

impl StreamLimits {
    /// Returns an error if `found` exceeds `limit`.
    pub(crate) fn check(
        at: &str,
        which: &'static str,
        found: u64,
        limit: u64,
    ) -> Result<(), StreamError> {
        if found <= limit {
            return Ok(());
        }
        Err(StreamError::LimitExceeded {
            at: at.to_owned(),
            which,
            found,
            limit,
        })
    }
}
