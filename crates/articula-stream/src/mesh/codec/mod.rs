//! Codec of quantised meshes: one level alone, or as a refinement of a coarser one.
//!
//! Source: `docs/methods/clustered-mesh.md` part 8.1, scheme RT: each finer level is traversed
//! again and its vertices are matched with those of the coarser level, so no attribute is sent
//! twice. In the order of processing:
//!
//! - `mesh`: a mesh in whole numbers
//! - `surface`: the part of a level that is known when its values are coded
//! - `quantise`: conversion from floating point to whole numbers and back
//! - `check`: validation of a mesh against its layout
//! - `refinement`: encoding and decoding of a level
//! - `canonical`: an order that depends on values only
//! - `half_edges`: adjacency of faces
//! - `connectivity`: points of the faces
//! - `matching`: points known from the coarser level
//! - `seams`: wedges of the faces
//! - `positions`: positions of new points
//! - `attributes`: all values but positions, over a known surface
//! - `mixing`, `number`, `contexts`: entropy coding of decisions and numbers, over `range_coder`

mod attributes;
mod canonical;
mod check;
mod connectivity;
mod contexts;
mod half_edges;
mod matching;
mod mesh;
mod mixing;
mod number;
mod positions;
mod quantise;
mod refinement;
mod seams;
mod surface;

pub use mesh::{Layout, MorphLayout, QuantisedMesh};
pub use quantise::{Grid, Precision, Quantised, Scale, quantise, restore};
pub use refinement::{decode_level, encode_level};
