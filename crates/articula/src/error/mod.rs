//! Errors of the library, grouped by cause.

#[cfg(feature = "flat")]
mod flat;

use articula_core::Mismatch;
use articula_formats::ReadError;
use std::fmt::Display;
use thiserror::Error;

/// Error of a library function. The text is one line: location, cause, remedy.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Error {
    /// An error with its location.
    #[error("{place}: {cause}")]
    At {
        /// The file, or a path inside it.
        place: String,
        /// The error at that location.
        cause: Box<Error>,
    },
    /// A file is malformed, uses an unsupported feature, exceeds a limit, or refers to a missing
    /// file.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A stream is malformed, of an unsupported form, or exceeds a limit.
    #[cfg(feature = "streams")]
    #[error(transparent)]
    Stream(#[from] articula_stream::StreamError),
    /// Arguments do not fit each other.
    #[error(transparent)]
    Mismatch(#[from] Mismatch),
    /// The file is valid, but the requested result cannot be made from it.
    #[error("{0}")]
    Unsupported(String),
    /// An argument is invalid, or names something that does not exist.
    #[error("{0}")]
    Argument(String),
    /// A list of locked vertices does not fit the meshes.
    #[error("locked vertices: {0}")]
    LockedVertices(String),
    /// The skeleton of a motion is missing: `.amc` without its `.asf`.
    #[error("{0}")]
    Skeleton(String),
    /// The joints could not be identified; a joint map solves this
    /// ([`OpenOptions::joint_maps`](crate::OpenOptions::joint_maps)).
    #[error("{0}")]
    Unmapped(String),
    /// A format cannot hold the data to be written.
    #[error(transparent)]
    Write(Box<dyn std::error::Error + Send + Sync>),
    /// A picture or vector graphics file could not be made.
    #[error(transparent)]
    Picture(Box<dyn std::error::Error + Send + Sync>),
    /// A file could not be read or written.
    #[error("{0}")]
    Io(String),
    /// A file to be written exists, and existing files are kept.
    #[error("{0}")]
    Exists(String),
    /// The caller's progress callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

/// Result type of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// Returns whether the caller passed an invalid argument, as opposed to a bad file.
    pub fn is_argument(&self) -> bool {
        match self {
            Self::At { cause, .. } => cause.is_argument(),
            Self::Argument(_) => true,
            _ => false,
        }
    }

    /// Whether the caller stopped the work.
    #[cfg(feature = "item")]
    pub(crate) fn is_cancelled(&self) -> bool {
        matches!(self.cause(), Self::Cancelled)
    }

    /// Returns the innermost error, without its locations.
    pub fn cause(&self) -> &Self {
        match self {
            Self::At { cause, .. } => cause.cause(),
            other => other,
        }
    }

    /// Returns the kind of cause as a word that programs may compare: `invalid`, `unsupported`, `too-large`,
    /// `missing`, `mismatch`, `argument`, `skeleton`, `unmapped`, `write`, `io`, `exists` or `cancelled`.
    pub fn code(&self) -> &'static str {
        match self {
            Self::At { cause, .. } => cause.code(),
            Self::Read(ReadError::Malformed { .. }) => "invalid",
            Self::Read(ReadError::LimitExceeded { .. }) => "too-large",
            Self::Read(ReadError::Missing { .. }) => "missing",
            Self::Read(ReadError::Unsupported { .. }) | Self::Unsupported(_) => "unsupported",
            #[cfg(feature = "streams")]
            Self::Stream(error) => stream_code(error),
            Self::Mismatch(_) => "mismatch",
            Self::Argument(_) | Self::LockedVertices(_) => "argument",
            Self::Skeleton(_) => "skeleton",
            Self::Unmapped(_) => "unmapped",
            Self::Write(_) | Self::Picture(_) => "write",
            Self::Io(_) => "io",
            Self::Exists(_) => "exists",
            Self::Cancelled => "cancelled",
        }
    }

    /// Returns the locations of the error from the outermost to the innermost: the file if it is one of a
    /// file, then paths inside it, in the end that of a reader.
    pub fn places(&self) -> Vec<&str> {
        match self {
            Self::At { place, cause } => {
                let inner = cause.places();
                [place.as_str()].into_iter().chain(inner).collect()
            }
            Self::Read(
                ReadError::Malformed { at, .. }
                | ReadError::Unsupported { at, .. }
                | ReadError::LimitExceeded { at, .. }
                | ReadError::Missing { at, .. },
            ) => vec![at],
            Self::Mismatch(mismatch) => vec![&mismatch.at],
            _ => Vec::new(),
        }
    }

    /// Inserts a location inside the outermost one.
    #[cfg(not(target_family = "wasm"))]
    pub(crate) fn within(self, inner: String) -> Self {
        let at = |place, cause| Self::At { place, cause };
        match self {
            Self::At { place, cause } => at(place, Box::new(at(inner, cause))),
            other => at(inner, Box::new(other)),
        }
    }

    /// An [`Error::Unsupported`].
    pub(crate) fn unsuited(what: impl Into<String>) -> Self {
        Self::Unsupported(what.into())
    }

    /// An [`Error::Unsupported`] about a format of streams.
    #[cfg(not(feature = "streams"))]
    pub(crate) fn needs_streams(format: &str) -> Self {
        Self::Unsupported(format!(
            "streams (.{format}) need the feature `streams`, without which articula was built"
        ))
    }

    /// An [`Error::Unsupported`] about a format other than glTF.
    #[cfg(not(feature = "formats"))]
    pub(crate) fn needs_formats(format: &str) -> Self {
        Self::Unsupported(format!(
            "files of .{format} need the feature `formats`, without which articula was built"
        ))
    }

    /// An [`Error::Unsupported`] about FBX.
    #[cfg(not(feature = "fbx"))]
    pub(crate) fn needs_fbx() -> Self {
        let what = "FBX files need the feature `fbx`, without which articula was built";
        Self::Unsupported(what.to_owned())
    }

    /// An [`Error::Argument`].
    pub(crate) fn argument(what: impl Into<String>) -> Self {
        Self::Argument(what.into())
    }
}

/// The word for the cause of an error of a stream.
#[cfg(feature = "streams")]
fn stream_code(error: &articula_stream::StreamError) -> &'static str {
    use articula_stream::StreamError;
    match error {
        StreamError::Malformed { .. } => "invalid",
        StreamError::Unsupported { .. } => "unsupported",
        StreamError::LimitExceeded { .. } => "too-large",
        StreamError::Mismatch(_) => "mismatch",
    }
}

/// Adds a location to an error.
pub(crate) trait Context<T> {
    /// Prefixes the error with `place`.
    fn context(self, place: impl Display) -> Result<T>;
    /// Prefixes the error with a location that is formatted on error only.
    fn with_context<P: Display>(self, place: impl FnOnce() -> P) -> Result<T>;
}

impl<T, E: Into<Error>> Context<T> for Result<T, E> {
    fn context(self, place: impl Display) -> Result<T> {
        self.with_context(|| place)
    }

    fn with_context<P: Display>(self, place: impl FnOnce() -> P) -> Result<T> {
        self.map_err(|cause| Error::At {
            place: place().to_string(),
            cause: Box::new(cause.into()),
        })
    }
}

macro_rules! boxed {
    ($($from:ty => $variant:ident),* $(,)?) => {$(
        impl From<$from> for Error {
            fn from(error: $from) -> Self {
                Self::$variant(Box::new(error))
            }
        }
    )*};
}

boxed! {
    articula_formats::WriteError => Write,
    articula_formats::mpeg4::bap::BapError => Write,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_stand_in_front_and_the_blame_stays() {
        let inner: Result<()> = Err(Error::argument("no such clip"));
        let outer = inner.context("clips").context("a.glb").unwrap_err();
        assert_eq!(outer.to_string(), "a.glb: clips: no such clip");
        assert!(outer.is_argument());
        assert!(matches!(outer.cause(), Error::Argument(_)));
        let wrong = ReadError::Malformed {
            at: "line 1".into(),
            what: "no joint".into(),
        };
        let read: Result<()> = Err(wrong).context("a.bvh");
        let read = read.unwrap_err();
        assert!(!read.is_argument());
        assert_eq!((outer.code(), read.code()), ("argument", "invalid"));
        assert_eq!(outer.places(), ["a.glb", "clips"]);
        assert_eq!(read.places(), ["a.bvh", "line 1"]);
    }
}
