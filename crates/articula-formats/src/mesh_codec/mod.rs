//! The codec of meshes on the wire: one level alone, or what one level adds to a coarser one.
//!
//! Source: `spec/clustered-mesh.md` 8.1, scheme RT (each finer level is traversed again and its
//! vertices are matched with those of the coarser level: no attribute is sent twice). In the
//! order of the line:
//!
//! - [`mesh`]: a mesh in whole numbers
//! - `surface`: what is known of a level when its values are coded
//! - [`quantise`]: from floating point to whole numbers and back
//! - `check`: whether a mesh holds to its layout
//! - `range_coder`, `number`: decisions and numbers as bytes

mod check;
pub mod mesh;
#[cfg_attr(
    not(test),
    expect(dead_code, reason = "the walks that use it come next")
)]
mod number;
pub mod quantise;
#[cfg_attr(
    not(test),
    expect(dead_code, reason = "the walks that use it come next")
)]
mod range_coder;
#[expect(dead_code, reason = "the walks that use it come next")]
mod surface;

pub use mesh::{Layout, MorphLayout, QuantisedMesh};
pub use quantise::{Grid, Precision, Quantised, Scale, TexcoordGrid, quantise, restore};
