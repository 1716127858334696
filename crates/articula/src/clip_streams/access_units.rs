//! How much of a stream is there.

use crate::error::Result;
use articula_formats::Warning;
use articula_stream::abp2::{MotionHead, prefix_map};
use articula_stream::{StreamKind, StreamLimits, Unit};
use serde::Serialize;

/// How many of its access units a stream has. One that was cut by levels or tiers has all of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct AccessUnitCount {
    /// Number of access units that are there as a whole.
    pub whole: usize,
    /// Number of access units that the stream has in all.
    pub of: usize,
}

impl AccessUnitCount {
    /// Counts the access units of a stream that may end early; `None` if its form does not tell their
    /// number: only ABP-2 and AFP-2 do.
    ///
    /// # Errors
    /// An [`Error`](crate::Error) that names the position in the stream: what is there is malformed or
    /// damaged, or ends within the head.
    pub fn in_stream(stream: &[u8], limits: &StreamLimits) -> Result<Option<Self>> {
        let is_known = matches!(
            StreamKind::of(stream),
            Some(StreamKind::Abp2 | StreamKind::Afp2)
        );
        if !is_known {
            return Ok(None);
        }
        let head = MotionHead::open(stream, limits)?;
        let map = prefix_map(stream, limits)?;
        Ok(Some(Self::new(&head, &map)))
    }

    /// Counts the access units of the map of a stream with this head.
    pub(crate) fn new(head: &MotionHead, map: &Unit) -> Self {
        Self {
            // The first part of a map is the head.
            whole: map.children.len().saturating_sub(1),
            of: head.access_units,
        }
    }

    /// Returns whether access units are missing.
    pub fn is_partial(&self) -> bool {
        self.whole < self.of
    }

    /// Returns a warning if access units are missing.
    pub(crate) fn warning(&self) -> Option<Warning> {
        self.is_partial().then(|| Warning {
            at: "stream".to_owned(),
            what: self.to_string(),
            guess: None,
        })
    }
}

/// `3 access units`, or `partial: 2 of 3 access units`.
impl std::fmt::Display for AccessUnitCount {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let plural = if self.of == 1 { "" } else { "s" };
        if self.is_partial() {
            write!(f, "partial: {} of ", self.whole)?;
        }
        write!(f, "{} access unit{plural}", self.of)
    }
}
