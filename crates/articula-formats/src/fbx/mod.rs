//! FBX, in the binary and the text encoding, of version 5.8 to 7.7: read only.
//!
//! [`read`] returns the character or the motion of a file. The modules, in the order in which data passes through
//! them:
//!
//! - `records`, `binary`, `ascii`, `walk`: the records of both encodings
//! - `repair`: what is mended before the crate `fbx-rs` reads the bytes
//! - `scene`: nodes, meshes, materials and takes, by that crate
//! - `takes`: animations at frames
//! - `skeleton`: from nodes to joints, and their rest pose
//! - `surface`, `influences`, `shapes`: meshes, skins and blend shapes
//! - `look`: colours and pictures
//! - `clips`: from takes to clips
//! - `source`, `kinds`: what is read, within its limits, and warnings
//! - `reader`: the whole file
//!
//! See `docs/formats/fbx.md`.

mod ascii;
mod binary;
mod clips;
mod influences;
mod kinds;
mod look;
mod reader;
mod records;
mod repair;
mod scene;
mod shapes;
mod skeleton;
mod source;
mod surface;
mod takes;
mod walk;

pub use reader::{FbxFile, read};
