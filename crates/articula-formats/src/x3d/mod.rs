//! H-Anim figures in X3D and VRML97, in and out.
//!
//! [`read`] gives the first humanoid of a scene. In the order of the line:
//!
//! - `scene`, `xml`, `classic`: from either encoding to one node tree
//! - `fields`: what the text of a field means, within the limits
//! - `figure`, `placement`, `frames`: joints and what hangs on them, in metres
//! - `faces`, `polygon`, `solids`, `surface`: from geometry nodes to triangles
//! - `look`: colours and pictures
//! - `meshes`, `influences`: segments, skin and displacers
//! - `clips`, `motion`, `routes`, `pose`: what moves
//! - `credits`: who made it
//! - `reader`: all of it in turn
//! - `write`: the way back, in X3D 4.0
//!
//! Source: ISO/IEC 19774 (H-Anim 1.1 to 2), ISO/IEC 19775-1 (X3D), ISO/IEC 14772-1 (VRML97).
//! The page is `docs/formats/x3d.md`.

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
