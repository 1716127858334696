//! The hash by which a motion stream knows the character that it was made from.
//!
//! Form: `docs/formats/abp2.md`, part 2.

use articula_core::Rig;

/// Returns the hash of a rig for a stream of a version.
pub(super) fn of_version(version: u8, rig: &Rig) -> u64 {
    match version {
        1 => articula_build::rig_hash(rig),
        _ => rig_hash(rig),
    }
}

/// Returns the first 8 bytes of BLAKE3 over parent, name and rest pose of each joint, as a number whose
/// highest byte comes first.
pub(crate) fn rig_hash(rig: &Rig) -> u64 {
    let mut hasher = blake3::Hasher::new();
    for joint in 0..rig.len() {
        let parent = rig.parent(joint).map_or(u64::MAX, |parent| parent as u64);
        hasher.update(&parent.to_le_bytes());
        hasher.update(rig.name(joint).as_bytes());
        let rest = rig.rest_pose().get(joint);
        let floats = rest.translation.to_array().into_iter();
        let floats = floats.chain(rest.rotation.to_array());
        for value in floats.chain(rest.scale.to_array()) {
            hasher.update(&value.to_le_bytes());
        }
    }
    let [a, b, c, d, e, f, g, h, ..] = *hasher.finalize().as_bytes();
    u64::from_be_bytes([a, b, c, d, e, f, g, h])
}
