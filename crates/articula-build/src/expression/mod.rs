//! Conversion of expression channels to morph weights and joint transforms.
//!
//! - `resolve`: the resulting values of expressions that are driven together (binary ones, masks)
//! - `bake`: a clip whose expressions are converted to other channels

mod bake;
mod resolve;

pub use bake::bake;
pub use resolve::resolve;
