//! Joint-name profiles as files: which names of a kind of rig mean which H-Anim joint.
//!
//! - [`builtin`], [`parse`]: the profiles that come along, and the user's own
//! - [`vrm_bones`]: the names in the map that a VRM file brings itself
//!
//! They are data; `articula-build` matches a skeleton with them. Source: thesis 3.1.3; H-Anim 1.1
//! and 2 (ISO/IEC 19774); the rules are described in `docs/formats/joint-map.md`.

mod builtin;
mod file;
mod humanoid;
mod names;
mod standard;

pub use builtin::builtin;
pub use file::parse;
pub(crate) use humanoid::is_vrm_bone;
pub use humanoid::vrm_bones;
