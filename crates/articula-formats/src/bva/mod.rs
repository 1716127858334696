//! Biovision animation (BVA): text that moves each segment of a figure by itself in the world.
//!
//! The format came before BVH and has no hierarchy. [`read`] gives the segments side by side;
//! [`tree`] puts them together again if their names are known.
//!
//! Source: what its users wrote of it (Biovision's own note: translation first, then rotations
//! in the order Z X Y, then scale; right-handed world with +Y up); see `docs/formats/bva.md`.

mod reader;
mod tree;

pub use reader::read;
pub use tree::tree;
