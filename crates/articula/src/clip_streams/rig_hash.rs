//! The hash by which a motion stream knows the character that it was made from.
//!
//! Form: `docs/formats/abp2.md`, parts 2 and 11.

use crate::old_hashes;
use articula_core::Rig;

/// Returns the hash of a rig for a stream of a version.
pub(super) fn of_version(version: u8, rig: &Rig) -> u64 {
    match version {
        1 => old_hashes::rig_hash(rig),
        _ => rig_hash(rig),
    }
}

/// Returns the hash of a rig as the number that a stream stores, highest byte first.
pub(crate) fn rig_hash(rig: &Rig) -> u64 {
    u64::from_be_bytes(articula_build::rig_hash(rig).to_le_bytes())
}
