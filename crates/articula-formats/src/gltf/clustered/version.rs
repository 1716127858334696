//! Versions of the extension, which differ in the order of levels.

use crate::error::ReadError;
use crate::gltf::place::Place;

/// The version that is written.
pub(super) const VERSION: u64 = 2;

/// Maximum number of levels that are read or written; bounds the time of loops over all levels.
pub(super) const MAX_LEVELS: usize = 256;

/// Order in which an object of the extension counts levels. Outside of this module levels always
/// count from the finest, 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Counts {
    FromFinest,
    /// Version 1, which has no member `version`.
    FromCoarsest,
}

impl Counts {
    /// Returns the order used by an object of the extension.
    pub(super) fn of(extension: &Place<'_>) -> Result<Self, ReadError> {
        let Some(version) = extension.get("version") else {
            return Ok(Self::FromCoarsest);
        };
        match version.whole()? {
            1 => Ok(Self::FromCoarsest),
            VERSION => Ok(Self::FromFinest),
            other => {
                Err(version.malformed(format!("unknown version {other}; expected 1 or {VERSION}")))
            }
        }
    }

    /// Converts a list with one entry per level to finest first.
    pub(super) fn list<T>(self, mut stored: Vec<T>) -> Vec<T> {
        if self == Self::FromCoarsest {
            stored.reverse();
        }
        stored
    }

    /// Converts a level index of the document to one from the finest; `None` if there is no such
    /// level among `count`.
    pub(super) fn level(self, stored: usize, count: usize) -> Option<usize> {
        let from_the_other_end = count.checked_sub(1)?.checked_sub(stored)?;
        Some(match self {
            Self::FromFinest => stored,
            Self::FromCoarsest => from_the_other_end,
        })
    }
}
