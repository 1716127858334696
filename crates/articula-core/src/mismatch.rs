//! The error of this crate for values that do not fit together.

use std::fmt;

/// The error for values that do not fit together, such as a parent that comes after its child.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mismatch {
    /// Path to the rejected value, such as `joints[4].parent`.
    pub at: String,
    /// What was found and what was expected.
    pub what: String,
}

impl Mismatch {
    /// Creates an error for the value at `at`, with the reason.
    pub fn new(at: impl Into<String>, what: impl Into<String>) -> Self {
        Self {
            at: at.into(),
            what: what.into(),
        }
    }
}

impl fmt::Display for Mismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.at, self.what)
    }
}

impl std::error::Error for Mismatch {}
