//! Results of writers: the bytes and what they could not express, or an error.

use articula_core::source::{Character, RawClip};
use thiserror::Error;

/// An encoded file, with descriptions of data that the format could not express.
#[derive(Debug, Clone, PartialEq)]
pub struct WrittenFile {
    /// The whole file; for Acclaim, the skeleton file.
    pub bytes: Vec<u8>,
    /// The motion file, if the format has a separate one and a clip was requested.
    pub motion: Option<Vec<u8>>,
    /// Descriptions of what could not be written as it is.
    pub left_out: Vec<String>,
}

/// Reason why a file could not be written.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum WriteError {
    /// The requested clip does not exist.
    #[error("clip {index} is out of range: the character has {count} clips")]
    NoClip {
        /// The requested index.
        index: usize,
        /// Number of clips of the character.
        count: usize,
    },
    /// The character has no joint.
    #[error("the character has no joint to write")]
    NoJoint,
    /// A numeric option is not positive.
    #[error("{which} is {found}, expected a positive number")]
    NotPositive {
        /// Name of the option.
        which: &'static str,
        /// Its value.
        found: f32,
    },
    /// The articulation belongs to another skeleton.
    #[error("the articulation has {found} joints, the character has {expected}")]
    OtherSkeleton {
        /// Number of joints of the articulation.
        found: usize,
        /// Number of joints of the character.
        expected: usize,
    },
    /// The file exceeds the 32-bit size of a GLB.
    #[error("the file would take {bytes} bytes; a GLB file must be smaller than 4 GiB")]
    TooLarge {
        /// Size that the file would have, in bytes.
        bytes: u64,
    },
    /// An argument does not match the document.
    #[error("{at}: {what}")]
    Mismatch {
        /// Name of the argument or path.
        at: String,
        /// Description of the mismatch.
        what: String,
    },
}

impl WriteError {
    pub(crate) fn mismatch(at: impl Into<String>, what: impl Into<String>) -> Self {
        Self::Mismatch {
            at: at.into(),
            what: what.into(),
        }
    }

    /// Returns an error for numbers that are not above zero.
    pub(crate) fn check(numbers: &[(&'static str, f32)]) -> Result<(), Self> {
        let bad = |(_, found): &&(&str, f32)| !(found.is_finite() && *found > 0.0);
        match numbers.iter().find(bad) {
            Some(&(which, found)) => Err(Self::NotPositive { which, found }),
            None => Ok(()),
        }
    }

    /// Returns the clip of this index.
    pub(crate) fn clip(character: &Character, index: usize) -> Result<&RawClip, Self> {
        let count = character.clips.len();
        let clip = character.clips.get(index);
        clip.ok_or(Self::NoClip { index, count })
    }
}
