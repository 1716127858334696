//! A made-up figure of seven joints, whose numbers are all known: two meshes that bind one joint by
//! different matrices, two clips, a morph target, no scale.

use articula_build::Asset;
use articula_core::source::{Joint, MorphTarget, Primitive, RawMesh, Skeleton, Skin};
use articula_core::{
    Articulation, Clip, JointArticulation, Mesh, ModelPose, Region, Rig, Track, Tracks, Transform,
    local_to_model,
};
use glam::{Affine3A, Quat, Vec2, Vec3};

/// Name, parent and offset of each joint.
const JOINTS: [(&str, Option<usize>, Vec3); 7] = [
    ("hips", None, Vec3::new(0.0, 1.0, 0.0)),
    ("spine", Some(0), Vec3::new(0.0, 0.25, 0.05)),
    ("head", Some(1), Vec3::new(0.0, 0.5, 0.0)),
    ("arm", Some(1), Vec3::new(0.25, 0.25, 0.0)),
    ("hand", Some(3), Vec3::new(0.5, -0.125, 0.0)),
    ("leg", Some(0), Vec3::new(0.125, -0.125, 0.0)),
    ("foot", Some(5), Vec3::new(0.0, -0.75, 0.1)),
];

/// Joints that level 1 keeps.
pub(crate) const KEPT: [&str; 3] = ["hips", "spine", "head"];

/// The figure and the skins of its meshes.
pub(crate) struct Figure {
    pub(crate) asset: Asset,
    pub(crate) skins: Vec<Skin>,
}

pub(crate) fn figure() -> Figure {
    let rig = rig();
    let mut rest = ModelPose::new(rig.len());
    local_to_model(&rig, rig.rest_pose(), &mut rest);
    let body = Skin {
        // Another order than that of the rig, as files have it.
        joints: vec![6, 0, 2, 1, 5, 3, 4],
        inverse_bind: [6, 0, 2, 1, 5, 3, 4]
            .map(|j: usize| rest.matrices[j].inverse())
            .to_vec(),
    };
    // A hat in a space of its own, turned and away from the head.
    let worn =
        Affine3A::from_rotation_translation(Quat::from_rotation_x(0.5), Vec3::new(0.0, 2.0, 1.0));
    let hat = Skin {
        joints: vec![2],
        inverse_bind: vec![rest.matrices[2].inverse() * worn],
    };
    let meshes = [
        body_mesh(&rest, body.clone()),
        hat_mesh(&rest, worn, hat.clone()),
    ];
    let mesh = Mesh::new(&meshes, rig.len()).unwrap();
    Figure {
        asset: Asset {
            clips: vec![walk(), wave()],
            mesh: mesh.into(),
            rig: rig.into(),
        },
        skins: vec![body, hat],
    }
}

fn rig() -> Rig {
    let joints = JOINTS.map(|(name, parent, translation)| Joint {
        name: name.to_owned(),
        parent,
        rest: Transform {
            translation,
            ..Transform::IDENTITY
        },
        in_skin: true,
    });
    let of = JointArticulation {
        hanim: None,
        level: 0,
        region: Region::Torso,
    };
    let articulation = Articulation {
        profile: String::new(),
        joints: vec![of; JOINTS.len()],
    };
    let skeleton = Skeleton {
        joints: joints.to_vec(),
    };
    Rig::new(&skeleton, articulation).unwrap()
}

/// A triangle around each joint, two of its corners shared with the parent.
fn body_mesh(rest: &ModelPose, skin: Skin) -> RawMesh {
    let mut made = Primitive {
        influences: 2,
        ..Primitive::default()
    };
    for (slot, &joint) in skin.joints.iter().enumerate() {
        let parent = JOINTS[joint].1.unwrap_or(joint);
        let above = skin.joints.iter().position(|j| *j == parent).unwrap();
        for (i, offset) in [Vec3::Y, Vec3::Z, Vec3::X].into_iter().enumerate() {
            made.positions.push(rest.position(joint) + offset * 0.1);
            made.normals.push(offset);
            made.texcoords
                .push(Vec2::new(slot as f32 / 8.0, i as f32 / 2.0));
            made.joints.extend([slot as u16, above as u16]);
            let own = 1.0 - 0.25 * i as f32;
            made.weights.extend([own, 1.0 - own]);
        }
        let first = 3 * slot as u32;
        made.triangles.push([first, first + 1, first + 2]);
    }
    RawMesh {
        name: "body".into(),
        skin,
        primitives: vec![made],
        ..RawMesh::default()
    }
}

/// One triangle on the head, with a morph target that raises a corner.
fn hat_mesh(rest: &ModelPose, worn: Affine3A, skin: Skin) -> RawMesh {
    let head = rest.position(2);
    let corners =
        [Vec3::Y, Vec3::Z, Vec3::X].map(|v| worn.inverse().transform_point3(head + v * 0.125));
    let made = Primitive {
        positions: corners.to_vec(),
        normals: vec![Vec3::Y; 3],
        texcoords: vec![Vec2::ZERO; 3],
        influences: 1,
        joints: vec![0; 3],
        weights: vec![1.0; 3],
        morphs: vec![MorphTarget {
            positions: vec![Vec3::ZERO, Vec3::Y * 0.03, Vec3::ZERO],
            normals: Vec::new(),
        }],
        triangles: vec![[0, 1, 2]],
        material: Some(0),
        ..Primitive::default()
    };
    RawMesh {
        name: "hat".into(),
        skin,
        primitives: vec![made],
        morph_names: vec!["raised".into()],
        morph_weights: vec![0.25],
        ..RawMesh::default()
    }
}

fn turns(target: u16, axis: Vec3, radians: &[f32]) -> Track<Quat> {
    Track {
        target,
        step: false,
        values: radians
            .iter()
            .map(|a| Quat::from_axis_angle(axis, *a))
            .collect(),
    }
}

/// A second at 8 Hz.
fn walk() -> Clip {
    let swing = [0.0, 0.4, 0.6, 0.4, 0.0, -0.4, -0.6, -0.4, 0.0];
    let tracks = Tracks {
        rotations: vec![
            turns(0, Vec3::Y, &swing.map(|a| 0.3 * a)),
            turns(1, Vec3::new(0.6, 0.0, 0.8), &swing.map(|a| 0.5 * a)),
            turns(3, Vec3::X, &swing.map(|a| 1.5 * a)),
            turns(4, Vec3::Z, &swing),
            turns(5, Vec3::X, &swing.map(|a| -a)),
            turns(6, Vec3::X, &swing.map(|a| 0.5 * a.abs())),
        ],
        translations: vec![Track {
            target: 0,
            step: false,
            values: swing
                .map(|a| Vec3::new(0.1 * a, 1.0 + 0.05 * a.abs(), 0.0))
                .to_vec(),
        }],
        ..Tracks::default()
    };
    Clip::new("walk", 8.0, 9, JOINTS.len(), tracks).unwrap()
}

/// Half a second at 8 Hz.
fn wave() -> Clip {
    let up = [0.0, 0.8, 1.6, 0.8, 0.0];
    let tracks = Tracks {
        rotations: vec![
            turns(2, Vec3::Y, &up.map(|a| 0.25 * a)),
            turns(3, Vec3::Z, &up),
            turns(4, Vec3::Y, &up.map(|a| -0.5 * a)),
        ],
        morphs: vec![Track {
            target: 0,
            step: false,
            values: up.map(|a| a / 2.0).to_vec(),
        }],
        ..Tracks::default()
    };
    Clip::new("wave", 8.0, 5, JOINTS.len(), tracks).unwrap()
}
