//! How much a file may ask for, so that a hostile one cannot exhaust memory or time.

use crate::error::ReadError;

/// Upper bounds that every reader keeps. The defaults pass any character made by people.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of one file, buffer or picture.
    pub bytes: u64,
    /// Elements that all decoded arrays of one file may hold together (vertices, indices, key
    /// values); sparse or zero-filled accessors ask for memory without bringing bytes.
    pub elements: u64,
    /// Nodes or joints.
    pub nodes: u64,
    /// Nesting of JSON, or of a joint hierarchy.
    pub depth: u64,
    /// Frames of one clip.
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
    /// Refuses `found` above `limit`.
    pub(crate) fn check(
        at: &str,
        which: &'static str,
        found: u64,
        limit: u64,
    ) -> Result<(), ReadError> {
        if found <= limit {
            return Ok(());
        }
        Err(ReadError::LimitExceeded {
            at: at.to_owned(),
            which,
            found,
            limit,
        })
    }
}
