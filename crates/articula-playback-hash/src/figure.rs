//! A figure of twenty joints, made by additions, multiplications and square roots alone, which give
//! the same bits everywhere.

use articula_core::crowd::{RootDelta, RootTrajectory};
use articula_core::source::{Joint, MorphTarget, Primitive, RawMesh, Skeleton, Skin};
use articula_core::{
    Articulation, Clip, JointArticulation, KeyMode, KeyTable, Mesh, Mismatch, Region, Rig,
    TableHashes, Track, Tracks, Transform,
};
use glam::{Affine3A, Quat, Vec3};

const JOINTS: usize = 20;
const FRAMES: usize = 61;

/// A triangle wave between -1 and 1 with a period of 60 frames, the same at both ends of a clip.
fn wave(frame: usize, speed: usize, shift: usize) -> f32 {
    let at = (frame * speed + shift) % 60;
    (at as f32 - 30.0).abs() / 15.0 - 1.0
}

fn turn(x: f32, y: f32, z: f32) -> Quat {
    let length = (x * x + y * y + z * z + 1.0).sqrt();
    Quat::from_xyzw(x / length, y / length, z / length, 1.0 / length)
}

pub(crate) fn rig() -> Result<Rig, Mismatch> {
    let joint = |j: usize| Joint {
        name: format!("j{j}"),
        parent: (j > 0).then(|| if j % 4 == 1 { 0 } else { j - 1 }),
        rest: Transform {
            translation: Vec3::new(0.1 * (j % 5) as f32 - 0.2, 0.25, 0.05 * (j % 3) as f32),
            rotation: turn(0.1 * (j % 3) as f32, -0.2, 0.05 * j as f32),
            scale: Vec3::ONE,
        },
        in_skin: true,
    };
    let skeleton = Skeleton {
        joints: (0..JOINTS).map(joint).collect(),
    };
    let known = JointArticulation {
        hanim: None,
        level: 0,
        region: Region::Torso,
    };
    let articulation = Articulation {
        profile: String::new(),
        joints: vec![known; JOINTS],
    };
    Rig::new(&skeleton, articulation)
}

pub(crate) fn clips() -> Result<Vec<Clip>, Mismatch> {
    let clip = |c: usize| {
        let rotation = |j: usize| Track {
            target: j as u16,
            step: false,
            values: (0..FRAMES)
                .map(|i| {
                    let [x, y] = [wave(i, 1 + (j + c) % 3, j), wave(i, 1 + j % 2, 3 * j + c)];
                    turn(0.3 * x, 0.2 * y, 0.1 * x * y)
                })
                .collect(),
        };
        let translation = Track {
            target: 0,
            step: false,
            values: (0..FRAMES)
                .map(|i| Vec3::new(0.1 * wave(i, 2, 0), 0.9, 0.1 * wave(i, 1, 15)))
                .collect(),
        };
        let morph = Track {
            target: 0,
            step: false,
            values: (0..FRAMES).map(|i| wave(i, 1 + c, 7)).collect(),
        };
        let tracks = Tracks {
            rotations: (0..JOINTS).map(rotation).collect(),
            translations: vec![translation],
            morphs: vec![morph],
            ..Tracks::default()
        };
        Clip::new(format!("clip {c}"), 30.0, FRAMES, JOINTS, tracks)
    };
    (0..2).map(clip).collect()
}

/// Straight ahead: a turn would need a sine, which platforms round differently.
pub(crate) fn paths() -> Result<Vec<Option<RootTrajectory>>, Mismatch> {
    let place = |i: usize| RootDelta {
        offset: Vec3::Z * (0.03 * i as f32),
        yaw_radians: 0.0,
    };
    let path = RootTrajectory::new(30.0, (0..FRAMES).map(place).collect())?;
    Ok(vec![Some(path), None])
}

pub(crate) fn mesh() -> Result<Mesh, Mismatch> {
    let corner = |v: usize| {
        Vec3::new(
            0.1 * (v % 7) as f32,
            0.05 * v as f32,
            0.02 * (v % 11) as f32,
        )
    };
    let vertices = 3 * JOINTS;
    let joints = (0..vertices).flat_map(|v| [(v / 3) as u16, ((v / 3 + 1) % JOINTS) as u16]);
    let moved = MorphTarget {
        positions: (0..vertices)
            .map(|v| Vec3::Y * (0.01 * (v % 2) as f32))
            .collect(),
        normals: vec![],
    };
    let mesh = RawMesh {
        name: "skin".into(),
        skin: Skin {
            joints: (0..JOINTS).collect(),
            inverse_bind: (0..JOINTS)
                .map(|j| Affine3A::from_translation(Vec3::NEG_Y * (0.25 * j as f32)))
                .collect(),
        },
        primitives: vec![Primitive {
            positions: (0..vertices).map(corner).collect(),
            normals: vec![Vec3::Z; vertices],
            influences: 2,
            joints: joints.collect(),
            weights: [0.75, 0.25].repeat(vertices),
            triangles: (0..JOINTS as u32)
                .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
                .collect(),
            morphs: vec![moved],
            ..Primitive::default()
        }],
        morph_weights: vec![0.0],
        ..RawMesh::default()
    };
    Mesh::new(&[mesh], JOINTS)
}

/// Nested keys at two tolerances, held in the first clip and blended in the second.
pub(crate) fn tables(clips: &[Clip]) -> Vec<KeyTable> {
    let keys = |every: usize| (0..FRAMES as u32).step_by(every).collect::<Vec<u32>>();
    let table = |(c, clip): (usize, &Clip)| KeyTable {
        hashes: TableHashes::default(),
        rate_hz: clip.rate_hz(),
        frames: clip.frames() as u32,
        base_metres: 0.002,
        mode: if c == 0 {
            KeyMode::Hold
        } else {
            KeyMode::Linear
        },
        keys: vec![vec![keys(3), keys(6)]; JOINTS],
    };
    clips.iter().enumerate().map(table).collect()
}
