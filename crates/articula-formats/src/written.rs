//! What writers give: the bytes and what they could not hold, or why there are none.

use articula_core::source::{Character, RawClip};
use thiserror::Error;

/// A written figure, and what the format could not hold of it.
#[derive(Debug, Clone, PartialEq)]
pub struct WrittenFile {
    /// The whole file; of Acclaim files the skeleton.
    pub bytes: Vec<u8>,
    /// The motion, where the format keeps it in a file of its own and a clip was asked for.
    pub motion: Option<Vec<u8>>,
    /// What could not be written as it is, in words.
    pub left_out: Vec<String>,
}

/// Why a file could not be written.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum WriteError {
    /// There is no such clip.
    #[error("clip {index} was asked for, the character has {count}")]
    NoClip {
        /// The index asked for.
        index: usize,
        /// Clips of the character.
        count: usize,
    },
    /// There is no joint.
    #[error("the character has no joint to write")]
    NoJoint,
    /// A number of the options is not positive.
    #[error("{which} is {found}, a positive number is expected")]
    NotPositive {
        /// Which one.
        which: &'static str,
        /// What it is.
        found: f32,
    },
    /// The articulation is of another skeleton.
    #[error("the articulation has {found} joints, the character {expected}")]
    OtherSkeleton {
        /// Joints of the articulation.
        found: usize,
        /// Joints of the character.
        expected: usize,
    },
    /// A GLB counts its bytes with 32 bits.
    #[error("the file would take {bytes} bytes, a GLB holds less than 4 GiB")]
    TooLarge {
        /// Bytes that the file would take.
        bytes: u64,
    },
    /// What the caller gave does not belong to the document.
    #[error("{at}: {what}")]
    Mismatch {
        /// Which argument or path.
        at: String,
        /// What does not fit.
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

    /// Refuses numbers that are not above zero.
    pub(crate) fn check(numbers: &[(&'static str, f32)]) -> Result<(), Self> {
        let bad = |(_, found): &&(&str, f32)| !(found.is_finite() && *found > 0.0);
        match numbers.iter().find(bad) {
            Some(&(which, found)) => Err(Self::NotPositive { which, found }),
            None => Ok(()),
        }
    }

    /// The clip of this index.
    pub(crate) fn clip(character: &Character, index: usize) -> Result<&RawClip, Self> {
        let count = character.clips.len();
        let clip = character.clips.get(index);
        clip.ok_or(Self::NoClip { index, count })
    }
}
