//! Test for equal skeletons: joints of the same names, in the same hierarchy, with the same rest
//! pose.
//!
//! Only then can a clip be copied unchanged, since channels hold translations and rotations
//! relative to the rest pose of their own skeleton. A motion without a skin may have any pose as its rest,
//! such as its first frame; its joints are the same if those that hang from them are at the same places in
//! their spaces, however they are turned ([`Twins::of_posed`]).

use articula_core::source::{Channel, Interpolation, Property, RawClip, Skeleton};
use articula_core::{Transform, angle_between};
use glam::{Affine3A, Vec3};
use std::collections::{BTreeSet, HashMap};

/// Minimum fraction of the animated joints that must have a match: a file may have extra joints,
/// such as an attachment point for a weapon.
const SHARE: f32 = 0.75;
/// Maximum distance of rest positions, relative to the size of the skeleton.
const LENGTH: f32 = 0.01;
/// Maximum angle between rest rotations, in radians.
const RADIANS: f32 = 0.02;
/// Maximum relative difference of rest scales.
const SCALE: f32 = 0.01;
/// Differences of poses up to this size are rounding.
const SAME_METRES: f32 = 1e-5;
const SAME_RADIANS: f32 = 1e-5;
/// Minimum number of joints that tell the spaces of those that they hang from.
const TELLING: usize = 8;

/// For each joint of one skeleton, the same joint of the other.
#[derive(Debug)]
pub(super) struct Twins(Vec<Option<usize>>);

impl Twins {
    /// Matches the joints if those that the clips move are the same in both skeletons; clips that
    /// move no joint match any skeleton.
    pub(super) fn of(from: &Skeleton, clips: &[&RawClip], onto: &Skeleton) -> Option<Self> {
        let channels = clips.iter().flat_map(|c| &c.channels);
        let of_joints = channels.filter(|c| c.property.is_of_joint());
        let moved: BTreeSet<usize> = of_joints.map(|c| c.target).collect();
        let twins = match is_same_tree(from, onto) {
            true => (0..from.joints.len()).map(Some).collect(),
            false => named(from, onto),
        };
        let there = moved.iter().filter(|j| twins[**j].is_some()).count();
        if (there as f32) < SHARE * moved.len() as f32 {
            return None;
        }
        let rests = Rests::new(from, onto);
        let same = |joint: &usize| match twins[*joint] {
            Some(twin) => rests.agree(*joint, twin, &twins),
            None => true,
        };
        moved.iter().all(same).then_some(Self(twins))
    }

    /// Matches the joints of a motion whose rest is some pose of a skeleton with the same joints.
    pub(super) fn of_posed(from: &Skeleton, clips: &[&RawClip], onto: &Skeleton) -> Option<Self> {
        let twins = named(from, onto);
        let channels = clips.iter().flat_map(|c| &c.channels);
        let of_joints = channels.filter(|c| c.property.is_of_joint());
        let moved: BTreeSet<usize> = of_joints.clone().map(|c| c.target).collect();
        let there = moved.iter().filter(|j| twins[**j].is_some()).count();
        if (there as f32) < SHARE * moved.len() as f32 {
            return None;
        }
        let travels = of_joints.filter(|c| c.property == Property::Translation);
        let travelling: BTreeSet<usize> = travels.map(|c| c.target).collect();
        let rests = Rests::new(from, onto);
        let mut telling = 0;
        for (joint, twin) in twins.iter().enumerate() {
            let Some(twin) = *twin else {
                continue;
            };
            let (a, b) = (&from.joints[joint], &onto.joints[twin]);
            match (a.parent.map(|p| twins[p]), b.parent) {
                (Some(Some(p)), Some(q)) if p == q => {
                    let apart = a.rest.translation.distance(b.rest.translation);
                    if apart > rests.far_metres && !travelling.contains(&joint) {
                        return None;
                    }
                    telling += usize::from(b.rest.translation.length() > 2.0 * rests.far_metres);
                }
                (None, None) => {}
                (None, Some(above)) if rests.is_origin(above) => {}
                _ => return None,
            }
        }
        (telling >= TELLING).then_some(Self(twins))
    }

    /// Channels that hold the rest pose where a clip does not move a joint.
    pub(super) fn held(&self, from: &Skeleton, clip: &RawClip, onto: &Skeleton) -> Vec<Channel> {
        let keyed: BTreeSet<(usize, bool)> = clip
            .channels
            .iter()
            .filter(|c| matches!(c.property, Property::Translation | Property::Rotation))
            .map(|c| (c.target, c.property == Property::Rotation))
            .collect();
        let mut held = Vec::new();
        for (joint, twin) in self.0.iter().enumerate() {
            let Some(twin) = *twin else {
                continue;
            };
            let (a, b) = (from.joints[joint].rest, onto.joints[twin].rest);
            let is_moved = a.translation.distance(b.translation) > SAME_METRES;
            let is_turned = angle_between(a.rotation, b.rotation) > SAME_RADIANS;
            let mut hold = |property, values: &[f32]| {
                held.push(Channel {
                    target: twin,
                    property,
                    interpolation: Interpolation::Linear,
                    times_secs: vec![0.0],
                    values: values.to_vec(),
                });
            };
            if is_moved && !keyed.contains(&(joint, false)) {
                hold(Property::Translation, &a.translation.to_array());
            }
            if is_turned && !keyed.contains(&(joint, true)) {
                hold(Property::Rotation, &a.rotation.to_array());
            }
        }
        held
    }

    /// Returns the channel for the other skeleton; `None` if it has no such joint or the channel
    /// drives no joint.
    pub(super) fn channel(&self, channel: &Channel) -> Option<Channel> {
        let joint = channel.property.is_of_joint().then_some(channel.target)?;
        Some(Channel {
            target: self.0[joint]?,
            ..channel.clone()
        })
    }
}

/// Whether both skeletons have the same joints in the same order, which need no names then.
fn is_same_tree(from: &Skeleton, onto: &Skeleton) -> bool {
    let mut pairs = from.joints.iter().zip(&onto.joints);
    from.joints.len() == onto.joints.len()
        && pairs.all(|(a, b)| (&a.name, a.parent) == (&b.name, b.parent))
}

/// Matches joints by name, if the name is unique in both skeletons.
pub(super) fn named(from: &Skeleton, onto: &Skeleton) -> Vec<Option<usize>> {
    let (own, other) = (unique(from), unique(onto));
    let twin = |(j, name): (usize, &str)| {
        own.get(name).filter(|at| **at == Some(j))?;
        *other.get(name)?
    };
    let names = from.joints.iter().map(|j| j.name.as_str());
    names.enumerate().map(twin).collect()
}

/// Index of each name; `None` if it occurs more than once.
fn unique(skeleton: &Skeleton) -> HashMap<&str, Option<usize>> {
    let mut at = HashMap::new();
    for (j, joint) in skeleton.joints.iter().enumerate() {
        if !joint.name.is_empty() {
            at.entry(joint.name.as_str())
                .and_modify(|at| *at = None)
                .or_insert(Some(j));
        }
    }
    at
}

/// Rest poses of both skeletons.
struct Rests<'a> {
    from: &'a Skeleton,
    onto: &'a Skeleton,
    from_model: Vec<Affine3A>,
    onto_model: Vec<Affine3A>,
    far_metres: f32,
}

impl<'a> Rests<'a> {
    fn new(from: &'a Skeleton, onto: &'a Skeleton) -> Self {
        let onto_model = onto.model_rest();
        let places = || onto_model.iter().map(|m| Vec3::from(m.translation));
        let low = places().fold(Vec3::INFINITY, Vec3::min);
        let high = places().fold(Vec3::NEG_INFINITY, Vec3::max);
        Self {
            from,
            onto,
            from_model: from.model_rest(),
            far_metres: LENGTH * (high - low).length(),
            onto_model,
        }
    }

    /// Returns whether a joint and its match have the same rest transform, and their parents match
    /// or the joints rest at the same position in model space.
    fn agree(&self, joint: usize, twin: usize, twins: &[Option<usize>]) -> bool {
        let (a, b) = (&self.from.joints[joint], &self.onto.joints[twin]);
        let parents = match (a.parent, b.parent) {
            (Some(p), Some(q)) if twins[p] == Some(q) => true,
            (None, None) => true,
            _ => {
                let (a, b) = (self.from_model[joint], self.onto_model[twin]);
                match (
                    Transform::from_matrix(a.into()),
                    Transform::from_matrix(b.into()),
                ) {
                    (Some(a), Some(b)) => self.alike(a, b),
                    _ => false,
                }
            }
        };
        parents && self.alike(a.rest, b.rest)
    }

    /// Whether the space of a joint of the other skeleton is that of the model.
    fn is_origin(&self, joint: usize) -> bool {
        let own = Transform::from_matrix(self.onto_model[joint].into());
        own.is_some_and(|own| self.alike(own, Transform::IDENTITY))
    }

    fn alike(&self, a: Transform, b: Transform) -> bool {
        a.translation.distance(b.translation) <= self.far_metres
            && angle_between(a.rotation, b.rotation) <= RADIANS
            && a.scale.distance(b.scale) <= SCALE * b.scale.length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::source::{Interpolation, Joint, Property};

    fn skeleton(joints: &[(&str, Option<usize>, f32)]) -> Skeleton {
        let joint = |(name, parent, y): &(&str, Option<usize>, f32)| Joint {
            name: (*name).into(),
            parent: *parent,
            rest: Transform::from_translation(Vec3::Y * *y),
            in_skin: true,
        };
        Skeleton {
            joints: joints.iter().map(joint).collect(),
        }
    }

    fn turning(joints: &[usize]) -> RawClip {
        let channel = |joint: &usize| Channel {
            target: *joint,
            property: Property::Rotation,
            interpolation: Interpolation::Linear,
            times_secs: vec![0.0],
            values: vec![0.0, 0.0, 0.0, 1.0],
        };
        RawClip {
            channels: joints.iter().map(channel).collect(),
            ..RawClip::default()
        }
    }

    #[test]
    fn the_same_joints_are_found_in_any_order() {
        let from = skeleton(&[
            ("hips", None, 1.0),
            ("spine", Some(0), 0.2),
            ("head", Some(1), 0.4),
        ]);
        let onto = skeleton(&[
            ("rig", None, 0.0),
            ("hips", Some(0), 1.0),
            ("leg", Some(1), -0.5),
            ("spine", Some(1), 0.2),
            ("head", Some(3), 0.4),
        ]);
        let clip = turning(&[0, 1, 2]);
        let twins = Twins::of(&from, &[&clip], &onto).unwrap();
        assert_eq!(twins.0, [Some(1), Some(3), Some(4)]);
        assert_eq!(twins.channel(&clip.channels[2]).unwrap().target, 4);
    }

    #[test]
    fn a_rest_that_is_a_pose_is_held_where_the_clip_moves_nothing() {
        let chain: Vec<(String, Option<usize>, f32)> = (0..10_usize)
            .map(|j| (format!("j{j}"), j.checked_sub(1), 0.2))
            .collect();
        let rows: Vec<(&str, Option<usize>, f32)> =
            chain.iter().map(|(n, p, y)| (n.as_str(), *p, *y)).collect();
        let onto = skeleton(&rows);
        let mut from = onto.clone();
        for joint in &mut from.joints {
            joint.rest.rotation = glam::Quat::from_rotation_z(0.5);
        }
        let clip = turning(&[0, 1, 2]);
        assert!(Twins::of(&from, &[&clip], &onto).is_none());
        let twins = Twins::of_posed(&from, &[&clip], &onto).unwrap();
        let held = twins.held(&from, &clip, &onto);
        let targets: Vec<usize> = held.iter().map(|c| c.target).collect();
        assert_eq!(targets, [3, 4, 5, 6, 7, 8, 9]);
        assert!((held[0].values[2] - 0.25_f32.sin()).abs() < 1e-6);
        // Of another shape, it is another skeleton.
        from.joints[5].rest.translation = Vec3::X * 0.2;
        assert!(Twins::of_posed(&from, &[&clip], &onto).is_none());
    }

    #[test]
    fn the_same_skeleton_needs_no_names() {
        let from = skeleton(&[("", None, 1.0), ("", Some(0), 0.2), ("", Some(1), 0.4)]);
        let clip = turning(&[0, 2]);
        let twins = Twins::of(&from, &[&clip], &from).unwrap();
        assert_eq!(twins.0, [Some(0), Some(1), Some(2)]);
        let other = skeleton(&[("", None, 1.0), ("", Some(0), 0.2), ("", Some(0), 0.4)]);
        assert!(Twins::of(&from, &[&clip], &other).is_none());
        let longer = skeleton(&[("", None, 1.0), ("", Some(0), 0.3), ("", Some(1), 0.4)]);
        assert!(Twins::of(&from, &[&turning(&[1])], &longer).is_none());
    }

    #[test]
    fn another_rest_or_tree_is_another_skeleton() {
        let onto = skeleton(&[
            ("hips", None, 1.0),
            ("spine", Some(0), 0.2),
            ("head", Some(1), 0.4),
        ]);
        let clip = turning(&[0, 1, 2]);
        for from in [
            skeleton(&[
                ("hips", None, 1.0),
                ("spine", Some(0), 0.3),
                ("head", Some(1), 0.4),
            ]),
            skeleton(&[
                ("hips", None, 1.0),
                ("spine", Some(0), 0.2),
                ("head", Some(0), 0.4),
            ]),
            skeleton(&[
                ("hips", None, 1.0),
                ("neck", Some(0), 0.2),
                ("skull", Some(1), 0.4),
            ]),
            skeleton(&[
                ("hips", None, 1.0),
                ("head", Some(0), 0.2),
                ("head", Some(1), 0.4),
            ]),
        ] {
            assert!(Twins::of(&from, &[&clip], &onto).is_none(), "{from:?}");
        }
    }

    #[test]
    fn a_joint_that_stands_still_need_not_be_there() {
        let from = skeleton(&[("hips", None, 1.0), ("slot", Some(0), 0.2)]);
        let onto = skeleton(&[("hips", None, 1.0)]);
        let twins = Twins::of(&from, &[&turning(&[0])], &onto).unwrap();
        assert_eq!(twins.0, [Some(0), None]);
        assert!(Twins::of(&from, &[&turning(&[0, 1])], &onto).is_none());
    }
}
