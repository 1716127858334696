//! Contacts: intervals in which a foot or hand stands still, where an error shows as sliding.
//!
//! Source: `docs/methods/motion-lod.md` 4.6. `articula-build` finds them, assets store them.

use crate::key_table::TableHashes;
use std::ops::Range;

/// One contact of one joint.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Contact {
    /// The foot or hand joint.
    pub joint: usize,
    /// Frames of the clip during which it stands still; not empty.
    pub frames: Range<usize>,
}

/// Contacts in one clip.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactTable {
    /// Hashes of the rig, clip and mesh for which the table was made.
    pub hashes: TableHashes,
    /// Frames per second of the table: the rate of the clip's keys.
    pub rate_hz: f32,
    /// Number of frames at this rate.
    pub frames: u32,
    /// The contacts, joint by joint.
    pub contacts: Vec<Contact>,
}
