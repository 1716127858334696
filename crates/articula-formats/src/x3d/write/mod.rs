//! Conversion of a character to an H-Anim figure in X3D 4.0, XML encoding.
//!
//! - `markup`: tags, attributes, numbers
//! - `zero`: the pose in which all joints are unrotated
//! - `bones`: joints with H-Anim fields
//! - `bodies`: meshes in that pose, rigid ones and skin
//! - `shapes`: triangles, colours and pictures
//! - `tracks`: clips as interpolators and routes
//! - `writer`: the document

mod bodies;
mod bones;
mod markup;
mod shapes;
mod tracks;
mod writer;
mod zero;

pub use writer::write;
