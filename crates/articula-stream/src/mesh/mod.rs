//! Mesh levels of a character as one stream that refines: a head, then chunks, level after level.
//!
//! Source: `spec/clustered-mesh.md` 7 (TRANSPORT form) and 8.1; the pages are
//! `docs/formats/clustered-stream.md` and `docs/formats/mesh-stream.md`. A chunk holds what one
//! level adds to one object (a part of a mesh, or a region of it); no vertex is ever sent twice.
//! Any prefix of whole levels shows the character.
//!
//! - [`quantise`], [`restore`]: from floating point to whole numbers and back
//! - [`encode_level`], [`encode_refinement`], [`decode_level`], [`decode_refinement`]: one level
//!   alone, or what one level adds to a coarser one, as bytes
//! - [`write()`]: all levels of all objects to bytes, with the map of what is where
//! - [`MeshStream`]: the head, opened
//! - [`Receiver`]: the client's side, which checks, decodes and puts together

mod codec;
mod hash;
mod head;
mod receiver;
mod write;

pub use codec::{
    Grid, Layout, MorphLayout, Precision, Quantised, QuantisedMesh, Scale, TexcoordGrid,
    decode_level, decode_refinement, encode_level, encode_refinement, quantise, restore,
};
pub use head::{MeshStream, StreamObject};
pub use receiver::Receiver;
pub use write::{ObjectLevels, Written, write};
