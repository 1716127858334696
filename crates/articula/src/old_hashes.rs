//! Hashes of files that were written before BLAKE3 took the place of FNV-1a: motion tables, and motion
//! streams of version 1 (`docs/formats/motion-tables.md`, `docs/formats/abp2.md` part 11). They are
//! read and no longer written.

use articula_core::{Clip, Mesh, Rig, TableHashes};

/// Hashes of a rig, a clip and a mesh as old motion tables have them.
pub(crate) fn table_hashes(rig: &Rig, clip: &Clip, mesh: &Mesh) -> TableHashes {
    TableHashes {
        rig: rig_hash(rig),
        clip: clip_hash(clip),
        mesh: mesh_hash(mesh),
    }
}

/// Hash of parent, name and rest pose of each joint.
pub(crate) fn rig_hash(rig: &Rig) -> u64 {
    let mut hash = Fnv::default();
    for joint in 0..rig.len() {
        let parent = rig.parent(joint).map_or(u64::MAX, |parent| parent as u64);
        hash.bytes(&parent.to_le_bytes());
        hash.bytes(rig.name(joint).as_bytes());
        let rest = rig.rest_pose().get(joint);
        hash.floats(&rest.translation.to_array());
        hash.floats(&rest.rotation.to_array());
        hash.floats(&rest.scale.to_array());
    }
    hash.0
}

fn clip_hash(clip: &Clip) -> u64 {
    let mut hash = Fnv::default();
    hash.floats(&[clip.rate_hz()]);
    hash.number(clip.frames());
    let tracks = clip.tracks();
    for track in &tracks.rotations {
        hash.number(usize::from(track.target));
        track.values.iter().for_each(|q| hash.floats(&q.to_array()));
    }
    for track in tracks.translations.iter().chain(&tracks.scales) {
        hash.number(usize::from(track.target));
        track.values.iter().for_each(|v| hash.floats(&v.to_array()));
    }
    hash.0
}

fn mesh_hash(mesh: &Mesh) -> u64 {
    let mut hash = Fnv::default();
    hash.number(mesh.len());
    mesh.positions
        .iter()
        .for_each(|p| hash.floats(&p.to_array()));
    mesh.binding_indices
        .iter()
        .for_each(|b| hash.bytes(&b.to_le_bytes()));
    hash.floats(&mesh.weights);
    hash.0
}

/// The 64-bit hash FNV-1a (Fowler, Noll and Vo).
struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv {
    fn bytes(&mut self, bytes: &[u8]) {
        for b in bytes {
            self.0 = (self.0 ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn number(&mut self, value: usize) {
        self.bytes(&(value as u64).to_le_bytes());
    }

    fn floats(&mut self, values: &[f32]) {
        values.iter().for_each(|v| self.bytes(&v.to_le_bytes()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_vectors() {
        for (text, expected) in [
            ("a", 0xaf63_dc4c_8601_ec8c),
            ("foobar", 0x8594_4171_f739_67e8),
        ] {
            let mut hash = Fnv::default();
            hash.bytes(text.as_bytes());
            assert_eq!(hash.0, expected);
        }
    }
}
