//! Transfer of a motion to a rig whose joints have the same names but another rest pose.
//!
//! For rigs that are no humans, such as two animals of one skeleton. A joint `j` with the parent `p`
//! turns in model space by what the source's joint turns from its rest pose: with the rest rotations
//! `S` of the source and `T` of the target in model space, a local rotation `q` becomes
//! `(T_p⁻¹ S_p) q (S_j⁻¹ T_j)`. The factors are constant, so keys, times and splines are kept.
//! Translations of joints that move are differences from the rest pose, turned likewise and scaled
//! by the ratio of the lengths of both skeletons.

use super::same_joints::named;
use crate::open::NameTransfer;
use articula_core::source::{Channel, Interpolation, Property, RawClip, Skeleton};
use glam::{Affine3A, Mat3A, Quat, Vec3, Vec3A, Vec4};
use std::collections::BTreeSet;

/// Minimum fraction of the moving joints that must have a joint of the same name.
const USEFUL: f32 = 0.5;
/// Translations that vary by less, relative to the size of the skeleton, do not move.
const STILL: f32 = 1e-4;
/// Rotations and scales whose numbers vary by less do not move.
const STILL_NUMBERS: f32 = 1e-5;

/// Joints of two skeletons with the same names and the same joints above them.
#[derive(Debug)]
pub(super) struct Namesakes<'a> {
    from: &'a Skeleton,
    onto: &'a Skeleton,
    /// For each joint of `from`, the joint of `onto`.
    twins: Vec<Option<usize>>,
    from_rests: Rests,
    onto_rests: Rests,
    scale: f32,
    /// Range of a translation below which it does not move.
    still_metres: f32,
}

/// Rest pose in model space.
#[derive(Debug)]
struct Rests {
    model: Vec<Affine3A>,
    rotations: Vec<Quat>,
}

impl Rests {
    fn new(skeleton: &Skeleton) -> Self {
        let mut rotations: Vec<Quat> = Vec::with_capacity(skeleton.joints.len());
        for joint in &skeleton.joints {
            let above = joint.parent.map_or(Quat::IDENTITY, |p| rotations[p]);
            rotations.push((above * joint.rest.rotation).normalize());
        }
        Self {
            model: skeleton.model_rest(),
            rotations,
        }
    }

    /// Diagonal of the box around all joints.
    fn size(&self) -> f32 {
        let places = self.model.iter().map(|m| m.translation);
        let low = places.clone().fold(Vec3A::INFINITY, Vec3A::min);
        let high = places.fold(Vec3A::NEG_INFINITY, Vec3A::max);
        (high - low).length()
    }

    fn place(&self, joint: usize) -> Vec3A {
        self.model[joint].translation
    }

    fn rotation(&self, joint: Option<usize>) -> Quat {
        joint.map_or(Quat::IDENTITY, |j| self.rotations[j])
    }

    fn linear(&self, joint: Option<usize>) -> Mat3A {
        joint.map_or(Mat3A::IDENTITY, |j| self.model[j].matrix3)
    }
}

impl<'a> Namesakes<'a> {
    /// Matches the joints of two skeletons.
    pub(super) fn of(from: &'a Skeleton, onto: &'a Skeleton) -> Self {
        let mut twins = named(from, onto);
        // The nearest joint above with a twin, in both trees; where they differ, so do the rigs.
        let mut of_onto = vec![None; onto.joints.len()];
        for joint in 0..twins.len() {
            let Some(twin) = twins[joint] else {
                continue;
            };
            let above = above(from, joint).find_map(|j| twins[j]);
            let above_twin = above_of(onto, twin, &of_onto);
            if above == above_twin {
                of_onto[twin] = Some(joint);
            } else {
                twins[joint] = None;
            }
        }
        let (from_rests, onto_rests) = (Rests::new(from), Rests::new(onto));
        let mut lengths = [0.0_f32; 2];
        for (joint, twin) in twins.iter().enumerate() {
            let Some((twin, other)) = twin.zip(above(from, joint).find(|j| twins[*j].is_some()))
            else {
                continue;
            };
            let Some(other_twin) = twins[other] else {
                continue;
            };
            lengths[0] += from_rests.place(joint).distance(from_rests.place(other));
            lengths[1] += onto_rests
                .place(twin)
                .distance(onto_rests.place(other_twin));
        }
        let scale = lengths[1] / lengths[0];
        Self {
            from,
            onto,
            twins,
            still_metres: STILL * from_rests.size(),
            from_rests,
            onto_rests,
            scale: if scale.is_finite() && scale > 0.0 {
                scale
            } else {
                1.0
            },
        }
    }

    /// Numbers of moving joints of the clips with and without a joint of the same name.
    pub(super) fn coverage(&self, clips: &[&RawClip]) -> (usize, usize) {
        let moving: BTreeSet<usize> = clips.iter().flat_map(|clip| self.moving(clip)).collect();
        let there = moving.iter().filter(|j| self.twins[**j].is_some()).count();
        (there, moving.len())
    }

    /// Whether enough of the moving joints have a joint of the same name.
    pub(super) fn are_useful(&self, clips: &[&RawClip]) -> bool {
        let (there, all) = self.coverage(clips);
        there as f32 >= USEFUL * all as f32
    }

    fn moving(&self, clip: &RawClip) -> BTreeSet<usize> {
        let joints = clip.channels.iter().filter(|c| c.property.is_of_joint());
        let moving = joints.filter(|c| self.moves(c) || self.is_off_rest(c));
        moving.map(|c| c.target).collect()
    }

    /// Whether the values of a channel change over time.
    fn moves(&self, channel: &Channel) -> bool {
        let width = width(channel.property);
        let mut keys = values_of(channel, width);
        let Some(first) = keys.next() else {
            return false;
        };
        let still = self.still(channel.property);
        keys.any(|key| key.iter().zip(first).any(|(a, b)| (a - b).abs() > still))
    }

    /// Whether a channel of one value differs from the rest pose.
    fn is_off_rest(&self, channel: &Channel) -> bool {
        let rest = self.from.joints[channel.target].rest;
        let rest = match channel.property {
            Property::Rotation => rest.rotation.to_array(),
            Property::Scale => rest.scale.extend(0.0).to_array(),
            _ => rest.translation.extend(0.0).to_array(),
        };
        let still = self.still(channel.property);
        let first = values_of(channel, width(channel.property)).next();
        first.is_some_and(|key| {
            let off = |sign: f32| {
                key.iter()
                    .zip(rest)
                    .any(|(a, b)| (a - sign * b).abs() > still)
            };
            off(1.0) && (channel.property != Property::Rotation || off(-1.0))
        })
    }

    fn still(&self, property: Property) -> f32 {
        match property {
            Property::Translation => self.still_metres,
            _ => STILL_NUMBERS,
        }
    }

    /// Transfers a clip; it has no name.
    pub(super) fn transfer(&self, clip: &RawClip) -> (RawClip, NameTransfer) {
        let channels = clip.channels.iter().filter_map(|c| self.channel(c));
        let moved = RawClip {
            name: String::new(),
            duration_secs: clip.duration_secs,
            channels: channels.collect(),
        };
        let moving = self.moving(clip);
        let mut sources = vec![None; self.onto.joints.len()];
        for (joint, twin) in self.twins.iter().enumerate() {
            if let Some(twin) = twin.filter(|_| moving.contains(&joint)) {
                sources[twin] = Some(joint);
            }
        }
        let dropped = moving.iter().copied().filter(|j| self.twins[*j].is_none());
        let report = NameTransfer {
            followed: sources.iter().flatten().count(),
            moving: moving.len(),
            scale: self.scale,
            sources,
            dropped: dropped.collect(),
        };
        (moved, report)
    }

    /// The channel of the twin; `None` if there is no twin or the channel says nothing.
    fn channel(&self, channel: &Channel) -> Option<Channel> {
        if !channel.property.is_of_joint() {
            return None;
        }
        let joint = channel.target;
        let twin = self.twins[joint]?;
        let (own, other) = (&self.from.joints[joint], &self.onto.joints[twin]);
        let is_cubic = channel.interpolation == Interpolation::CubicSpline;
        // In a spline the first and last of three vectors of a key are tangents.
        let is_tangent = |at: usize| is_cubic && at % 3 != 1;
        let mut values = Vec::with_capacity(channel.values.len());
        match channel.property {
            Property::Rotation => {
                let (p, q) = (own.parent, other.parent);
                let before = self.onto_rests.rotation(q).inverse() * self.from_rests.rotation(p);
                let after =
                    self.from_rests.rotations[joint].inverse() * self.onto_rests.rotations[twin];
                for key in channel.values.chunks_exact(4) {
                    // Linear in the numbers of the rotation, thus right for tangents too.
                    let turned =
                        product(before.into(), product(Vec4::from_slice(key), after.into()));
                    values.extend(turned.to_array());
                }
            }
            Property::Translation => {
                let has_twin_above = above(self.from, joint).any(|j| self.twins[j].is_some());
                if !self.moves(channel) && (has_twin_above || !self.is_off_rest(channel)) {
                    return None;
                }
                let to_onto = self.onto_rests.linear(other.parent).inverse();
                let linear = self.scale * (to_onto * self.from_rests.linear(own.parent));
                if !linear.is_finite() {
                    return None;
                }
                for (at, key) in channel.values.chunks_exact(3).enumerate() {
                    let key = Vec3::from_slice(key);
                    let moved = match is_tangent(at) {
                        true => linear * key,
                        false => other.rest.translation + linear * (key - own.rest.translation),
                    };
                    values.extend(moved.to_array());
                }
            }
            _ => {
                if !self.moves(channel) && !self.is_off_rest(channel) {
                    return None;
                }
                let ratio = other.rest.scale / own.rest.scale;
                if !ratio.is_finite() {
                    return None;
                }
                for key in channel.values.chunks_exact(3) {
                    values.extend((ratio * Vec3::from_slice(key)).to_array());
                }
            }
        }
        Some(Channel {
            target: twin,
            values,
            ..channel.clone()
        })
    }
}

/// The product of two rotations as numbers, which need not be of length 1.
fn product(a: Vec4, b: Vec4) -> Vec4 {
    let (u, v) = (a.truncate(), b.truncate());
    (a.w * v + b.w * u + u.cross(v)).extend(a.w * b.w - u.dot(v))
}

fn width(property: Property) -> usize {
    if property == Property::Rotation { 4 } else { 3 }
}

/// The values of the keys, without tangents.
fn values_of(channel: &Channel, width: usize) -> impl Iterator<Item = &[f32]> {
    let (step, skip) = match channel.interpolation {
        Interpolation::CubicSpline => (3, 1),
        _ => (1, 0),
    };
    channel.values.chunks_exact(width).skip(skip).step_by(step)
}

/// The joints above one, nearest first.
fn above(skeleton: &Skeleton, joint: usize) -> impl Iterator<Item = usize> {
    let parent = |j: &usize| skeleton.joints[*j].parent;
    std::iter::successors(parent(&joint), parent)
}

/// The nearest joint above that is the twin of a joint.
fn above_of(skeleton: &Skeleton, joint: usize, twins: &[Option<usize>]) -> Option<usize> {
    above(skeleton, joint).find(|j| twins[*j].is_some())
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::Transform;
    use articula_core::source::Joint;
    use proptest::prelude::*;

    /// A chain of joints with these names and rest transforms.
    fn chain(joints: &[(&str, Transform)]) -> Skeleton {
        let joint = |(at, (name, rest)): (usize, &(&str, Transform))| Joint {
            name: (*name).to_owned(),
            parent: at.checked_sub(1),
            rest: *rest,
            in_skin: true,
        };
        Skeleton {
            joints: joints.iter().enumerate().map(joint).collect(),
        }
    }

    fn up(metres: f32) -> Transform {
        Transform::from_translation(Vec3::Y * metres)
    }

    fn channel(target: usize, property: Property, values: &[f32]) -> Channel {
        Channel {
            target,
            property,
            interpolation: Interpolation::Linear,
            times_secs: (0..values.len() / width(property))
                .map(|t| t as f32)
                .collect(),
            values: values.to_vec(),
        }
    }

    fn clip(channels: Vec<Channel>) -> RawClip {
        RawClip {
            name: "c".to_owned(),
            duration_secs: 1.0,
            channels,
        }
    }

    /// Model-space transforms of the pose at a key.
    fn posed(skeleton: &Skeleton, clip: &RawClip, key: usize) -> Vec<Affine3A> {
        let mut posed = skeleton.clone();
        for channel in &clip.channels {
            let rest = &mut posed.joints[channel.target].rest;
            let value = values_of(channel, width(channel.property))
                .nth(key)
                .unwrap();
            match channel.property {
                Property::Rotation => rest.rotation = Quat::from_slice(value),
                Property::Translation => rest.translation = Vec3::from_slice(value),
                _ => rest.scale = Vec3::from_slice(value),
            }
        }
        posed.model_rest()
    }

    #[test]
    fn a_figure_of_twice_the_size_moves_twice_as_far() {
        let from = chain(&[("root", up(1.0)), ("neck", up(0.5)), ("head", up(0.5))]);
        let onto = chain(&[("root", up(2.0)), ("neck", up(1.0)), ("head", up(1.0))]);
        let turn = Quat::from_rotation_x(0.5);
        let still = [0.0, 0.5, 0.0, 0.0, 0.5, 0.0];
        let motion = clip(vec![
            channel(0, Property::Translation, &[0.0, 1.0, 0.0, 0.0, 1.0, 3.0]),
            channel(
                1,
                Property::Rotation,
                &[Quat::IDENTITY.to_array(), turn.to_array()].concat(),
            ),
            channel(2, Property::Translation, &still),
        ]);
        let pair = Namesakes::of(&from, &onto);
        let (moved, report) = pair.transfer(&motion);
        assert_eq!((report.followed, report.moving, report.scale), (2, 2, 2.0));
        assert_eq!(report.sources, [Some(0), Some(1), None]);
        assert_eq!(moved.channels.len(), 2, "the head keeps its own length");
        assert_eq!(moved.channels[0].values, [0.0, 2.0, 0.0, 0.0, 2.0, 6.0]);
        assert_eq!(moved.channels[1].values[4..], turn.to_array());
    }

    #[test]
    fn a_spline_keeps_its_tangents() {
        let (from, onto) = (
            chain(&[("a", up(1.0)), ("b", up(1.0))]),
            chain(&[("a", up(3.0)), ("b", up(2.0))]),
        );
        let mut jump = channel(0, Property::Translation, &[]);
        jump.interpolation = Interpolation::CubicSpline;
        jump.times_secs = vec![0.0, 1.0];
        // In-tangent, value, out-tangent, twice.
        let key = |y: f32| [0.0, 1.0, 0.0, 0.0, y, 0.0, 0.0, 4.0, 0.0];
        jump.values = [key(1.0), key(1.5)].concat();
        let (moved, _) = Namesakes::of(&from, &onto).transfer(&clip(vec![jump]));
        let key = |y: f32| [0.0, 2.0, 0.0, 0.0, y, 0.0, 0.0, 8.0, 0.0];
        assert_eq!(moved.channels[0].values, [key(3.0), key(4.0)].concat());
    }

    #[test]
    fn few_common_names_are_not_useful() {
        let from = chain(&[("a", up(1.0)), ("b", up(1.0)), ("c", up(1.0))]);
        let onto = chain(&[("a", up(1.0)), ("x", up(1.0)), ("y", up(1.0))]);
        let turn = [
            Quat::IDENTITY.to_array(),
            Quat::from_rotation_z(0.3).to_array(),
        ]
        .concat();
        let turning = |joints: &[usize]| {
            clip(
                joints
                    .iter()
                    .map(|j| channel(*j, Property::Rotation, &turn))
                    .collect(),
            )
        };
        let pair = Namesakes::of(&from, &onto);
        assert_eq!(pair.coverage(&[&turning(&[0, 1, 2])]), (1, 3));
        assert!(!pair.are_useful(&[&turning(&[0, 1, 2])]));
        assert!(pair.are_useful(&[&turning(&[0, 1])]));
        assert!(!pair.are_useful(&[&turning(&[1])]));
        assert_eq!(pair.transfer(&turning(&[0, 2])).1.dropped, [2]);
    }

    #[test]
    fn joints_of_the_same_name_in_another_tree_are_no_twins() {
        let from = chain(&[("a", up(1.0)), ("b", up(1.0)), ("c", up(1.0))]);
        let onto = chain(&[("a", up(1.0)), ("c", up(1.0)), ("b", up(1.0))]);
        assert_eq!(Namesakes::of(&from, &onto).twins, [Some(0), Some(2), None]);
    }

    fn rotation() -> impl Strategy<Value = Quat> {
        prop::array::uniform4(-1.0_f32..1.0)
            .prop_filter("not near zero", |v| Vec4::from(*v).length() > 0.2)
            .prop_map(|v| Quat::from_array(v).normalize())
    }

    proptest! {
        /// The same figure with other axes of its joints moves in the same way.
        #[test]
        fn other_rest_axes_do_not_change_the_motion(
            rests in prop::array::uniform3(rotation()),
            turned in prop::array::uniform3(rotation()),
            turns in prop::array::uniform3(rotation()),
            shift in prop::array::uniform3(-1.0_f32..1.0),
        ) {
            let names = ["a", "b", "c"];
            let offsets = [Vec3::new(0.1, 1.0, 0.2), Vec3::new(0.3, 0.5, -0.1), Vec3::new(0.0, 0.4, 0.2)];
            let from: Vec<(&str, Transform)> = (0..3)
                .map(|j| (names[j], Transform { translation: offsets[j], rotation: rests[j], scale: Vec3::ONE }))
                .collect();
            let from = chain(&from);
            // Each joint of the other rig is the same, times a rotation of its axes.
            let mut joints = Vec::new();
            for j in 0..3_usize {
                let above = j.checked_sub(1).map_or(Quat::IDENTITY, |p| turned[p]);
                joints.push((names[j], Transform {
                    translation: above.inverse() * offsets[j],
                    rotation: above.inverse() * rests[j] * turned[j],
                    scale: Vec3::ONE,
                }));
            }
            let onto = chain(&joints);
            let mut channels: Vec<Channel> = (0..3)
                .map(|j| channel(j, Property::Rotation, &[rests[j].to_array(), turns[j].to_array()].concat()))
                .collect();
            let moved = offsets[0] + Vec3::from(shift);
            channels.push(channel(0, Property::Translation, &[offsets[0].to_array(), moved.to_array()].concat()));
            let motion = clip(channels);
            let (made, report) = Namesakes::of(&from, &onto).transfer(&motion);
            prop_assert!((report.scale - 1.0).abs() < 1e-4);
            for key in 0..2 {
                let wanted = posed(&from, &motion, key);
                let found = posed(&onto, &made, key);
                for j in 0..3_usize {
                    prop_assert!(wanted[j].translation.distance(found[j].translation) < 1e-3);
                    let wanted = wanted[j] * Affine3A::from_quat(turned[j]);
                    let far = (wanted.matrix3 - found[j].matrix3).x_axis.length();
                    prop_assert!(far < 1e-3, "{j}: {far}");
                }
            }
        }
    }
}
