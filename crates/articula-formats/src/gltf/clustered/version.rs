//! Versions of the extension: from which end its objects count levels.

use crate::error::ReadError;
use crate::gltf::place::Place;

/// The version that is written.
pub(super) const VERSION: u64 = 2;

/// Most levels that are read or written: whoever asks for each of them is done in time.
pub(super) const MAX_LEVELS: usize = 256;

/// How an object of the extension counts levels. The only place that knows of another way than
/// from the finest, 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Counts {
    FromFinest,
    /// Version 1, which has no member `version`.
    FromCoarsest,
}

impl Counts {
    /// That of an object of the extension.
    pub(super) fn of(extension: &Place<'_>) -> Result<Self, ReadError> {
        let Some(version) = extension.get("version") else {
            return Ok(Self::FromCoarsest);
        };
        match version.whole()? {
            1 => Ok(Self::FromCoarsest),
            VERSION => Ok(Self::FromFinest),
            other => Err(version.malformed(format!("version {other}, known are 1 and {VERSION}"))),
        }
    }

    /// What there is one of for each level, finest first.
    pub(super) fn list<T>(self, mut stored: Vec<T>) -> Vec<T> {
        if self == Self::FromCoarsest {
            stored.reverse();
        }
        stored
    }

    /// Number of a level from the finest, for its number in the document; `None` if there is no
    /// such level among `count`.
    pub(super) fn level(self, stored: usize, count: usize) -> Option<usize> {
        let from_the_other_end = count.checked_sub(1)?.checked_sub(stored)?;
        Some(match self {
            Self::FromFinest => stored,
            Self::FromCoarsest => from_the_other_end,
        })
    }
}
