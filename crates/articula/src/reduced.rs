//! A clip with some joints held: what a level of articulation leaves of the stored animation.
//!
//! Source: thesis 5.1.2, `spec/motion-lod.md` part 2. A passive joint keeps one key, or none
//! where it rests. Differs: the root and the nodes above it always follow the clip, and a
//! channel that never changes is cut to one key although its joint is active.

use articula_build::motion_error::keys::central_rotation;
use articula_core::loa::JointSet;
use articula_core::math::{Transform, nlerp};
use articula_core::rig::Rig;
use articula_core::source::{Channel, Clip, Interpolation, Property, evaluate};
use glam::{Quat, Vec3};
use serde::Serialize;
use std::collections::BTreeSet;
use std::ops::AddAssign;

/// What a joint shows while it is passive from the first frame on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Passive {
    /// What the clip shows at its start.
    Hold,
    /// The rest pose; nothing is stored.
    Rest,
    /// The value with the smallest greatest distance to all frames.
    KeyPose,
    /// From the clip's start to the rest pose within so many seconds.
    BlendToRest(f32),
}

impl Passive {
    /// The policy as the command line spells it.
    pub(crate) fn name(self) -> String {
        match self {
            Self::Hold => "hold".into(),
            Self::Rest => "rest".into(),
            Self::KeyPose => "key-pose".into(),
            Self::BlendToRest(secs) => format!("blend-to-rest:{secs}"),
        }
    }
}

/// Reads `hold`, `rest`, `key-pose` or `blend-to-rest:SECS`.
pub(crate) fn passive(text: &str) -> Result<Passive, String> {
    let wrong = || "expected hold, rest, key-pose or blend-to-rest:SECS".to_owned();
    match text.split_once(':') {
        None => match text {
            "hold" => Ok(Passive::Hold),
            "rest" => Ok(Passive::Rest),
            "key-pose" => Ok(Passive::KeyPose),
            _ => Err(wrong()),
        },
        Some(("blend-to-rest", secs)) => {
            let secs = secs.parse::<f32>().ok();
            let secs = secs.filter(|s| s.is_finite() && *s > 0.0);
            secs.map(Passive::BlendToRest).ok_or_else(wrong)
        }
        Some(_) => Err(wrong()),
    }
}

/// How much animation there is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub(crate) struct Amount {
    /// Joints with a channel that changes.
    pub(crate) joints_animated: usize,
    pub(crate) channels: usize,
    pub(crate) keys: usize,
    /// Times and values of all keys as 32-bit floats.
    pub(crate) animation_bytes: usize,
}

impl Amount {
    /// What a clip holds.
    pub(crate) fn of(clip: &Clip) -> Self {
        let channels = clip.channels.iter();
        let floats = channels.map(|c| c.times_secs.len() + c.values.len());
        let moving = clip
            .channels
            .iter()
            .filter(|c| c.property != Property::Weights && !is_constant(c));
        Self {
            joints_animated: moving.map(|c| c.target).collect::<BTreeSet<_>>().len(),
            channels: clip.channels.len(),
            keys: clip.channels.iter().map(|c| c.times_secs.len()).sum(),
            animation_bytes: 4 * floats.sum::<usize>(),
        }
    }
}

impl AddAssign for Amount {
    fn add_assign(&mut self, other: Self) {
        self.joints_animated += other.joints_animated;
        self.channels += other.channels;
        self.keys += other.keys;
        self.animation_bytes += other.animation_bytes;
    }
}

/// The clip with every joint that is not `active` held as the policy says.
pub(crate) fn reduced(clip: &Clip, rig: &Rig, active: &JointSet, policy: Passive) -> Clip {
    let held = |joint: usize| {
        let follows = !rig.skin_joints().contains(joint) || joint == rig.root();
        !follows && !active.contains(joint)
    };
    let channels = clip.channels.iter().filter_map(|channel| {
        if channel.property == Property::Weights {
            return Some(channel.clone());
        }
        let rest = rig.rest_pose().get(channel.target);
        if held(channel.target) {
            hold(channel, clip.duration_secs, rest, policy)
        } else {
            shortened(channel, rest)
        }
    });
    Clip {
        name: clip.name.clone(),
        duration_secs: clip.duration_secs,
        channels: channels.collect(),
    }
}

fn hold(channel: &Channel, duration: f32, rest: Transform, policy: Passive) -> Option<Channel> {
    let rest = rest_value(channel.property, rest);
    let first = value_at(channel, 0.0);
    match policy {
        Passive::Rest => None,
        Passive::Hold => constant(channel, first, &rest),
        Passive::KeyPose => constant(channel, central(channel, duration), &rest),
        Passive::BlendToRest(secs) => {
            let secs = secs.min(duration);
            if first == rest || secs <= 0.0 {
                return constant(channel, first, &rest);
            }
            let share = if let Passive::BlendToRest(all) = policy {
                secs / all
            } else {
                1.0
            };
            let last = blend(channel.property, &first, &rest, share);
            Some(Channel {
                interpolation: Interpolation::Linear,
                times_secs: vec![0.0, secs],
                values: [first, last].concat(),
                ..channel.clone()
            })
        }
    }
}

/// A channel that never changes as one key, or none where it says what rest says.
fn shortened(channel: &Channel, rest: Transform) -> Option<Channel> {
    if is_constant(channel) {
        let rest = rest_value(channel.property, rest);
        return constant(channel, value_at(channel, 0.0), &rest);
    }
    Some(channel.clone())
}

fn constant(channel: &Channel, value: Vec<f32>, rest: &[f32]) -> Option<Channel> {
    (value != rest).then(|| Channel {
        interpolation: Interpolation::Step,
        times_secs: vec![0.0],
        values: value,
        ..channel.clone()
    })
}

/// Whether all keys are equal; a cubic channel with any tangent changes between them.
fn is_constant(channel: &Channel) -> bool {
    let parts = if channel.interpolation == Interpolation::CubicSpline {
        3
    } else {
        1
    };
    let keys = channel.times_secs.len();
    let width = channel.values.len() / (keys * parts).max(1);
    if width == 0 {
        return true;
    }
    let part = |key: usize, part: usize| {
        let first = (key * parts + part) * width;
        &channel.values[first..first + width]
    };
    let value = parts / 2;
    (0..keys).all(|k| {
        let flat = parts == 1 || [0, 2].iter().all(|t| part(k, *t).iter().all(|v| *v == 0.0));
        flat && part(k, value) == part(0, value)
    })
}

fn width(property: Property) -> usize {
    if property == Property::Rotation { 4 } else { 3 }
}

fn value_at(channel: &Channel, time_secs: f32) -> Vec<f32> {
    let mut value = vec![0.0; width(channel.property)];
    evaluate::channel(channel, time_secs, &mut value);
    value
}

/// The value that is nearest to the farthest frame; looked for at the keys and halfway
/// between them.
fn central(channel: &Channel, duration: f32) -> Vec<f32> {
    let times = &channel.times_secs;
    let between = times.windows(2).map(|t| 0.5 * (t[0] + t[1]));
    let times = times.iter().copied().chain(between);
    let values: Vec<Vec<f32>> = times
        .filter(|t| *t <= duration)
        .map(|t| value_at(channel, t))
        .collect();
    if channel.property == Property::Rotation {
        let turns: Vec<Quat> = values.iter().map(|v| Quat::from_slice(v)).collect();
        let turn = central_rotation(&turns).unwrap_or(Quat::IDENTITY);
        return turn.to_array().to_vec();
    }
    let points = values.iter().map(|v| Vec3::from_slice(v));
    let corners = points
        .map(|p| (p, p))
        .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    let middle = corners.map_or(Vec3::ZERO, |(low, high)| 0.5 * (low + high));
    middle.to_array().to_vec()
}

fn rest_value(property: Property, rest: Transform) -> Vec<f32> {
    match property {
        Property::Translation => rest.translation.to_array().to_vec(),
        Property::Rotation => rest.rotation.to_array().to_vec(),
        Property::Scale => rest.scale.to_array().to_vec(),
        Property::Weights => Vec::new(),
    }
}

fn blend(property: Property, from: &[f32], to: &[f32], share: f32) -> Vec<f32> {
    if property == Property::Rotation {
        let turn = nlerp(Quat::from_slice(from), Quat::from_slice(to), share);
        return turn.to_array().to_vec();
    }
    let blended = from.iter().zip(to).map(|(a, b)| a + (b - a) * share);
    blended.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::articulation::{Articulation, JointArticulation, Region};
    use articula_core::math::angle_between;
    use articula_core::source::{Joint, Skeleton};

    fn rig() -> Rig {
        let joint = |parent| Joint {
            name: String::new(),
            parent,
            rest: Transform::IDENTITY,
            in_skin: true,
        };
        let skeleton = Skeleton {
            joints: vec![joint(None), joint(Some(0)), joint(Some(1))],
        };
        let entry = JointArticulation {
            hanim: None,
            level: 0,
            region: Region::Torso,
        };
        let articulation = Articulation {
            profile: String::new(),
            joints: vec![entry; 3],
        };
        Rig::new(&skeleton, articulation).unwrap()
    }

    fn turning(target: usize) -> Channel {
        let turn = |angle: f32| Quat::from_rotation_x(angle).to_array();
        Channel {
            target,
            property: Property::Rotation,
            interpolation: Interpolation::Linear,
            times_secs: vec![0.0, 1.0, 2.0],
            values: [turn(0.2), turn(0.5), turn(1.0)].concat(),
        }
    }

    fn clip() -> Clip {
        Clip {
            name: "c".into(),
            duration_secs: 2.0,
            channels: vec![turning(0), turning(1), turning(2)],
        }
    }

    #[test]
    fn the_root_follows_and_passive_joints_keep_one_key() {
        let active = JointSet::from_iter([2]);
        let held = reduced(&clip(), &rig(), &active, Passive::Hold);
        let keys: Vec<usize> = held.channels.iter().map(|c| c.times_secs.len()).collect();
        assert_eq!(keys, [3, 1, 3]);
        let turn = Quat::from_slice(&held.channels[1].values);
        assert!(angle_between(turn, Quat::from_rotation_x(0.2)) < 1e-5);
        // Three keys of one time and four values each, twice; one such key once.
        assert_eq!(Amount::of(&held).animation_bytes, 4 * (15 + 5 + 15));
        assert_eq!(Amount::of(&held).joints_animated, 2);
        let rest = reduced(&clip(), &rig(), &active, Passive::Rest);
        assert_eq!(rest.channels.len(), 2);
    }

    #[test]
    fn the_key_pose_is_halfway_between_the_extremes() {
        let held = reduced(&clip(), &rig(), &JointSet::EMPTY, Passive::KeyPose);
        let turn = Quat::from_slice(&held.channels[1].values);
        assert!(angle_between(turn, Quat::from_rotation_x(0.6)) < 0.01);
    }

    #[test]
    fn blending_to_rest_ends_there_or_with_the_clip() {
        let of = |secs| {
            let held = reduced(
                &clip(),
                &rig(),
                &JointSet::EMPTY,
                Passive::BlendToRest(secs),
            );
            held.channels[1].clone()
        };
        let short = of(0.5);
        assert_eq!(short.times_secs, [0.0, 0.5]);
        assert!(angle_between(Quat::from_slice(&short.values[4..]), Quat::IDENTITY) < 1e-5);
        let long = of(4.0);
        assert_eq!(long.times_secs, [0.0, 2.0]);
        // Half of the way from 0.2 to 0 is left.
        let halfway = Quat::from_slice(&long.values[4..]);
        assert!(angle_between(halfway, Quat::from_rotation_x(0.1)) < 1e-4);
    }

    #[test]
    fn active_channels_that_never_change_are_cut() {
        let mut clip = clip();
        let still = Quat::from_rotation_x(0.2).to_array();
        clip.channels[2].values = [still; 3].concat();
        clip.channels[1].values = [Quat::IDENTITY.to_array(); 3].concat();
        let out = reduced(&clip, &rig(), &rig().all(), Passive::Hold);
        let keys: Vec<_> = out
            .channels
            .iter()
            .map(|c| (c.target, c.times_secs.len()))
            .collect();
        assert_eq!(keys, [(0, 3), (2, 1)]);
    }

    #[test]
    fn policies_are_spelled_in_one_way() {
        assert_eq!(passive("blend-to-rest:0.5"), Ok(Passive::BlendToRest(0.5)));
        for bad in [
            "",
            "blend-to-rest",
            "blend-to-rest:-1",
            "blend-to-rest:NaN",
            "hold:1",
        ] {
            assert!(passive(bad).is_err(), "{bad}");
        }
    }
}
