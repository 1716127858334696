//! Why something could not be done, sorted by blame.

use articula_core::Mismatch;
use articula_flat::planar::PlanarError;
use articula_flat::portrait::PortraitError;
use articula_formats::ReadError;
use articula_stream::StreamError;
use std::fmt::Display;
use thiserror::Error;

/// Why a step of the library failed. The text is one line: place, what was found, the mend.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Error {
    /// What went wrong, and in which file or part of it.
    #[error("{place}: {cause}")]
    At {
        /// The file, or a path into it.
        place: String,
        /// What went wrong there.
        cause: Box<Error>,
    },
    /// The bytes are malformed, use what is not read, ask for too much, or lack a neighbour.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A stream of mesh levels is malformed, of a form that is not read, or asks for too much.
    #[error(transparent)]
    Stream(#[from] StreamError),
    /// Values were paired that do not fit.
    #[error(transparent)]
    Mismatch(#[from] Mismatch),
    /// The file is good, but what was asked for cannot be made of it.
    #[error("{0}")]
    Unsuited(String),
    /// An argument is wrong by itself or names something that is not there.
    #[error("{0}")]
    Argument(String),
    /// A list of locked vertices that does not fit the meshes.
    #[error("locked vertices: {0}")]
    Locked(String),
    /// A motion whose skeleton is missing: `.amc` without its `.asf`.
    #[error("{0}")]
    Skeleton(String),
    /// Nothing says which joint is which; a joint map mends it
    /// ([`OpenOptions::profiles`](crate::OpenOptions::profiles)).
    #[error("{0}")]
    Unmapped(String),
    /// A format could not hold what was to be written.
    #[error(transparent)]
    Write(Box<dyn std::error::Error + Send + Sync>),
    /// A picture or a file of vector graphics could not be made.
    #[error(transparent)]
    Picture(Box<dyn std::error::Error + Send + Sync>),
    /// A file could not be read or written.
    #[error("{0}")]
    Io(String),
    /// The caller's progress callback asked to stop.
    #[error("cancelled")]
    Cancelled,
}

/// What the functions of this crate give.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// Whether the caller asked for something that cannot be, rather than gave a bad file.
    pub fn is_argument(&self) -> bool {
        match self {
            Self::At { cause, .. } => cause.is_argument(),
            Self::Argument(_) => true,
            _ => false,
        }
    }

    /// The error itself, without the places it was met at.
    pub fn cause(&self) -> &Self {
        match self {
            Self::At { cause, .. } => cause.cause(),
            other => other,
        }
    }

    /// The error at a place within the outermost one.
    #[cfg(not(target_family = "wasm"))]
    pub(crate) fn within(self, inner: String) -> Self {
        let at = |place, cause| Self::At { place, cause };
        match self {
            Self::At { place, cause } => at(place, Box::new(at(inner, cause))),
            other => at(inner, Box::new(other)),
        }
    }

    /// An [`Error::Unsuited`].
    pub(crate) fn unsuited(what: impl Into<String>) -> Self {
        Self::Unsuited(what.into())
    }

    /// An [`Error::Argument`].
    pub(crate) fn argument(what: impl Into<String>) -> Self {
        Self::Argument(what.into())
    }
}

/// Puts a place in front of an error.
pub(crate) trait Context<T> {
    /// In front of this error stands `place`.
    fn context(self, place: impl Display) -> Result<T>;
    /// The same with a place that is only spelled out when it is needed.
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
    articula_flat::PictureError => Picture,
}

impl From<PlanarError> for Error {
    fn from(error: PlanarError) -> Self {
        match error {
            PlanarError::Cancelled(_) => Self::Cancelled,
            other => Self::Picture(Box::new(other)),
        }
    }
}

impl From<PortraitError> for Error {
    fn from(error: PortraitError) -> Self {
        match error {
            PortraitError::Cancelled(_) => Self::Cancelled,
            other => Self::Picture(Box::new(other)),
        }
    }
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
        assert!(!read.unwrap_err().is_argument());
    }
}
