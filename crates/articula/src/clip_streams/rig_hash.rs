//! The hash by which a motion stream knows the character that it was made from.
//!
//! Form: `docs/formats/abp2.md`, parts 2 and 11.

use articula_core::Rig;

/// Returns the hash of a rig for a stream of a version.
pub(super) fn of_version(version: u8, rig: &Rig) -> u64 {
    match version {
        1 => of_version_1(rig),
        _ => rig_hash(rig),
    }
}

/// Returns the hash of a rig as the number that a stream stores, highest byte first.
pub(crate) fn rig_hash(rig: &Rig) -> u64 {
    u64::from_be_bytes(articula_build::rig_hash(rig).to_le_bytes())
}

/// FNV-1a over parent, name and rest pose of each joint.
fn of_version_1(rig: &Rig) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut put = |bytes: &[u8]| {
        for byte in bytes {
            hash = (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    };
    for joint in 0..rig.len() {
        let parent = rig.parent(joint).map_or(u64::MAX, |parent| parent as u64);
        put(&parent.to_le_bytes());
        put(rig.name(joint).as_bytes());
        let rest = rig.rest_pose().get(joint);
        let floats = rest.translation.to_array().into_iter();
        let floats = floats.chain(rest.rotation.to_array());
        for value in floats.chain(rest.scale.to_array()) {
            put(&value.to_le_bytes());
        }
    }
    hash
}
