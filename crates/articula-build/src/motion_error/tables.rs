//! Nested keys of every joint for increasing tolerances, and hashes of the data that they belong
//! to.
//!
//! Source: `docs/methods/motion-lod.md` 4.5 and 9 (`segs`).

use super::bounds::moving_joints;
use super::joint_lever::JointLever;
use super::keys::{hold_keys, linear_keys};
use crate::character::Asset;
use articula_core::{Clip, KeyMode, KeyTable, Mesh, Rig, TableHashes};

/// Tolerance of level 0, the finest.
pub(super) const FINEST_TOLERANCE_METRES: f32 = 0.0005;
/// Number of tolerance levels: 0.5 mm to 256 mm, each twice the one before.
pub(super) const TOLERANCE_LEVELS: usize = 10;

/// Computes the hashes of a rig, a clip and a mesh: FNV-1a over their data, the same on every
/// platform. They detect stale tables; they are no protection against tampering.
pub fn table_hashes(rig: &Rig, clip: &Clip, mesh: &Mesh) -> TableHashes {
    TableHashes {
        rig: rig_hash(rig),
        clip: clip_hash(clip),
        mesh: mesh_hash(mesh),
    }
}

/// Computes keys of all moving joints at every tolerance level, finest first.
pub fn key_table(asset: &Asset, clip: &Clip, levers: &[JointLever], mode: KeyMode) -> KeyTable {
    let moving = moving_joints(asset, clip);
    let mut keys = vec![vec![Vec::new(); TOLERANCE_LEVELS]; asset.rig.len()];
    for track in &clip.tracks().rotations {
        let joint = usize::from(track.target);
        if !moving.contains(joint) {
            continue;
        }
        let mut candidates: Vec<u32> = (0..track.values.len() as u32).collect();
        for (level, slot) in keys[joint].iter_mut().enumerate() {
            let tolerance = FINEST_TOLERANCE_METRES * (1u32 << level) as f32;
            let radians = tolerance / levers[joint].rest_metres;
            candidates = match mode {
                KeyMode::Hold => hold_keys(&track.values, radians, &candidates),
                KeyMode::Linear => linear_keys(&track.values, radians, &candidates),
            };
            slot.clone_from(&candidates);
        }
    }
    KeyTable {
        hashes: table_hashes(&asset.rig, clip, &asset.mesh),
        rate_hz: clip.rate_hz(),
        frames: clip.frames() as u32,
        base_metres: FINEST_TOLERANCE_METRES,
        mode,
        keys,
    }
}

struct Fnv(u64);

impl Fnv {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn bytes(&mut self, bytes: &[u8]) {
        for b in bytes {
            self.0 = (self.0 ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn number(&mut self, value: u64) {
        self.bytes(&value.to_le_bytes());
    }

    fn floats(&mut self, values: &[f32]) {
        for v in values {
            self.bytes(&v.to_bits().to_le_bytes());
        }
    }
}

/// Computes the hash of a rig: the tree of its joints, their names and rest poses.
pub fn rig_hash(rig: &Rig) -> u64 {
    let mut h = Fnv::new();
    for j in 0..rig.len() {
        h.number(rig.parent(j).map_or(u64::MAX, |p| p as u64));
        h.bytes(rig.name(j).as_bytes());
        let rest = rig.rest_pose().get(j);
        h.floats(&rest.translation.to_array());
        h.floats(&rest.rotation.to_array());
        h.floats(&rest.scale.to_array());
    }
    h.0
}

fn clip_hash(clip: &Clip) -> u64 {
    let mut h = Fnv::new();
    h.floats(&[clip.rate_hz()]);
    h.number(clip.frames() as u64);
    for track in &clip.tracks().rotations {
        h.number(u64::from(track.target));
        track.values.iter().for_each(|q| h.floats(&q.to_array()));
    }
    for track in clip
        .tracks()
        .translations
        .iter()
        .chain(&clip.tracks().scales)
    {
        h.number(u64::from(track.target));
        track.values.iter().for_each(|v| h.floats(&v.to_array()));
    }
    h.0
}

fn mesh_hash(mesh: &Mesh) -> u64 {
    let mut h = Fnv::new();
    h.number(mesh.len() as u64);
    mesh.positions.iter().for_each(|p| h.floats(&p.to_array()));
    mesh.binding_indices
        .iter()
        .for_each(|b| h.bytes(&b.to_le_bytes()));
    h.floats(&mesh.weights);
    h.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint_lods::test_figures::{arm, moving};
    use crate::motion_error::levers::levers;
    use glam::{Quat, Vec3};
    use std::sync::Arc;

    #[test]
    fn tolerances_double_from_half_a_millimetre() {
        let asset = arm(2);
        let angles = [0.0, 0.0008, 0.0038, 0.1038];
        let clip = moving(2, 1, &angles.map(Quat::from_rotation_z));
        let mut levers = levers(&asset.rig, &asset.mesh);
        for (rest_metres, finer) in [(1.0, 0), (2.0, 1)] {
            levers[1].rest_metres = rest_metres;
            let table = key_table(&asset, &clip, &levers, KeyMode::Hold);
            assert_eq!((table.rate_hz, table.frames), (30.0, 4));
            assert_eq!((table.base_metres, table.mode), (0.0005, KeyMode::Hold));
            assert!(table.keys[0].iter().all(Vec::is_empty), "the root");
            for (level, keys) in table.keys[1].iter().enumerate() {
                // At a lever of one metre: 0.5, 1, 2, 4 … 128 and 256 mrad.
                let expected: &[u32] = match level as i32 - finer {
                    -1..=0 => &[0, 1, 2, 3],
                    1..=2 => &[0, 2, 3],
                    3..=7 => &[0, 3],
                    _ => &[0],
                };
                assert_eq!(keys, expected, "level {level}");
            }
        }
        // Between two keys a steady turn needs none.
        let clip = moving(2, 1, &[0.0, 0.1, 0.2, 0.3].map(Quat::from_rotation_z));
        let table = key_table(&asset, &clip, &levers, KeyMode::Linear);
        assert!(table.keys[1].iter().all(|keys| keys == &[0, 3]));
    }

    #[test]
    fn hashes_are_fnv_1a_and_change_with_the_data() {
        // Published by its authors.
        let hash = |bytes: &[u8]| {
            let mut h = Fnv::new();
            h.bytes(bytes);
            h.0
        };
        assert_eq!(hash(b"a"), 0xaf63_dc4c_8601_ec8c);
        assert_eq!(hash(b"foobar"), 0x8594_4171_f739_67e8);
        let asset = arm(2);
        let clip = moving(2, 1, &[Quat::IDENTITY; 2]);
        let of = |asset: &Asset, clip: &Clip| table_hashes(&asset.rig, clip, &asset.mesh);
        let first = of(&asset, &clip);
        assert_eq!(first, of(&arm(2), &clip));
        assert_ne!(first.rig, of(&arm(3), &clip).rig);
        let turned = [Quat::IDENTITY, Quat::from_rotation_x(0.1)];
        for other in [
            moving(2, 1, &turned),
            moving(2, 1, &[Quat::IDENTITY; 3]),
            moving(2, 0, &[Quat::IDENTITY; 2]),
        ] {
            assert_ne!(first.clip, of(&asset, &other).clip);
        }
        for change in [
            |mesh: &mut Mesh| mesh.positions[3] += Vec3::X,
            |mesh: &mut Mesh| mesh.binding_indices[3] = 1,
            |mesh: &mut Mesh| mesh.weights[3] = 0.125,
        ] {
            let mut other = arm(2);
            change(Arc::make_mut(&mut other.mesh));
            assert_ne!(first.mesh, of(&other, &clip).mesh);
        }
    }
}
