//! What can be wrong with a file, sorted by blame, and what was odd about a good one.

use articula_core::MalformedBytes;
use thiserror::Error;

/// Why a file could not be read. The text names what was found, what was expected and where.
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
    /// The file is good but uses what we do not read.
    #[error("{at}: {what} is not supported; {mend}")]
    Unsupported {
        /// Path into the document.
        at: String,
        /// The feature.
        what: String,
        /// What the user can do.
        mend: String,
    },
    /// The file would take more memory or time than the caller allows.
    #[error("{at}: {found} {which}, the limit is {limit}")]
    LimitExceeded {
        /// Path into the document.
        at: String,
        /// Which limit, as words.
        which: &'static str,
        /// What the file asks for.
        found: u64,
        /// What the caller allows.
        limit: u64,
    },
    /// Something beside the file could not be had.
    #[error("{at}: cannot read \"{uri}\": {what}")]
    Missing {
        /// Path into the document.
        at: String,
        /// The relative URI.
        uri: String,
        /// What the resolver said.
        what: String,
    },
}

impl ReadError {
    /// A [`ReadError::Malformed`].
    pub(crate) fn malformed(at: impl Into<String>, what: impl Into<String>) -> Self {
        Self::Malformed {
            at: at.into(),
            what: what.into(),
        }
    }
}

impl ReadError {
    /// What a JSON parser says, its place named once, and what the file should look like.
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

/// Something odd that was repaired or left out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning {
    /// Byte offset, line or path into the document.
    pub at: String,
    /// What was found and what was done about it.
    pub what: String,
    /// What was guessed, where the caller could have said it.
    pub guess: Option<Assumption>,
}

/// What a file does not say and a reader has to guess; options of the reader say it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Assumption {
    /// The scale to metres.
    Unit,
    /// The axis that points up.
    UpAxis,
    /// Frames a second.
    Rate,
    /// The skeleton of a motion.
    Skeleton,
}

impl Warning {
    /// Says what is odd at a place.
    pub(crate) fn new(at: impl Into<String>, what: impl Into<String>) -> Self {
        Self {
            at: at.into(),
            what: what.into(),
            guess: None,
        }
    }

    /// Says what was guessed at a place, and by which signs.
    pub(crate) fn guess(at: impl Into<String>, what: impl Into<String>, guess: Assumption) -> Self {
        Self {
            guess: Some(guess),
            ..Self::new(at, what)
        }
    }
}

/// A value together with what was odd about its file.
#[derive(Debug, Clone, PartialEq)]
pub struct Parsed<T> {
    /// What was read.
    pub value: T,
    /// What was odd, in the order of the file.
    pub warnings: Vec<Warning>,
}
