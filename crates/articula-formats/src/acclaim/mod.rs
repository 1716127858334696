//! Acclaim skeleton and motion files (ASF, AMC): the original form of the CMU motions, in and
//! out.
//!
//! A skeleton file gives every bone a direction and a length in the axes of the whole figure,
//! and axes of its own (`C`) about which the motion file turns it (`M`): in the axes of the
//! figure a bone turns by `C · M · C⁻¹` within its parent. A bone starts where its parent ends.
//!
//! Our joint is the start of the bone: its rest orientation is `C`, so nothing is lost and
//! nothing has to be conjugated, and `M` is its rotation away from rest.
//!
//! Source: Acclaim Skeleton File Definition 1.10 (1995); the files of CMU and what reads them;
//! see `docs/formats/acclaim.md`.
//! Differs: units are told as described there; a motion's rate is in none of the files.

mod amc;
mod asf;
mod bones;
mod hierarchy;
mod reader;
mod writer;

pub use reader::read;
pub use writer::{WriteOptions, write};
