//! Hashes of what prepared data is computed from.
//!
//! They tell whether stored data belongs to the skeleton, meshes and clips beside it; they are no
//! protection against tampering.

use articula_core::source::{
    Channel, Character, Interpolation, Primitive, Property, RawClip, RawMesh, Skeleton, Skin,
};
use articula_core::{Articulation, Transform};
use glam::Affine3A;

/// Hashes of a character's skeleton, meshes and clips.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SourceHashes {
    pub(crate) rig: u64,
    pub(crate) mesh: u64,
    pub(crate) clips: u64,
}

impl SourceHashes {
    pub(crate) fn of(character: &Character, articulation: &Articulation) -> Self {
        Self {
            rig: rig(&character.skeleton, articulation),
            mesh: meshes(&character.meshes),
            clips: clips(&character.clips),
        }
    }

    /// The hashes with their names in the file.
    pub(crate) fn named(&self) -> [(&'static str, u64); 3] {
        [
            ("rig", self.rig),
            ("mesh", self.mesh),
            ("clips", self.clips),
        ]
    }
}

/// Hash of the bytes of a part: the first 64 bits of BLAKE3.
pub(crate) fn bytes(bytes: &[u8]) -> u64 {
    first_bits(&blake3::hash(bytes))
}

fn first_bits(hash: &blake3::Hash) -> u64 {
    let [a, b, c, d, e, f, g, h, ..] = *hash.as_bytes();
    u64::from_le_bytes([a, b, c, d, e, f, g, h])
}

/// Collects numbers, so that the hash sees long runs of bytes.
#[derive(Default)]
struct Sum {
    bytes: Vec<u8>,
    hasher: blake3::Hasher,
}

impl Sum {
    const RUN: usize = 1 << 15;

    fn flush(&mut self) {
        self.hasher.update(&self.bytes);
        self.bytes.clear();
    }

    fn number(&mut self, value: usize) {
        self.bytes.extend((value as u64).to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.number(text.len());
        self.bytes.extend(text.as_bytes());
    }

    fn floats(&mut self, values: impl ExactSizeIterator<Item = f32>) {
        self.number(values.len());
        for value in values {
            self.bytes.extend(value.to_le_bytes());
            if self.bytes.len() >= Self::RUN {
                self.flush();
            }
        }
    }

    fn vectors<const N: usize>(&mut self, values: impl ExactSizeIterator<Item = [f32; N]>) {
        self.number(values.len());
        for value in values {
            for x in value {
                self.bytes.extend(x.to_le_bytes());
            }
            if self.bytes.len() >= Self::RUN {
                self.flush();
            }
        }
    }

    fn indices(&mut self, values: impl ExactSizeIterator<Item = u32>) {
        self.number(values.len());
        for value in values {
            self.bytes.extend(value.to_le_bytes());
            if self.bytes.len() >= Self::RUN {
                self.flush();
            }
        }
    }

    fn transform(&mut self, t: &Transform) {
        self.floats(t.translation.to_array().into_iter());
        self.floats(t.rotation.to_array().into_iter());
        self.floats(t.scale.to_array().into_iter());
    }

    fn done(mut self) -> u64 {
        self.flush();
        first_bits(&self.hasher.finalize())
    }
}

fn rig(skeleton: &Skeleton, articulation: &Articulation) -> u64 {
    let mut sum = Sum::default();
    sum.number(skeleton.joints.len());
    for joint in &skeleton.joints {
        sum.text(&joint.name);
        sum.number(joint.parent.map_or(usize::MAX, |p| p));
        sum.transform(&joint.rest);
        sum.number(usize::from(joint.in_skin));
    }
    for joint in &articulation.joints {
        sum.text(joint.hanim.as_deref().unwrap_or(""));
        sum.number(usize::from(joint.level));
        sum.number(joint.region as usize);
    }
    sum.done()
}

fn meshes(meshes: &[RawMesh]) -> u64 {
    let mut sum = Sum::default();
    sum.number(meshes.len());
    for mesh in meshes {
        sum.text(&mesh.name);
        skin(&mut sum, &mesh.skin);
        sum.floats(mesh.morph_weights.iter().copied());
        sum.number(mesh.primitives.len());
        mesh.primitives.iter().for_each(|p| primitive(&mut sum, p));
    }
    sum.done()
}

/// Hash of the coarser levels that meshes store.
pub(crate) fn mesh_levels(meshes: &[RawMesh]) -> u64 {
    let mut sum = Sum::default();
    for object in meshes.iter().flat_map(|m| &m.clustered) {
        sum.indices(object.triangles.as_flattened().iter().copied());
        for cluster in object.clusters.clusters() {
            sum.number(usize::from(cluster.finest_level));
            sum.number(usize::from(cluster.coarsest_level));
            sum.number(cluster.triangles.end as usize);
        }
    }
    sum.done()
}

fn skin(sum: &mut Sum, skin: &Skin) {
    sum.indices(skin.joints.iter().map(|j| *j as u32));
    let columns = |m: &Affine3A| m.to_cols_array();
    sum.vectors(skin.inverse_bind.iter().map(columns));
}

fn primitive(sum: &mut Sum, primitive: &Primitive) {
    sum.vectors(primitive.positions.iter().map(|p| p.to_array()));
    sum.vectors(primitive.normals.iter().map(|n| n.to_array()));
    sum.number(primitive.influences);
    sum.indices(primitive.joints.iter().map(|j| u32::from(*j)));
    sum.floats(primitive.weights.iter().copied());
    for target in &primitive.morphs {
        sum.vectors(target.positions.iter().map(|p| p.to_array()));
        sum.vectors(target.normals.iter().map(|n| n.to_array()));
    }
    sum.indices(primitive.triangles.as_flattened().iter().copied());
}

fn clips(clips: &[RawClip]) -> u64 {
    let mut sum = Sum::default();
    sum.number(clips.len());
    for clip in clips {
        sum.text(&clip.name);
        sum.floats([clip.duration_secs].into_iter());
        sum.number(clip.channels.len());
        clip.channels.iter().for_each(|c| channel(&mut sum, c));
    }
    sum.done()
}

fn channel(sum: &mut Sum, channel: &Channel) {
    let property = match channel.property {
        Property::Translation => 0,
        Property::Rotation => 1,
        Property::Scale => 2,
        Property::Weights => 3,
        Property::Expression => 4,
    };
    let interpolation = match channel.interpolation {
        Interpolation::Linear => 0,
        Interpolation::Step => 1,
        Interpolation::CubicSpline => 2,
    };
    sum.number(channel.target);
    sum.number(property + 8 * interpolation);
    sum.floats(channel.times_secs.iter().copied());
    sum.floats(channel.values.iter().copied());
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::source::Joint;

    fn character() -> Character {
        let channel = Channel {
            target: 0,
            property: Property::Rotation,
            interpolation: Interpolation::Linear,
            times_secs: vec![0.0],
            values: vec![0.0, 0.0, 0.0, 1.0],
        };
        Character {
            skeleton: Skeleton {
                joints: vec![Joint {
                    name: "hips".into(),
                    parent: None,
                    rest: Transform::IDENTITY,
                    in_skin: true,
                }],
            },
            meshes: vec![RawMesh {
                primitives: vec![Primitive {
                    positions: vec![glam::Vec3::ONE; 3],
                    triangles: vec![[0, 1, 2]],
                    ..Primitive::default()
                }],
                ..RawMesh::default()
            }],
            clips: vec![RawClip {
                channels: vec![channel],
                ..RawClip::default()
            }],
            ..Character::default()
        }
    }

    #[test]
    fn each_hash_sees_its_own_part_and_no_other() {
        let none = Articulation::default();
        let whole = SourceHashes::of(&character(), &none);
        let mut other = character();
        other.skeleton.joints[0].rest.translation.x = 1e-7;
        let found = SourceHashes::of(&other, &none);
        assert_ne!(found.rig, whole.rig);
        assert_eq!((found.mesh, found.clips), (whole.mesh, whole.clips));
        let mut other = character();
        other.meshes[0].primitives[0].triangles[0] = [0, 2, 1];
        let found = SourceHashes::of(&other, &none);
        assert_ne!(found.mesh, whole.mesh);
        assert_eq!((found.rig, found.clips), (whole.rig, whole.clips));
        let mut other = character();
        other.clips[0].channels[0].values[3] = -1.0;
        let found = SourceHashes::of(&other, &none);
        assert_ne!(found.clips, whole.clips);
        assert_eq!((found.rig, found.mesh), (whole.rig, whole.mesh));
        // Materials do not count: they may be edited without a new preparation.
        let mut other = character();
        other.meshes[0].primitives[0].material = Some(4);
        assert_eq!(SourceHashes::of(&other, &none), whole);
    }
}
