//! Small figures for tests.

use crate::character::Asset;
use articula_core::source::{Joint, Skeleton};
use articula_core::{
    Articulation, Binding, Clip, JointArticulation, Mesh, Region, Rig, Track, Tracks, Transform,
};
use glam::{Affine3A, Quat, Vec3};

/// A rig of joints, each 1 m above its parent.
pub(crate) fn rig(parents: &[Option<usize>]) -> Rig {
    rig_with(parents, &vec![None; parents.len()])
}

/// A rig of joints, each 1 m above its parent, with H-Anim names.
pub(crate) fn rig_with(parents: &[Option<usize>], names: &[Option<&str>]) -> Rig {
    let joint = |(j, parent): (usize, &Option<usize>)| Joint {
        name: format!("j{j}"),
        parent: *parent,
        rest: Transform::from_translation(if parent.is_some() {
            Vec3::Y
        } else {
            Vec3::ZERO
        }),
        in_skin: true,
    };
    let entry = |name: &Option<&str>| JointArticulation {
        hanim: name.map(str::to_owned),
        level: 0,
        region: Region::Torso,
    };
    let articulation = Articulation {
        profile: String::new(),
        joints: names.iter().map(entry).collect(),
    };
    let joints = parents.iter().enumerate().map(joint).collect();
    Rig::new(&Skeleton { joints }, articulation).unwrap()
}

/// A figure with a square tube of skin around the bone of each joint: four vertices at the joint,
/// shared with its parent, and four half a metre above, on the joint alone.
pub(crate) fn figure(parents: &[Option<usize>]) -> Asset {
    let rig = rig(parents);
    let mut mesh = Mesh {
        influences: 2,
        ..Mesh::default()
    };
    let mut heights = vec![0.0; parents.len()];
    for (j, parent) in parents.iter().enumerate() {
        heights[j] = parent.map_or(0.0, |p| heights[p] + 1.0);
        mesh.bindings.push(Binding {
            joint: j as u16,
            inverse_bind: Affine3A::from_translation(-Vec3::Y * heights[j]),
        });
        for (up, weight) in [(0.0, 0.5), (0.5, 1.0)] {
            for (x, z) in [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)] {
                let side = Vec3::new(x, 0.0, z) * 0.1;
                mesh.positions.push(side + Vec3::Y * (heights[j] + up));
                mesh.normals.push(side.normalize());
                let other = parent.unwrap_or(j);
                mesh.binding_indices.extend([j as u16, other as u16]);
                mesh.weights.extend([weight, 1.0 - weight]);
            }
        }
    }
    let count = mesh.positions.len();
    mesh.texcoords = vec![glam::Vec2::ZERO; count];
    mesh.colors = vec![glam::Vec4::ONE; count];
    Asset {
        rig: rig.into(),
        mesh: mesh.into(),
        clips: Vec::new(),
    }
}

/// A chain of joints.
pub(crate) fn arm(joints: usize) -> Asset {
    let parents: Vec<Option<usize>> = (0..joints).map(|j| j.checked_sub(1)).collect();
    figure(&parents)
}

/// A clip at 30 Hz that rotates one joint.
pub(crate) fn moving(joints: usize, joint: usize, rotations: &[Quat]) -> Clip {
    let tracks = Tracks {
        rotations: vec![Track {
            target: joint as u16,
            step: false,
            values: rotations.to_vec(),
        }],
        ..Tracks::default()
    };
    Clip::new(format!("j{joint}"), 30.0, rotations.len(), joints, tracks).unwrap()
}
