//! H-Anim figures in X3D and VRML97: both are read, X3D is written.
//!
//! [`read`] returns the first humanoid of a scene. The modules, in the order in which data passes
//! through them:
//!
//! - `scene`, `xml`, `classic`: from either encoding to one node tree
//! - `fields`: typed field values, within the limits
//! - `figure`, `placement`, `frames`: joints and what is attached to them, in metres
//! - `corners`, `faces`, `polygon`, `solids`, `surface`: from geometry nodes to triangles
//! - `look`: colours and pictures
//! - `meshes`, `influences`: segments, skin and displacers
//! - `clips`, `draft`, `motion`, `routes`, `pose`: animations
//! - `credits`: authors and licence
//! - `reader`: the whole file
//! - `write`: writer of X3D 4.0
//!
//! Source: ISO/IEC 19774 (H-Anim 1.1 to 2), ISO/IEC 19775-1 (X3D), ISO/IEC 14772-1 (VRML97). See
//! `docs/formats/x3d.md`.

mod classic;
mod clips;
mod corners;
mod credits;
mod draft;
mod faces;
mod fields;
mod figure;
mod frames;
mod influences;
mod look;
mod meshes;
mod motion;
mod names;
mod placement;
mod polygon;
mod pose;
mod reader;
mod routes;
mod scene;
mod solids;
mod surface;
mod write;
mod xml;

pub use reader::{Site, X3dFile, read};
pub use write::write;
