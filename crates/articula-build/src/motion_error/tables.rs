//! Nested keys of every joint for increasing tolerances, and hashes of the data that they belong
//! to.
//!
//! Source: `docs/methods/motion-lod.md` 4.5 and 9 (`segs`).

use super::bounds::moving_joints;
use super::joint_lever::JointLever;
use super::keys::{hold_keys, linear_keys};
use crate::character::Asset;
use crate::source_hash::{SourceHash, rig_hash};
use articula_core::{Clip, KeyMode, KeyTable, Mesh, Rig, TableHashes};

/// Tolerance of level 0, the finest.
pub(super) const FINEST_TOLERANCE_METRES: f32 = 0.0005;
/// Number of tolerance levels: 0.5 mm to 256 mm, each twice the one before.
pub(super) const TOLERANCE_LEVELS: usize = 10;

/// Computes the hashes of a rig, a clip and a mesh, by which stored tables know what they belong to.
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

fn clip_hash(clip: &Clip) -> u64 {
    let mut hash = SourceHash::default();
    hash.floats([clip.rate_hz()].into_iter());
    hash.number(clip.frames());
    let tracks = clip.tracks();
    for track in &tracks.rotations {
        hash.number(usize::from(track.target));
        hash.vectors(track.values.iter().map(|q| q.to_array()));
    }
    for track in tracks.translations.iter().chain(&tracks.scales) {
        hash.number(usize::from(track.target));
        hash.vectors(track.values.iter().map(|v| v.to_array()));
    }
    hash.finish()
}

fn mesh_hash(mesh: &Mesh) -> u64 {
    let mut hash = SourceHash::default();
    hash.vectors(mesh.positions.iter().map(|p| p.to_array()));
    hash.indices(mesh.binding_indices.iter().map(|b| u32::from(*b)));
    hash.floats(mesh.weights.iter().copied());
    hash.finish()
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
    fn hashes_change_with_the_data() {
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
