//! Joints in the terms of H-Anim: at rest all unturned, each turning about its center.
//!
//! With `B` a joint's model matrix at rest and `G` at some time, its H-Anim matrix is
//! `P = G · B⁻¹`: the identity at rest, and what moves every point that is given as it lies at
//! rest. Of a joint with local transform `T · R · S`, at rest `T0 · R0 · S0`, below a parent
//! with `B = b · O` (scale and orientation), the fields are
//!
//! - `center` = where the joint lies at rest,
//! - `translation` = `b · O · (T - T0)`,
//! - `rotation` = `O · R · R0⁻¹ · O⁻¹`,
//! - `scale` = `S / S0`, with `scaleOrientation` = `O · R0`.
//!
//! Keys stay keys: all four are linear in the local values. Exact as long as no joint at rest
//! stretches its children unevenly; then `O` is the nearest orientation.

use super::names::Names;
use crate::error::Warning;
use crate::x3d::placement::Similarity;
use articula_core::articulation::Articulation;
use articula_core::hanim_table;
use articula_core::source::{Character, Property};
use glam::{DAffine3, DQuat, DVec3, Quat, Vec3};
use std::collections::HashSet;

/// A joint as it is written.
#[derive(Debug)]
pub(super) struct Bone {
    /// Nearest ancestor that is written.
    pub(super) parent: Option<usize>,
    pub(super) name: String,
    /// Name in the skeleton.
    pub(super) given_name: String,
    /// Model matrix at rest.
    pub(super) rest: DAffine3,
    /// Linear part of the parent's model matrix at rest, and its orientation.
    above: DAffine3,
    orientation: DQuat,
    rest_translation: DVec3,
    rest_rotation: DQuat,
    rest_scale: DVec3,
    /// Whether a clip stretches it unevenly.
    pub(super) is_stretched: bool,
}

impl Bone {
    pub(super) fn center(&self) -> Vec3 {
        self.rest.translation.as_vec3()
    }

    /// The field `translation` for a local translation.
    pub(super) fn translation(&self, local: Vec3) -> Vec3 {
        let moved = local.as_dvec3() - self.rest_translation;
        self.above.transform_vector3(moved).as_vec3()
    }

    /// The field `rotation` for a local rotation, as a quaternion.
    pub(super) fn rotation(&self, local: Quat) -> DQuat {
        let turned = local.as_dquat() * self.rest_rotation.inverse();
        (self.orientation * turned * self.orientation.inverse()).normalize()
    }

    /// The field `scale` for a local scale.
    pub(super) fn scale(&self, local: Vec3) -> Vec3 {
        let by = |axis: usize| {
            let rest = self.rest_scale[axis];
            if rest == 0.0 {
                1.0
            } else {
                f64::from(local[axis]) / rest
            }
        };
        DVec3::new(by(0), by(1), by(2)).as_vec3()
    }

    /// The field `scaleOrientation`.
    pub(super) fn scale_orientation(&self) -> DQuat {
        (self.orientation * self.rest_rotation).normalize()
    }
}

/// The joints that are written, parents before children, and their number for each joint of the
/// skeleton.
#[derive(Debug)]
pub(super) struct Bones {
    pub(super) list: Vec<Bone>,
    pub(super) of_joint: Vec<Option<usize>>,
    /// Model matrix at rest of every joint of the skeleton.
    pub(super) rest: Vec<DAffine3>,
}

/// Chooses and names the joints. What never moves, moves nothing and is no joint of a skin is
/// left out, such as the node that holds an armature.
pub(super) fn bones(
    character: &Character,
    articulation: &Articulation,
    names: &mut Names,
    warnings: &mut Vec<Warning>,
) -> Bones {
    let joints = &character.skeleton.joints;
    let rest = rest_matrices(character);
    let mut moving = vec![false; joints.len()];
    let mut stretched = vec![false; joints.len()];
    for channel in character.clips.iter().flat_map(|c| &c.channels) {
        if channel.property.is_of_joint() {
            moving[channel.target] = true;
        }
        if channel.property == Property::Scale {
            let (keys, _) = channel.values.as_chunks::<3>();
            let rest = joints[channel.target].rest.scale;
            let even = |k: &[f32; 3]| {
                let [x, y, z] = (Vec3::from_array(*k) / rest).to_array();
                (x - y).abs() < 1e-5 && (y - z).abs() < 1e-5
            };
            stretched[channel.target] |= !keys.iter().all(even);
        }
    }
    let used: HashSet<usize> = character
        .meshes
        .iter()
        .flat_map(|m| m.skin.joints.iter().copied())
        .collect();
    let mut bones = Bones {
        list: Vec::new(),
        of_joint: vec![None; joints.len()],
        rest,
    };
    let mut uneven = 0;
    for (index, joint) in joints.iter().enumerate() {
        let hanim = articulation.joints[index].hanim.as_deref();
        let wanted = joint.in_skin || moving[index] || used.contains(&index) || hanim.is_some();
        let parent = joint.parent;
        if !wanted {
            // Children find the ancestor that is written.
            bones.of_joint[index] = parent.and_then(|p| bones.of_joint[p]);
            continue;
        }
        let above = parent.map_or(DAffine3::IDENTITY, |p| bones.rest[p]);
        let mut mirrored = above;
        if above.matrix3.determinant() < 0.0 {
            mirrored.matrix3 *= -1.0;
        }
        let even = Similarity::of(&mirrored);
        uneven += usize::from(even.is_none() && moving[index]);
        let orientation = even.unwrap_or_else(|| Similarity::near(&mirrored)).rotation;
        let standard = hanim.map(standard_name).unwrap_or_default();
        let wish = if standard.is_empty() {
            &joint.name
        } else {
            standard
        };
        bones.list.push(Bone {
            parent: parent.and_then(|p| bones.of_joint[p]),
            name: names.give(wish, "joint"),
            given_name: joint.name.clone(),
            rest: bones.rest[index],
            above,
            orientation,
            rest_translation: joint.rest.translation.as_dvec3(),
            rest_rotation: joint.rest.rotation.as_dquat().normalize(),
            rest_scale: joint.rest.scale.as_dvec3(),
            is_stretched: stretched[index],
        });
        bones.of_joint[index] = Some(bones.list.len() - 1);
    }
    if uneven > 0 {
        let what = format!(
            "{uneven} moving joints hang below joints that are stretched at rest; their turns are nearly those of the source"
        );
        warnings.push(Warning::new("skeleton", what));
    }
    bones
}

/// The name of H-Anim 2 for a joint of either version.
fn standard_name(hanim: &str) -> &str {
    hanim_table::find(hanim).map_or(hanim, |i| hanim_table::JOINTS[i].name_v2)
}

fn rest_matrices(character: &Character) -> Vec<DAffine3> {
    let mut matrices: Vec<DAffine3> = Vec::new();
    for joint in &character.skeleton.joints {
        let local = DAffine3::from_scale_rotation_translation(
            joint.rest.scale.as_dvec3(),
            joint.rest.rotation.as_dquat().normalize(),
            joint.rest.translation.as_dvec3(),
        );
        matrices.push(joint.parent.map_or(local, |p| matrices[p] * local));
    }
    matrices
}
