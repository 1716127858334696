//! Joints in H-Anim terms: all unrotated in the zero pose, each rotating about its center.
//!
//! With `B` a joint's model matrix in that pose and `G` at some time, its H-Anim matrix is `P = G ·
//! B⁻¹`, which moves every point given in that pose. For a joint with local transform `T · R · S`,
//! in the zero pose `T0 · R0 · S0`, below a parent with `B = b · O` (scale and orientation), the
//! fields are
//!
//! - `center` = position of the joint in the zero pose,
//! - `translation` = `b · O · (T - T0)`,
//! - `rotation` = `O · R · R0⁻¹ · O⁻¹`,
//! - `scale` = `S / S0`, with `scaleOrientation` = `O · R0`.
//!
//! Keys are kept, since all four are linear in the local values. Exact as long as no joint of the
//! pose scales its children non-uniformly; then `O` is the nearest orientation.

use super::super::names::Names;
use super::zero::{ZeroPose, zero_pose};
use crate::error::Warning;
use crate::x3d::placement::Similarity;
use articula_core::hanim_table;
use articula_core::source::{Character, Property};
use articula_core::{Articulation, Transform};
use glam::{DAffine3, DMat3, DQuat, DVec3, Quat, Vec3};
use std::collections::HashSet;

/// A joint to be written.
#[derive(Debug)]
pub(super) struct Bone {
    /// Nearest ancestor that is written.
    pub(super) parent: Option<usize>,
    pub(super) name: String,
    /// Name in the skeleton.
    pub(super) given_name: String,
    /// Position in the zero pose.
    pub(super) center: Vec3,
    /// The parent's model matrix in that pose, and its orientation.
    above: DAffine3,
    orientation: DQuat,
    zero: Local,
    /// Local transform at rest.
    rest: Transform,
    /// Whether no ancestor scales it non-uniformly in the zero pose.
    is_even: bool,
    /// Whether a clip, or the rest pose, scales it non-uniformly.
    pub(super) is_stretched: bool,
}

/// A decomposed local transform.
#[derive(Debug, Clone, Copy)]
struct Local {
    translation: DVec3,
    rotation: DQuat,
    scale: DVec3,
}

impl Local {
    /// Decomposes a matrix so that axes are mirrored as they are at rest.
    fn of(matrix: &DAffine3, rest: &Transform) -> Self {
        let m = matrix.matrix3;
        let lengths = DVec3::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length());
        let scale = lengths * rest.scale.as_dvec3().signum();
        let turned = m * DMat3::from_diagonal(scale).inverse();
        let rotation = if turned.is_finite() && turned.determinant() > 0.0 {
            DQuat::from_mat3(&turned).normalize()
        } else {
            rest.rotation.as_dquat().normalize()
        };
        Self {
            translation: matrix.translation,
            rotation,
            scale,
        }
    }
}

impl Bone {
    /// Returns the joint's fields at rest: translation, rotation, scale.
    pub(super) fn rest(&self) -> (Vec3, DQuat, Vec3) {
        let rest = &self.rest;
        (
            self.translation(rest.translation),
            self.rotation(rest.rotation.normalize()),
            self.scale(rest.scale),
        )
    }

    /// Returns the field `translation` for a local translation.
    pub(super) fn translation(&self, local: Vec3) -> Vec3 {
        let moved = local.as_dvec3() - self.zero.translation;
        self.above.transform_vector3(moved).as_vec3()
    }

    /// Returns the field `rotation` for a local rotation, as a quaternion.
    pub(super) fn rotation(&self, local: Quat) -> DQuat {
        let turned = local.as_dquat() * self.zero.rotation.inverse();
        (self.orientation * turned * self.orientation.inverse()).normalize()
    }

    /// Returns the field `scale` for a local scale.
    pub(super) fn scale(&self, local: Vec3) -> Vec3 {
        let by = |axis: usize| {
            let zero = self.zero.scale[axis];
            if zero == 0.0 {
                1.0
            } else {
                f64::from(local[axis]) / zero
            }
        };
        DVec3::new(by(0), by(1), by(2)).as_vec3()
    }

    /// Returns the field `scaleOrientation`.
    pub(super) fn scale_orientation(&self) -> DQuat {
        (self.orientation * self.zero.rotation).normalize()
    }
}

/// The joints that are written, parents before children, and the bone index of each joint of the
/// skeleton.
#[derive(Debug)]
pub(super) struct Bones {
    pub(super) list: Vec<Bone>,
    pub(super) of_joint: Vec<Option<usize>>,
    pub(super) zero: ZeroPose,
}

/// Selects and names the joints. A joint that never moves, moves nothing and is in no skin is left
/// out, such as the node that holds an armature.
pub(super) fn bones(
    character: &Character,
    articulation: &Articulation,
    names: &mut Names,
    warnings: &mut Vec<Warning>,
) -> Bones {
    let joints = &character.skeleton.joints;
    let mut moving = vec![false; joints.len()];
    for channel in character.clips.iter().flat_map(|c| &c.channels) {
        if channel.property.is_of_joint() {
            moving[channel.target] = true;
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
        zero: zero_pose(character),
    };
    let mut uneven = 0;
    for (index, joint) in joints.iter().enumerate() {
        let hanim = articulation.joints[index].hanim.as_deref();
        let wanted = joint.in_skin || moving[index] || used.contains(&index) || hanim.is_some();
        let parent = joint.parent.and_then(|p| bones.of_joint[p]);
        if !wanted {
            // Children look up the ancestor that is written.
            bones.of_joint[index] = parent;
            continue;
        }
        let wish = hanim.map_or(joint.name.as_str(), standard_name);
        let bone = bones.bone(character, index, (parent, names.give(wish, "joint")));
        uneven += usize::from(!bone.is_even && moving[index]);
        bones.of_joint[index] = Some(bones.list.len());
        bones.list.push(bone);
    }
    mark_stretched(character, &mut bones);
    if uneven > 0 {
        let what = format!(
            "{uneven} animated joints are below joints with a non-uniform scale; their rotations \
             are approximate"
        );
        warnings.push(Warning::new("skeleton", what));
    }
    bones
}

/// Returns the H-Anim 2 name of a joint of either version.
fn standard_name(hanim: &str) -> &str {
    hanim_table::find(hanim).map_or(hanim, |i| hanim_table::JOINTS[i].name_v2)
}

impl Bones {
    fn bone(&self, character: &Character, index: usize, own: (Option<usize>, String)) -> Bone {
        let joint = &character.skeleton.joints[index];
        let zero = self.zero.matrices[index];
        let above = joint
            .parent
            .map_or(DAffine3::IDENTITY, |p| self.zero.matrices[p]);
        let mut upright = above;
        if above.matrix3.determinant() < 0.0 {
            upright.matrix3 *= -1.0;
        }
        let even = Similarity::of(&upright);
        let local = match self.zero.is_binding {
            true => Local::of(&(above.inverse() * zero), &joint.rest),
            // Taken over exactly, so that no field is written where nothing differs.
            false => Local {
                translation: joint.rest.translation.as_dvec3(),
                rotation: joint.rest.rotation.as_dquat().normalize(),
                scale: joint.rest.scale.as_dvec3(),
            },
        };
        Bone {
            parent: own.0,
            name: own.1,
            given_name: joint.name.clone(),
            center: zero.translation.as_vec3(),
            is_even: even.is_some(),
            orientation: even.unwrap_or_else(|| Similarity::near(&upright)).rotation,
            above,
            zero: local,
            rest: joint.rest,
            is_stretched: false,
        }
    }
}

/// Marks the joints that are ever scaled non-uniformly.
fn mark_stretched(character: &Character, bones: &mut Bones) {
    let uneven = |scale: Vec3| {
        let [x, y, z] = scale.to_array();
        (x - y).abs() > 1e-5 || (y - z).abs() > 1e-5
    };
    for bone in &mut bones.list {
        bone.is_stretched = uneven(bone.rest().2);
    }
    for channel in character.clips.iter().flat_map(|c| &c.channels) {
        if channel.property == Property::Scale
            && let Some(bone) = bones.of_joint[channel.target]
        {
            let bone = &mut bones.list[bone];
            let (keys, _) = channel.values.as_chunks::<3>();
            bone.is_stretched |= keys
                .iter()
                .any(|k| uneven(bone.scale(Vec3::from_array(*k))));
        }
    }
}
