//! Bounds on what a file may request, so that a hostile one cannot exhaust memory or time.

use crate::error::ReadError;
use std::fmt::Display;

/// Upper bounds that every reader enforces. The defaults admit any character made by people.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Maximum size in bytes of one file, buffer or picture.
    pub bytes: u64,
    /// Maximum number of elements in all decoded arrays of one file together (vertices, indices,
    /// key values). Sparse or zero-filled accessors request memory without supplying bytes.
    pub elements: u64,
    /// Maximum number of nodes or joints.
    pub nodes: u64,
    /// Maximum nesting depth of JSON, or of a joint hierarchy.
    pub depth: u64,
    /// Maximum number of frames of one clip.
    pub frames: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            bytes: 1 << 30,
            elements: 1 << 28,
            nodes: 1 << 16,
            depth: 128,
            frames: 1 << 20,
        }
    }
}

impl Limits {
    /// Returns an error if `found` exceeds `limit`; the position becomes text only then.
    pub(crate) fn check(
        at: impl Display,
        which: &'static str,
        found: u64,
        limit: u64,
    ) -> Result<(), ReadError> {
        if found <= limit {
            return Ok(());
        }
        Err(ReadError::LimitExceeded {
            at: at.to_string(),
            which,
            found,
            limit,
        })
    }
}
