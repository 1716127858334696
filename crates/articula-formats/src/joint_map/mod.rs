//! Joint maps: for each kind of rig, the H-Anim joint of each joint name.
//!
//! - [`builtin`], [`parse`]: the built-in maps, and maps from a user's file
//! - [`write()`]: writes a map to be edited
//! - [`vrm_bones`]: joints by their VRM human bone names
//!
//! `articula-build` matches a skeleton against them. Source: thesis 3.1.3; H-Anim 1.1 and 2
//! (ISO/IEC 19774); the rules are described in `docs/formats/joint-map.md`.

mod builtin;
mod file;
mod humanoid;
mod names;
mod standard;
mod write;

pub use builtin::builtin;
pub use file::parse;
pub(crate) use humanoid::is_vrm_bone;
pub use humanoid::vrm_bones;
pub use write::{JointMapText, write};
