//! Biovision hierarchical motion (BVH): joint offsets and Euler angles as text; reading and
//! writing.
//!
//! The format has no standard; the reader follows the conventions of its writers as described in
//! `docs/formats/bvh.md`. A joint's channels are intrinsic rotations in the order they are
//! declared; position channels replace the joint's offset. The file states neither unit nor up
//! axis, so both are guessed from the figure and reported as warnings;
//! [`ReadOptions`](crate::ReadOptions) overrides them.

mod hierarchy;
mod motion;
mod reader;
mod writer;

pub use reader::read;
pub use writer::{ChannelOrder, WriteOptions, write};
