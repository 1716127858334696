//! Biovision animation (BVA): text that moves each segment of a figure independently in world
//! space.
//!
//! The format preceded BVH and has no hierarchy. [`read`] returns the segments as unconnected
//! joints; [`tree`] assembles them into a figure if their names are known.
//!
//! Source: descriptions by its users (Biovision's own note: translation first, then rotations in
//! the order Z X Y, then scale; right-handed world with +Y up); see `docs/formats/bva.md`.

mod reader;
mod tree;

pub use reader::read;
pub use tree::tree;
