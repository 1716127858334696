//! Biovision hierarchical motion (BVH): joint offsets and Euler angles as text, in and out.
//!
//! Source: the format has no standard; read are the habits of its writers as described in
//! `docs/formats/bvh.md`. A joint's channels are intrinsic rotations in the order they are
//! declared; position channels replace the joint's offset.
//! Differs: units and up axis are not in the file, so both are told from the figure, and said
//! in a warning; [`ReadOptions`](crate::ReadOptions) overrides them.

mod hierarchy;
mod motion;
mod reader;
mod writer;

pub use reader::read;
pub use writer::{ChannelOrder, WriteOptions, write};
