//! Hashes of what prepared data is computed from.
//!
//! They tell whether stored data belongs to the skeleton, meshes and clips beside it; they are no
//! protection against tampering.

use articula_build::SourceHash;
use articula_core::Articulation;
use articula_core::source::{
    Channel, Character, Interpolation, Primitive, Property, RawClip, RawMesh, Skeleton, Skin,
};
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

fn rig(skeleton: &Skeleton, articulation: &Articulation) -> u64 {
    let mut hash = SourceHash::default();
    hash.number(skeleton.joints.len());
    for joint in &skeleton.joints {
        hash.text(&joint.name);
        hash.index(joint.parent);
        hash.transform(&joint.rest);
        hash.number(usize::from(joint.in_skin));
    }
    for joint in &articulation.joints {
        hash.text(joint.hanim.as_deref().unwrap_or(""));
        hash.number(usize::from(joint.level));
        hash.number(joint.region as usize);
    }
    hash.finish()
}

fn meshes(meshes: &[RawMesh]) -> u64 {
    let mut hash = SourceHash::default();
    hash.number(meshes.len());
    for mesh in meshes {
        hash.text(&mesh.name);
        skin(&mut hash, &mesh.skin);
        hash.floats(mesh.morph_weights.iter().copied());
        hash.number(mesh.primitives.len());
        mesh.primitives.iter().for_each(|p| primitive(&mut hash, p));
    }
    hash.finish()
}

/// Hash of the coarser levels that meshes store.
pub(crate) fn mesh_levels(meshes: &[RawMesh]) -> u64 {
    let mut hash = SourceHash::default();
    for object in meshes.iter().flat_map(|m| &m.clustered) {
        hash.indices(object.triangles.as_flattened().iter().copied());
        for cluster in object.clusters.clusters() {
            hash.number(usize::from(cluster.finest_level));
            hash.number(usize::from(cluster.coarsest_level));
            hash.number(cluster.triangles.end as usize);
        }
    }
    hash.finish()
}

fn skin(hash: &mut SourceHash, skin: &Skin) {
    hash.indices(skin.joints.iter().map(|j| *j as u32));
    let columns = |m: &Affine3A| m.to_cols_array();
    hash.vectors(skin.inverse_bind.iter().map(columns));
}

fn primitive(hash: &mut SourceHash, primitive: &Primitive) {
    hash.vectors(primitive.positions.iter().map(|p| p.to_array()));
    hash.vectors(primitive.normals.iter().map(|n| n.to_array()));
    hash.number(primitive.influences);
    hash.indices(primitive.joints.iter().map(|j| u32::from(*j)));
    hash.floats(primitive.weights.iter().copied());
    for target in &primitive.morphs {
        hash.vectors(target.positions.iter().map(|p| p.to_array()));
        hash.vectors(target.normals.iter().map(|n| n.to_array()));
    }
    hash.indices(primitive.triangles.as_flattened().iter().copied());
}

fn clips(clips: &[RawClip]) -> u64 {
    let mut hash = SourceHash::default();
    hash.number(clips.len());
    for clip in clips {
        hash.text(&clip.name);
        hash.floats([clip.duration_secs].into_iter());
        hash.number(clip.channels.len());
        clip.channels.iter().for_each(|c| channel(&mut hash, c));
    }
    hash.finish()
}

fn channel(hash: &mut SourceHash, channel: &Channel) {
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
    hash.number(channel.target);
    hash.number(property + 8 * interpolation);
    hash.floats(channel.times_secs.iter().copied());
    hash.floats(channel.values.iter().copied());
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::Transform;
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
