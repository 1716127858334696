//! From a character to an H-Anim figure in X3D 4.0, XML encoding.
//!
//! - `names`: names that the standard allows, each once
//! - `markup`: tags, attributes, numbers
//! - `bones`: joints in the standard's terms, at rest all unturned
//! - `bodies`: meshes as they lie at rest, rigid ones and skin
//! - `shapes`: triangles, colours and pictures
//! - `tracks`: clips as interpolators and routes
//! - `writer`: the document

mod bodies;
mod bones;
mod markup;
pub(in crate::x3d) mod names;
mod shapes;
mod tracks;
mod writer;

pub use writer::{WriteError, WriteOptions, Written, write};
