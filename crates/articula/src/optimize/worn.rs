//! The points at which errors of a file of motion alone are measured: the skin of another character, or points around
//! its joints.

use crate::error::{Error, Result};
use articula_core::source::{Character, Primitive, RawMesh, Skeleton, Skin};
use glam::{Affine3A, Vec3};
use serde::Serialize;

/// Distance of the points around a joint from it, in metres: half a bone, within these limits.
const LEAST_METRES: f32 = 0.03;
const MOST_METRES: f32 = 0.15;

/// What the errors of an optimised file are those of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MeasuredOn {
    /// The vertices of the file's own meshes.
    Meshes,
    /// The vertices of another character ([`OptimizeOptions::skin`](super::OptimizeOptions::skin)).
    Skin {
        /// Number of joints of that skin.
        joints: usize,
        /// How many of them the file lacks by name; they stay at rest in the nearest joint above.
        joints_missing: usize,
    },
    /// Three points around each joint, half a bone away.
    Joints,
}

/// A skeleton with what is measured on it.
pub(super) struct Worn {
    pub(super) character: Character,
    pub(super) measured_on: MeasuredOn,
}

impl Worn {
    /// The skin of a character, or points around the joints without one.
    pub(super) fn on(skeleton: &Skeleton, skin: Option<&Character>) -> Result<Self> {
        let (meshes, measured_on) = match skin {
            Some(skin) => skin_of(skin, skeleton)?,
            None => (vec![points_around(skeleton)], MeasuredOn::Joints),
        };
        let character = Character {
            skeleton: skeleton.clone(),
            meshes,
            ..Character::default()
        };
        Ok(Self {
            character,
            measured_on,
        })
    }

    /// The same on the joints of a file that was written.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if it has other joints.
    pub(super) fn on_same_joints(&self, skeleton: &Skeleton) -> Result<Self> {
        let names = |of: &Skeleton| -> Vec<String> {
            of.joints.iter().map(|joint| joint.name.clone()).collect()
        };
        if names(skeleton) != names(&self.character.skeleton) {
            return Err(Error::unsuited(
                "the written file has other joints than its source",
            ));
        }
        Ok(Self {
            character: Character {
                skeleton: skeleton.clone(),
                meshes: self.character.meshes.clone(),
                ..Character::default()
            },
            measured_on: self.measured_on,
        })
    }
}

/// The meshes of a character, at the joints of the same names.
fn skin_of(skin: &Character, skeleton: &Skeleton) -> Result<(Vec<RawMesh>, MeasuredOn)> {
    let own = &skin.skeleton.joints;
    let rest = skin.skeleton.model_rest();
    let found: Vec<Option<usize>> = own.iter().map(|j| skeleton.find(&j.name)).collect();
    let mut is_used = vec![false; own.len()];
    for joint in skin.meshes.iter().flat_map(|mesh| &mesh.skin.joints) {
        is_used[*joint] = true;
    }
    let used = || (0..own.len()).filter(|joint| is_used[*joint]);
    let measured_on = MeasuredOn::Skin {
        joints: used().count(),
        joints_missing: used().filter(|joint| found[*joint].is_none()).count(),
    };
    if used().all(|joint| found[joint].is_none()) {
        let what = match used().next() {
            Some(_) => "skin: no joint of the skin has the name of a joint of the file",
            None => "skin: the character has no mesh",
        };
        return Err(Error::unsuited(what));
    }
    // The joint of the file that a joint follows, and its place in that joint's space at rest.
    let first = skeleton.model_rest().first().map(Affine3A::inverse);
    let follows = |joint: usize| {
        let parent = |joint: &usize| own[*joint].parent.filter(|parent| parent < joint);
        let mut above = std::iter::successors(Some(joint), parent);
        match above.find_map(|above| Some((above, found[above]?))) {
            Some((above, to)) if above == joint => (to, Affine3A::IDENTITY),
            Some((above, to)) => (to, rest[above].inverse() * rest[joint]),
            None => (0, first.unwrap_or_default() * rest[joint]),
        }
    };
    let worn = |mesh: &RawMesh| {
        let joints = mesh.skin.joints.iter().zip(&mesh.skin.inverse_bind);
        let (joints, inverse_bind) = joints
            .map(|(joint, bind)| {
                let (to, place) = follows(*joint);
                (to, place * *bind)
            })
            .unzip();
        let still = |primitive: &Primitive| Primitive {
            morphs: Vec::new(),
            ..primitive.clone()
        };
        RawMesh {
            name: mesh.name.clone(),
            skin: Skin {
                joints,
                inverse_bind,
            },
            primitives: mesh.primitives.iter().map(still).collect(),
            ..RawMesh::default()
        }
    };
    Ok((skin.meshes.iter().map(worn).collect(), measured_on))
}

/// Three points around each joint, so that turns of joints at the ends of limbs show too.
fn points_around(skeleton: &Skeleton) -> RawMesh {
    let rest = skeleton.model_rest();
    let place = |joint: usize| Vec3::from(rest[joint].translation);
    let mut longest = vec![0.0f32; rest.len()];
    for (joint, of) in skeleton.joints.iter().enumerate() {
        let Some(parent) = of.parent.filter(|parent| *parent < joint) else {
            continue;
        };
        let metres = place(joint).distance(place(parent));
        longest[joint] = longest[joint].max(metres);
        longest[parent] = longest[parent].max(metres);
    }
    let mut points = Primitive {
        influences: 1,
        ..Primitive::default()
    };
    for (joint, metres) in longest.iter().enumerate() {
        let away = (0.5 * metres).clamp(LEAST_METRES, MOST_METRES);
        for axis in Vec3::AXES {
            points.positions.push(place(joint) + away * axis);
            points.joints.push(joint as u16);
            points.weights.push(1.0);
        }
    }
    RawMesh {
        name: "joints".to_owned(),
        skin: Skin {
            joints: (0..rest.len()).collect(),
            inverse_bind: rest.iter().map(Affine3A::inverse).collect(),
        },
        primitives: vec![points],
        ..RawMesh::default()
    }
}
