//! A plain figure made of rounded limbs, for pictures that need no file.

use articula::core::source::{self, Joint, Skeleton};
use articula::core::{
    Articulation, JointArticulation, Mesh, ModelPose, PosedMesh, Region, Rig, SkinnedMesh,
    Transform,
};
use glam::{Affine3A, Quat, Vec2, Vec3};
use std::f32::consts::TAU;

/// Name, parent, position of the joint and radius of the limb that leads to it.
const JOINTS: [(&str, Option<usize>, [f32; 3], f32); 16] = [
    ("pelvis", None, [0.0, 0.95, 0.0], 0.13),
    ("spine", Some(0), [0.0, 1.25, 0.0], 0.14),
    ("neck", Some(1), [0.0, 1.5, 0.0], 0.07),
    ("head", Some(2), [0.0, 1.68, 0.0], 0.11),
    ("l_shoulder", Some(1), [0.2, 1.42, 0.0], 0.07),
    ("l_elbow", Some(4), [0.42, 1.2, 0.0], 0.05),
    ("l_wrist", Some(5), [0.6, 0.98, 0.05], 0.04),
    ("r_shoulder", Some(1), [-0.2, 1.42, 0.0], 0.07),
    ("r_elbow", Some(7), [-0.42, 1.2, 0.0], 0.05),
    ("r_wrist", Some(8), [-0.6, 0.98, 0.05], 0.04),
    ("l_hip", Some(0), [0.1, 0.9, 0.0], 0.1),
    ("l_knee", Some(10), [0.12, 0.5, 0.02], 0.075),
    ("l_ankle", Some(11), [0.12, 0.06, 0.0], 0.055),
    ("r_hip", Some(0), [-0.1, 0.9, 0.0], 0.1),
    ("r_knee", Some(13), [-0.12, 0.5, 0.02], 0.075),
    ("r_ankle", Some(14), [-0.12, 0.06, 0.0], 0.055),
];

/// The figure with its pose.
pub(crate) struct Figure {
    /// Its joints.
    pub(crate) rig: Rig,
    /// Its limbs, one part each.
    pub(crate) mesh: Mesh,
    /// Joint matrices.
    pub(crate) pose: ModelPose,
    /// Posed surface.
    pub(crate) skinned: SkinnedMesh,
}

/// Builds the figure with one elbow and one knee bent by an angle.
pub(crate) fn bent(radians: f32) -> Figure {
    let skeleton = skeleton();
    let articulation = Articulation {
        profile: String::new(),
        joints: vec![
            JointArticulation {
                hanim: None,
                level: 0,
                region: Region::Torso,
            };
            JOINTS.len()
        ],
    };
    let rig = Rig::new(&skeleton, articulation).unwrap();
    let limbs: Vec<source::RawMesh> = (1..JOINTS.len()).map(limb).collect();
    let mesh = Mesh::new(&limbs, rig.len()).unwrap();
    let mut local = rig.rest_pose().clone();
    local.rotations[5] = Quat::from_rotation_x(-radians);
    local.rotations[14] = Quat::from_rotation_x(radians);
    let mut posed = PosedMesh::new(&rig, &mesh);
    let skinned = posed.pose(&local).skinned(&[]);
    let pose = posed.model;
    Figure {
        rig,
        mesh,
        pose,
        skinned,
    }
}

fn place(joint: usize) -> Vec3 {
    Vec3::from_array(JOINTS[joint].2)
}

fn skeleton() -> Skeleton {
    let joint = |(name, parent, at, _): &(&str, Option<usize>, [f32; 3], f32)| Joint {
        name: (*name).to_owned(),
        parent: *parent,
        rest: Transform::from_translation(Vec3::from_array(*at) - parent.map_or(Vec3::ZERO, place)),
        in_skin: true,
    };
    Skeleton {
        joints: JOINTS.iter().map(joint).collect(),
    }
}

/// A capsule from a joint's parent to the joint, carried by the parent.
fn limb(joint: usize) -> source::RawMesh {
    let (name, parent, _, radius) = JOINTS[joint];
    let parent = parent.unwrap();
    let (from, to) = (place(parent), place(joint));
    let axis = (to - from).normalize();
    let turn = Quat::from_rotation_arc(Vec3::Y, axis);
    let (around, along) = (20u32, 12u32);
    let mut primitive = source::Primitive {
        influences: 1,
        material: Some(joint % 2),
        ..source::Primitive::default()
    };
    for ring in 0..=along {
        let angle = std::f32::consts::PI * (ring as f32 / along as f32 - 0.5);
        let end = if 2 * ring <= along { from } else { to };
        for step in 0..=around {
            let turned = TAU * step as f32 / around as f32;
            let flat = angle.cos();
            let normal = Vec3::new(flat * turned.sin(), angle.sin(), flat * turned.cos());
            primitive.positions.push(end + turn * (normal * radius));
            primitive.normals.push(turn * normal);
            let uv = Vec2::new(step as f32 / around as f32, ring as f32 / along as f32);
            primitive.texcoords.push(uv);
        }
    }
    for ring in 0..along {
        for step in 0..around {
            let a = ring * (around + 1) + step;
            let (b, c, d) = (a + 1, a + around + 2, a + around + 1);
            primitive.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let count = primitive.positions.len();
    primitive.joints = vec![0; count];
    primitive.weights = vec![1.0; count];
    source::RawMesh {
        name: name.to_owned(),
        skin: source::Skin {
            joints: vec![parent],
            inverse_bind: vec![Affine3A::from_translation(-from)],
        },
        primitives: vec![primitive],
        ..source::RawMesh::default()
    }
}
