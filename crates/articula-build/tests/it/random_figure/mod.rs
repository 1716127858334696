//! Figures with random joints, skin and motion.
#![allow(
    dead_code,
    clippy::unwrap_used,
    reason = "each test file uses a part of it, and a test may panic"
)]

use articula_core::source::{
    Channel, Character, Interpolation, Joint, Primitive, Property, RawClip, RawMesh, Skeleton, Skin,
};
use articula_core::{
    Articulation, JointArticulation, ModelPose, Region, Transform, local_to_model,
};
use glam::{Quat, Vec3};
use proptest::prelude::*;

pub(crate) const RATE: f32 = 30.0;
pub(crate) const FRAMES: usize = 24;

pub(crate) fn vector(size: f32) -> impl Strategy<Value = Vec3> {
    (-size..size, -size..size, -size..size).prop_map(|(x, y, z)| Vec3::new(x, y, z))
}

pub(crate) fn rotation(size: f32) -> impl Strategy<Value = Quat> {
    vector(size).prop_map(Quat::from_scaled_axis)
}

/// (parent choice, offset, rest rotation, rotation per frame) of a joint.
pub(crate) type Row = (f32, Vec3, Quat, Vec3);

pub(crate) fn rows() -> impl Strategy<Value = Vec<Row>> {
    prop::collection::vec(
        (0.0f32..1.0, vector(0.4), rotation(1.5), vector(0.12)),
        2..9,
    )
}

fn parents(rows: &[Row]) -> Vec<Option<usize>> {
    rows.iter()
        .enumerate()
        .map(|(j, r)| (j > 0).then(|| ((r.0 * j as f32) as usize).min(j - 1)))
        .collect()
}

/// A mesh whose vertices are each bound to one, two or three neighbouring joints.
fn skinned(rows: &[Row], skeleton: &Skeleton) -> RawMesh {
    let count = rows.len();
    let articulation = flat(count);
    let rig = articula_core::Rig::new(skeleton, articulation).unwrap();
    let mut model = ModelPose::new(count);
    local_to_model(&rig, rig.rest_pose(), &mut model);
    let mut primitive = Primitive {
        influences: 3,
        ..Primitive::default()
    };
    for v in 0..30 {
        let joint = v % count;
        let offset = Vec3::new(
            (v as f32).sin(),
            (1.7 * v as f32).cos(),
            (2.9 * v as f32).sin(),
        ) * 0.3;
        primitive.positions.push(model.position(joint) + offset);
        let parent = rig.parent(joint).unwrap_or(0);
        primitive
            .joints
            .extend([joint as u16, parent as u16, ((joint + 1) % count) as u16]);
        let w = 0.4 + 0.6 * (v as f32 * 0.37).fract();
        primitive
            .weights
            .extend([w, (1.0 - w) * 0.75, (1.0 - w) * 0.25]);
    }
    primitive.triangles = (0..10).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    RawMesh {
        name: "skin".into(),
        skin: Skin {
            joints: (0..count).collect(),
            inverse_bind: model.matrices.iter().map(|m| m.inverse()).collect(),
        },
        primitives: vec![primitive],
        ..RawMesh::default()
    }
}

pub(crate) fn flat(joints: usize) -> Articulation {
    let entry = JointArticulation {
        hanim: None,
        level: 0,
        region: Region::Torso,
    };
    Articulation {
        profile: String::new(),
        joints: vec![entry; joints],
    }
}

/// The figure described by `rows`, with skin and one clip in which every joint rotates.
pub(crate) fn character_of(rows: &[Row]) -> Character {
    let skeleton = Skeleton {
        joints: rows
            .iter()
            .zip(parents(rows))
            .enumerate()
            .map(|(j, (row, parent))| Joint {
                name: format!("j{j}"),
                parent,
                rest: Transform {
                    translation: row.1,
                    rotation: row.2,
                    scale: Vec3::ONE,
                },
                in_skin: true,
            })
            .collect(),
    };
    let times: Vec<f32> = (0..FRAMES).map(|i| i as f32 / RATE).collect();
    let channels = rows.iter().enumerate().map(|(j, row)| Channel {
        target: j,
        property: Property::Rotation,
        interpolation: Interpolation::Linear,
        times_secs: times.clone(),
        values: (0..FRAMES)
            .flat_map(|i| {
                (row.2 * Quat::from_scaled_axis(row.3 * (0.4 * i as f32).sin() * 6.0)).to_array()
            })
            .collect(),
    });
    let clip = RawClip {
        name: "random".into(),
        duration_secs: times[FRAMES - 1],
        channels: channels.collect(),
    };
    Character {
        meshes: vec![skinned(rows, &skeleton)],
        skeleton,
        clips: vec![clip],
        ..Character::default()
    }
}
