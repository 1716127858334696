//! Acclaim skeleton and motion files (ASF, AMC), the original form of the CMU motions; reading and
//! writing.
//!
//! A skeleton file gives every bone a direction and a length in the axes of the whole figure, and a
//! local coordinate system (`C`) in which the motion file rotates it (`M`): in the axes of the
//! figure a bone turns by `C · M · C⁻¹` relative to its parent. A bone starts where its parent
//! ends.
//!
//! A joint of the character is the start of a bone. Its rest orientation is `C`, so `M` is its
//! rotation relative to rest, without loss and without conjugation.
//!
//! Source: Acclaim Skeleton File Definition 1.10 (1995); the CMU files and the programs that read
//! them; see `docs/formats/acclaim.md`. Units are guessed as described there; the format has no
//! field for the rate of a motion.

mod amc;
mod asf;
mod bones;
mod hierarchy;
mod reader;
mod writer;

pub use reader::read;
pub use writer::{WriteOptions, write};
