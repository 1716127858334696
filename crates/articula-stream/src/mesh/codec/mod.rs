//! The codec of meshes on the wire: one level alone, or what one level adds to a coarser one.
//!
//! Source: `docs/methods/clustered-mesh.md` 8.1, scheme RT (each finer level is traversed again and its
//! vertices are matched with those of the coarser level: no attribute is sent twice). In the
//! order of the line:
//!
//! - `mesh`: a mesh in whole numbers
//! - `surface`: what is known of a level when its values are coded
//! - `quantise`: from floating point to whole numbers and back
//! - `check`: whether a mesh holds to its layout
//! - `refinement`: levels as bytes and back, the whole walk
//! - `canonical`: an order that depends on values alone
//! - `half_edges`: which faces lie beside each other
//! - `connectivity`: which corners the faces join
//! - `matching`: which points the coarser level has
//! - `seams`: which wedges the corners have
//! - `positions`: positions of new points
//! - `attributes`: all values but positions, over a surface that is known
//! - `mixing`, `number`, `range_coder`: decisions and numbers as bytes

mod attributes;
mod canonical;
mod check;
mod connectivity;
mod half_edges;
mod matching;
mod mesh;
mod mixing;
mod number;
mod positions;
mod quantise;
mod range_coder;
mod refinement;
mod seams;
mod surface;

pub use mesh::{Layout, MorphLayout, QuantisedMesh};
pub use quantise::{Grid, Precision, Quantised, Scale, quantise, restore};
pub use refinement::{decode_level, encode_level};
