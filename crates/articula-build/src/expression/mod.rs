//! Channels that drive expressions, turned into morph weights and joint transforms.
//!
//! - `resolve`: what expressions show that are driven at once (binary ones, masks)
//! - `bake`: a clip with its expressions written out

mod bake;
mod resolve;

pub use bake::bake;
pub use resolve::resolve;
