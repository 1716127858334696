//! How much a stream may ask for, so that a hostile one cannot exhaust memory or time.

#[cfg(feature = "codecs")]
use crate::error::StreamError;

/// Upper bounds that every decoder keeps. The defaults pass any character made by people.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamLimits {
    /// Bytes of one stream.
    pub bytes: u64,
    /// Elements that all decoded arrays of one level may hold together.
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

#[cfg(feature = "codecs")]
impl StreamLimits {
    /// Refuses `found` above `limit`.
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
