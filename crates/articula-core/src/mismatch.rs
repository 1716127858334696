//! The one error of this crate: values that do not belong together.

use std::fmt;

/// The caller paired things that do not fit, such as a parent that comes after its child.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mismatch {
    /// Where, as a path into the value that was refused, such as `joints[4].parent`.
    pub at: String,
    /// What was found and what was expected.
    pub what: String,
}

impl Mismatch {
    /// Says that the value at `at` does not fit, and why.
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
