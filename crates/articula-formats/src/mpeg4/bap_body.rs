//! Conversion of body animation parameters to the standard humanoid in motion.

use super::bap::{BapClip, Motion, TABLE};
use super::bap_table;
use articula_core::LibmQuat;
use articula_core::Transform;
use articula_core::hanim_table::{BODY_JOINTS, JOINTS};
use articula_core::source::{
    Channel, Character, Interpolation, Joint, Property, RawClip, Skeleton,
};
use glam::{DQuat, DVec3, Vec3};

/// Radians per unit of a rotation.
pub(super) const RADIANS: f64 = 1e-5;
/// Metres per unit of a translation.
pub(super) const METRES: f64 = 1e-3;

/// Returns the standard humanoid at rest, without clip or mesh: 89 joints at their centres,
/// unrotated, arms hanging.
pub fn figure() -> Character {
    let joint = |j: &articula_core::hanim_table::HanimJoint| {
        let parent = j.parent.map_or(Vec3::ZERO, |p| JOINTS[p].center);
        Joint {
            name: j.name.to_owned(),
            parent: j.parent,
            rest: Transform::from_translation(j.center - parent),
            in_skin: true,
        }
    };
    Character {
        skeleton: Skeleton {
            joints: JOINTS[..BODY_JOINTS].iter().map(joint).collect(),
        },
        ..Character::default()
    }
}

/// Returns the standard humanoid with the motion as its only clip; frame numbers become times,
/// starting at 0. Extension parameters move nothing.
pub fn character(clip: &BapClip) -> Character {
    let mut character = figure();
    character.name.clone_from(&clip.name);
    let first = clip.frames.first().map_or(0, |frame| frame.number);
    let seconds = |number: u32| (f64::from(number - first) / f64::from(clip.rate_hz)) as f32;
    let times: Vec<f32> = clip.frames.iter().map(|f| seconds(f.number)).collect();
    let Some(duration_secs) = times.last().copied() else {
        return character;
    };
    let moving = clip.moving();
    let channel = |target: usize, property, values| Channel {
        target,
        property,
        interpolation: Interpolation::Linear,
        times_secs: times.clone(),
        values,
    };
    let mut channels = Vec::new();
    for (target, joint) in JOINTS[..BODY_JOINTS].iter().enumerate() {
        let shifts = shifts(joint.name);
        if shifts
            .iter()
            .any(|(index, _)| moving.get(*index) == Some(&true))
        {
            let values = clip.frames.iter().flat_map(|frame| {
                let shift = place(&shifts, &frame.values) + joint.center;
                shift.to_array()
            });
            channels.push(channel(target, Property::Translation, values.collect()));
        }
        let turns = bap_table::turns(joint.name);
        if turns
            .iter()
            .any(|(index, _)| moving.get(*index) == Some(&true))
        {
            let values = clip.frames.iter().flat_map(|frame| {
                let rotation = rotation(&turns, &frame.values);
                rotation.as_quat().normalize().to_array()
            });
            channels.push(channel(target, Property::Rotation, values.collect()));
        }
    }
    let name = if clip.name.is_empty() {
        "bap"
    } else {
        &clip.name
    };
    character.clips.push(RawClip {
        name: name.to_owned(),
        duration_secs,
        channels,
    });
    character
}

/// Returns the parameters that translate a joint; only the root has some.
pub(super) fn shifts(joint: &str) -> Vec<(usize, Vec3)> {
    let of = |(index, bap): (usize, &bap_table::Bap)| match bap.motion {
        Motion::Shift(axis) if bap.joint == joint => Some((index, axis)),
        _ => None,
    };
    TABLE.iter().enumerate().filter_map(of).collect()
}

/// Returns the value of a parameter; 0 if the frame lacks it.
fn value(values: &[i32], index: usize) -> f64 {
    f64::from(values.get(index).copied().unwrap_or(0))
}

/// Returns the product of rotations, from the parent's side.
pub(super) fn rotation(turns: &[(usize, Vec3)], values: &[i32]) -> DQuat {
    turns.iter().fold(DQuat::IDENTITY, |all, (index, axis)| {
        let angle = value(values, *index) * RADIANS;
        all * DQuat::libm_axis_angle(axis.as_dvec3(), angle)
    })
}

/// Returns the sum of translations, in metres.
fn place(shifts: &[(usize, Vec3)], values: &[i32]) -> Vec3 {
    let sum = shifts.iter().fold(DVec3::ZERO, |sum, (index, axis)| {
        sum + axis.as_dvec3() * value(values, *index) * METRES
    });
    sum.as_vec3()
}
