//! Biovision hierarchical motion (BVH): joint offsets and Euler angles as text, in and out.
//!
//! Source: the format has no standard; read are the habits of its writers as described in
//! `docs/formats/bvh.md`. A joint's channels are intrinsic rotations in the order they are
//! declared; position channels replace the joint's offset.
//! Differs: units and up axis are not in the file, so both are told from the figure, and said
//! in a warning; [`ReadOptions`] overrides them.

mod hierarchy;
mod motion;
mod reader;
mod writer;

pub use crate::sampled::WriteError;
pub use crate::units::Up;
pub use reader::{BvhFile, ReadOptions, read};
pub use writer::{ChannelOrder, WriteOptions, write};
