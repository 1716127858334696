//! From a character to an H-Anim figure in X3D 4.0, XML encoding.
//!
//! - `names`: names that the standard allows, each once
//! - `markup`: tags, attributes, numbers
//! - `zero`: the pose in which all joints are unturned
//! - `bones`: joints in the standard's terms
//! - `bodies`: meshes as they lie in that pose, rigid ones and skin
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
mod zero;

pub use writer::write;
