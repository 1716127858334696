//! Writes a motion at a level of articulation: passive joints keep one constant key, or none.
//!
//! Source: thesis 5.1.2 (the animation optimised for its level is saved and played later);
//! `docs/methods/motion-lod.md` part 2. The root's translation and heading belong to no joint: they
//! are always kept.

use crate::motion_error::keys::central_rotation;
use articula_core::joint_state::PassivePolicy;
use articula_core::source::{Channel, Interpolation, Property, RawClip, evaluate};
use articula_core::{JointSet, Rig, Transform, hold_with_heading};
use glam::{Quat, Vec3};

/// Size of a motion in channels, keys, joints and bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ClipSize {
    /// Number of channels that drive joints.
    pub channels: usize,
    /// Number of keys of these channels.
    pub keys: usize,
    /// Number of joints that have a channel with more than one key.
    pub joints: usize,
    /// Bytes of key times and values as 32-bit floats; identical time arrays count once.
    pub bytes: usize,
}

/// Measures the joint channels of a clip; morph weights and expressions are excluded.
pub fn clip_size(clip: &RawClip) -> ClipSize {
    size_of(clip.channels.iter().filter(|c| c.property.is_of_joint()))
}

/// Measures all channels of a clip, those of morph weights and expressions included.
pub fn whole_clip_size(clip: &RawClip) -> ClipSize {
    size_of(clip.channels.iter())
}

/// Measures channels, those of morph weights and expressions included.
fn size_of<'a>(channels: impl Iterator<Item = &'a Channel>) -> ClipSize {
    let channels: Vec<&Channel> = channels.collect();
    let moving: JointSet = channels
        .iter()
        .filter(|c| c.times_secs.len() > 1 && c.property.is_of_joint())
        .map(|c| c.target)
        .collect();
    let mut times: Vec<&[f32]> = channels.iter().map(|c| c.times_secs.as_slice()).collect();
    times.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    times.dedup();
    let floats = times.iter().map(|t| t.len()).sum::<usize>()
        + channels.iter().map(|c| c.values.len()).sum::<usize>();
    ClipSize {
        channels: channels.len(),
        keys: channels.iter().map(|c| c.times_secs.len()).sum(),
        joints: moving.len(),
        bytes: 4 * floats,
    }
}

/// Returns a clip in which only the joints of `active` move; the others are held as `policy` says.
/// Morph weights and expressions are kept.
///
/// `HoldLast` holds the first frame, since there is none before it.
pub fn hold_joints_in_clip(
    rig: &Rig,
    clip: &RawClip,
    active: &JointSet,
    policy: PassivePolicy,
) -> RawClip {
    let channels = clip
        .channels
        .iter()
        .filter_map(|c| {
            if !c.property.is_of_joint() || active.contains(c.target) {
                return Some(c.clone());
            }
            match c.property {
                // The nodes above the root carry the whole figure, as it does.
                _ if !rig.is_at_or_below(rig.root(), c.target) => {
                    passive(rig, c, policy, clip.duration_secs)
                }
                Property::Translation => Some(c.clone()),
                Property::Rotation => Some(heading(rig, c, policy)),
                _ => passive(rig, c, policy, clip.duration_secs),
            }
        })
        .collect();
    RawClip {
        channels,
        ..clip.clone()
    }
}

/// One channel of a passive joint: a constant, a fade, or nothing where the rest pose is shown
/// anyway.
fn passive(
    rig: &Rig,
    channel: &Channel,
    policy: PassivePolicy,
    duration_secs: f32,
) -> Option<Channel> {
    let rest = floats(rig.rest_pose().get(channel.target), channel.property);
    let held = held(rig, channel, policy);
    let (times_secs, keys) = match policy {
        // A fade never makes a clip longer.
        PassivePolicy::BlendToRest { secs } if secs.min(duration_secs) > 0.0 => {
            (vec![0.0, secs.min(duration_secs)], vec![held, rest])
        }
        PassivePolicy::BlendToRest { .. } | PassivePolicy::Rest => return None,
        _ if held == rest => return None,
        _ => (vec![0.0], vec![held]),
    };
    Some(Channel {
        target: channel.target,
        property: channel.property,
        interpolation: Interpolation::Linear,
        times_secs,
        values: keys.concat(),
    })
}

fn held(rig: &Rig, channel: &Channel, policy: PassivePolicy) -> Vec<f32> {
    let width = width(channel.property);
    let at = |secs: f32| {
        let mut value = vec![0.0; width];
        evaluate::channel(channel, secs, &mut value);
        value
    };
    let keys = || channel.times_secs.iter().map(|t| at(*t));
    match (policy, channel.property) {
        (PassivePolicy::Rest, property) => floats(rig.rest_pose().get(channel.target), property),
        (PassivePolicy::KeyPose, Property::Rotation) => {
            let values: Vec<Quat> = keys().map(|v| Quat::from_slice(&v)).collect();
            let rest = rig.rest_pose().rotations[channel.target];
            central_rotation(&values)
                .unwrap_or(rest)
                .to_array()
                .to_vec()
        }
        (PassivePolicy::KeyPose, _) => {
            // The middle of the range has the smallest maximum error.
            let ends = keys().map(|v| (Vec3::from_slice(&v), Vec3::from_slice(&v)));
            let range = ends.reduce(|(lo, hi), (p, q)| (lo.min(p), hi.max(q)));
            range.map_or_else(|| at(0.0), |(lo, hi)| (0.5 * (lo + hi)).to_array().to_vec())
        }
        _ => at(0.0),
    }
}

/// The root's rotation reduced to its turn about the vertical, on top of the held rotation.
fn heading(rig: &Rig, channel: &Channel, policy: PassivePolicy) -> Channel {
    let hold = Quat::from_slice(&held(rig, channel, policy));
    // Model-from-parent at rest: heading is about the model's vertical, not the parent's.
    let mut above = Quat::IDENTITY;
    let mut at = rig.parent(channel.target);
    while let Some(p) = at {
        above = rig.rest_pose().rotations[p] * above;
        at = rig.parent(p);
    }
    let values = channel.times_secs.iter().flat_map(|t| {
        let mut value = [0.0; 4];
        evaluate::channel(channel, *t, &mut value);
        hold_with_heading(above, Quat::from_array(value), hold).to_array()
    });
    Channel {
        target: channel.target,
        property: Property::Rotation,
        interpolation: match channel.interpolation {
            Interpolation::Step => Interpolation::Step,
            _ => Interpolation::Linear,
        },
        values: values.collect(),
        times_secs: channel.times_secs.clone(),
    }
}

fn width(property: Property) -> usize {
    if property == Property::Rotation { 4 } else { 3 }
}

fn floats(t: Transform, property: Property) -> Vec<f32> {
    match property {
        Property::Rotation => t.rotation.to_array().to_vec(),
        Property::Translation => t.translation.to_array().to_vec(),
        _ => t.scale.to_array().to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::source::{Joint, Skeleton};
    use articula_core::{Articulation, JointArticulation, Region, angle_between};

    fn rig() -> Rig {
        let joint = |name: &str, parent| Joint {
            name: name.into(),
            parent,
            rest: Transform::IDENTITY,
            in_skin: true,
        };
        let skeleton = Skeleton {
            joints: vec![joint("root", None), joint("arm", Some(0))],
        };
        let entry = JointArticulation {
            hanim: None,
            level: 0,
            region: Region::Torso,
        };
        let articulation = Articulation {
            profile: String::new(),
            joints: vec![entry; 2],
        };
        Rig::new(&skeleton, articulation).unwrap()
    }

    fn turning(target: usize, rotations: [Quat; 3]) -> Channel {
        Channel {
            target,
            property: Property::Rotation,
            interpolation: Interpolation::Linear,
            times_secs: vec![0.0, 1.0, 2.0],
            values: rotations.iter().flat_map(|q| q.to_array()).collect(),
        }
    }

    fn clip() -> RawClip {
        let x = Quat::from_rotation_x;
        let tilted = |yaw: f32, tilt: f32| Quat::from_rotation_y(yaw) * x(tilt);
        let way = Channel {
            property: Property::Translation,
            values: vec![0.0, 1.0, 0.0, 0.0, 1.1, 1.0, 0.0, 1.0, 2.0],
            ..turning(0, [Quat::IDENTITY; 3])
        };
        RawClip {
            name: "c".into(),
            duration_secs: 2.0,
            channels: vec![
                turning(0, [tilted(0.0, 0.1), tilted(0.5, 0.2), tilted(1.0, 0.1)]),
                way,
                turning(1, [x(0.2), x(0.6), x(0.4)]),
            ],
        }
    }

    #[test]
    fn a_passive_joint_keeps_one_key_by_its_policy() {
        let root = JointSet::first(1);
        let arm = |policy| {
            let reduced = hold_joints_in_clip(&rig(), &clip(), &root, policy);
            reduced.channels.iter().find(|c| c.target == 1).cloned()
        };
        let angle = |c: &Channel, key: usize| {
            angle_between(Quat::IDENTITY, Quat::from_slice(&c.values[4 * key..]))
        };
        assert!(arm(PassivePolicy::Rest).is_none());
        let hold = arm(PassivePolicy::HoldLast).unwrap();
        assert!(hold.times_secs == [0.0] && (angle(&hold, 0) - 0.2).abs() < 1e-4);
        let key = arm(PassivePolicy::KeyPose).unwrap();
        assert!(
            (angle(&key, 0) - 0.4).abs() < 1e-4,
            "half-way between 0.2 and 0.6"
        );
        let fade = arm(PassivePolicy::BlendToRest { secs: 0.5 }).unwrap();
        assert!(fade.times_secs == [0.0, 0.5] && angle(&fade, 1) < 1e-5);
        let long = arm(PassivePolicy::BlendToRest { secs: 9.0 }).unwrap();
        assert_eq!(long.times_secs, [0.0, 2.0], "the clip keeps its length");
        let before = clip_size(&clip());
        let after = clip_size(&hold_joints_in_clip(
            &rig(),
            &clip(),
            &root,
            PassivePolicy::Rest,
        ));
        assert_eq!((before.channels, before.keys, before.joints), (3, 9, 2));
        // Three times, counted once; 12 + 9 + 12 values, then without the arm's 12.
        assert_eq!((before.bytes, after.bytes), (4 * (3 + 33), 4 * (3 + 21)));
    }

    #[test]
    fn what_carries_the_root_travels_on() {
        let mut skeleton = Skeleton::default();
        for (name, in_skin) in [("armature", false), ("root", true), ("arm", true)] {
            skeleton.joints.push(Joint {
                name: name.into(),
                parent: skeleton.joints.len().checked_sub(1),
                rest: Transform::IDENTITY,
                in_skin,
            });
        }
        let articulation = Articulation {
            profile: String::new(),
            joints: vec![rig().articulation().joints[0].clone(); 3],
        };
        let rig = Rig::new(&skeleton, articulation).unwrap();
        let mut clip = clip();
        clip.channels[1].target = 0;
        let reduced = hold_joints_in_clip(&rig, &clip, &JointSet::EMPTY, PassivePolicy::Rest);
        assert!(reduced.channels.contains(&clip.channels[1]));
    }

    #[test]
    fn a_passive_root_still_travels_and_turns() {
        let reduced =
            hold_joints_in_clip(&rig(), &clip(), &JointSet::EMPTY, PassivePolicy::HoldLast);
        assert_eq!(reduced.channels[1], clip().channels[1], "its way is kept");
        let q = |key: usize| Quat::from_slice(&reduced.channels[0].values[4 * key..]);
        // Held tilt 0.1, heading of the clip.
        let expected = Quat::from_rotation_y(1.0) * Quat::from_rotation_x(0.1);
        assert!(angle_between(q(2), expected) < 1e-3);
        assert!(angle_between(q(0), Quat::from_rotation_x(0.1)) < 1e-3);
    }
}
