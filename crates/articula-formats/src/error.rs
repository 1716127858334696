//! Errors of readers, sorted by cause, and warnings about files that were read.

use articula_core::MalformedBytes;
use thiserror::Error;

/// Reason why a file could not be read. The message names what was found, what was expected and
/// where.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ReadError {
    /// The file breaks the rules of its format.
    #[error("{at}: {what}")]
    Malformed {
        /// Byte offset, line or path into the document.
        at: String,
        /// What was found and what was expected.
        what: String,
    },
    /// The file is valid but uses an unsupported feature.
    #[error("{at}: {what} is not supported; {mend}")]
    Unsupported {
        /// Path into the document.
        at: String,
        /// The feature.
        what: String,
        /// Advice to the user.
        mend: String,
    },
    /// The file exceeds the memory or time that the caller allows.
    #[error("{at}: {found} {which}, the limit is {limit}")]
    LimitExceeded {
        /// Path into the document.
        at: String,
        /// Name of the limit, in words.
        which: &'static str,
        /// Amount that the file requires.
        found: u64,
        /// Amount that the caller allows.
        limit: u64,
    },
    /// An external file could not be fetched.
    #[error("{at}: cannot read \"{uri}\": {what}")]
    Missing {
        /// Path into the document.
        at: String,
        /// The relative URI.
        uri: String,
        /// Message of the resolver.
        what: String,
    },
}

impl ReadError {
    /// Creates a [`ReadError::Malformed`].
    pub(crate) fn malformed(at: impl Into<String>, what: impl Into<String>) -> Self {
        Self::Malformed {
            at: at.into(),
            what: what.into(),
        }
    }
}

impl ReadError {
    /// Converts an error of the JSON parser: its position stated once, and the expected form of the
    /// file.
    pub(crate) fn of_json(error: &serde_json::Error, form: &str) -> Self {
        let at = format!("line {} column {}", error.line(), error.column());
        let said = error.to_string();
        let said = said
            .rsplit_once(" at line ")
            .map_or(said.as_str(), |(what, _)| what);
        Self::malformed(at, format!("{said}; the form is {form}"))
    }
}

impl From<MalformedBytes> for ReadError {
    fn from(bad: MalformedBytes) -> Self {
        Self::malformed(format!("byte {}", bad.at), bad.what)
    }
}

/// An irregularity of a file that was repaired or left out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning {
    /// Byte offset, line or path into the document.
    pub at: String,
    /// What was found and how it was handled.
    pub what: String,
    /// The fact that was guessed, if an option of the reader can state it.
    pub guess: Option<Assumption>,
}

/// A fact that a file omits and a reader has to guess unless its options state it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Assumption {
    /// Scale from file units to metres.
    Unit,
    /// Axis that points up.
    UpAxis,
    /// Frames per second.
    Rate,
    /// Skeleton that a motion belongs to.
    Skeleton,
    /// Whether the first frame of a clip belongs to the motion.
    FirstFrame,
}

impl Warning {
    /// Creates a warning about a position in the file.
    pub(crate) fn new(at: impl Into<String>, what: impl Into<String>) -> Self {
        Self {
            at: at.into(),
            what: what.into(),
            guess: None,
        }
    }

    /// Creates a warning about a guess, with the evidence for it.
    pub(crate) fn guess(at: impl Into<String>, what: impl Into<String>, guess: Assumption) -> Self {
        Self {
            guess: Some(guess),
            ..Self::new(at, what)
        }
    }
}

/// A value together with the warnings about its file.
#[derive(Debug, Clone, PartialEq)]
pub struct Parsed<T> {
    /// The value that was read.
    pub value: T,
    /// Warnings, in the order of the file.
    pub warnings: Vec<Warning>,
}
