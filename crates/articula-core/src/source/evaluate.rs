//! Exact evaluation of keyed channels at any time, as defined by appendix C of the glTF 2.0
//! specification.
//!
//! Linear rotations use spherical interpolation along the shorter arc; cubic ones are Hermite
//! splines, normalised afterwards. A channel holds its first value before its first key and its
//! last value after its last key.

use super::{Channel, Interpolation, Property, RawClip, Skeleton};
use crate::elementary::{LibmArc, LibmQuat};
use crate::math::same_hemisphere;
use crate::pose::LocalPose;
use glam::{Quat, Vec3, Vec4};

/// Evaluates a channel with `out.len()` floats per key; rotations are normalised.
///
/// # Panics
/// If the channel has no key, or too few values for its keys.
pub fn channel(channel: &Channel, time_secs: f32, out: &mut [f32]) {
    let width = out.len();
    let times = &channel.times_secs;
    let after = times.partition_point(|t| *t <= time_secs);
    let before = after.saturating_sub(1);
    let cubic = channel.interpolation == Interpolation::CubicSpline;
    let value = |key: usize| {
        let first = if cubic {
            (3 * key + 1) * width
        } else {
            key * width
        };
        &channel.values[first..first + width]
    };
    let holds = after == 0 || after == times.len();
    if holds || channel.interpolation == Interpolation::Step {
        out.copy_from_slice(value(before));
    } else {
        let span = times[after] - times[before];
        let t = (time_secs - times[before]) / span;
        let rotation = channel.property == Property::Rotation;
        if cubic {
            let tangent = |key: usize, part: usize| {
                let first = (3 * key + part) * width;
                &channel.values[first..first + width]
            };
            let (t2, t3) = (t * t, t * t * t);
            let (out_tangent, in_tangent) = (tangent(before, 2), tangent(after, 0));
            for (i, o) in out.iter_mut().enumerate() {
                *o = (2.0 * t3 - 3.0 * t2 + 1.0) * value(before)[i]
                    + span * (t3 - 2.0 * t2 + t) * out_tangent[i]
                    + (-2.0 * t3 + 3.0 * t2) * value(after)[i]
                    + span * (t3 - t2) * in_tangent[i];
            }
        } else if rotation {
            let (a, b) = (quat(value(before)), quat(value(after)));
            out.copy_from_slice(&a.libm_slerp(same_hemisphere(a, b), t).to_array());
        } else {
            for (i, o) in out.iter_mut().enumerate() {
                *o = value(before)[i] + (value(after)[i] - value(before)[i]) * t;
            }
        }
    }
    if channel.property == Property::Rotation {
        out.copy_from_slice(&quat(out).to_array());
    }
}

/// Writes the local pose of a clip at a time; joints without a channel are set to the rest pose.
///
/// # Panics
/// If `out` belongs to another skeleton, or a channel targets a joint out of range.
pub fn pose(clip: &RawClip, skeleton: &Skeleton, time_secs: f32, out: &mut LocalPose) {
    assert_eq!(
        out.rotations.len(),
        skeleton.joints.len(),
        "the pose must belong to this skeleton"
    );
    for (j, joint) in skeleton.joints.iter().enumerate() {
        out.set(j, joint.rest);
    }
    for c in &clip.channels {
        let mut value = [0.0; 4];
        let mut three = || {
            channel(c, time_secs, &mut value[..3]);
            Vec3::from_slice(&value)
        };
        match c.property {
            Property::Translation => out.translations[c.target] = three(),
            Property::Scale => out.scales[c.target] = three(),
            Property::Rotation => {
                channel(c, time_secs, &mut value);
                out.rotations[c.target] = Quat::from_array(value);
            }
            Property::Weights | Property::Expression => {}
        }
    }
}

/// Evaluates a clip at many times, with the bits of [`pose`]. What a pair of keys has in common is found once for times
/// that follow each other between them.
#[derive(Debug, Clone)]
pub struct Sampler<'a> {
    skeleton: &'a Skeleton,
    joint_channels: Vec<ChannelSampler<'a>>,
}

impl<'a> Sampler<'a> {
    /// Starts before the first key.
    pub fn new(clip: &'a RawClip, skeleton: &'a Skeleton) -> Self {
        let of_joints = clip.channels.iter().filter(|c| c.property.is_of_joint());
        Self {
            skeleton,
            joint_channels: of_joints.map(ChannelSampler::new).collect(),
        }
    }

    /// Writes the local pose at a time as [`pose`] does.
    ///
    /// # Panics
    /// If `out` belongs to another skeleton, or a channel targets a joint out of range.
    pub fn pose(&mut self, time_secs: f32, out: &mut LocalPose) {
        assert_eq!(
            out.rotations.len(),
            self.skeleton.joints.len(),
            "the pose must belong to this skeleton"
        );
        for (j, joint) in self.skeleton.joints.iter().enumerate() {
            out.set(j, joint.rest);
        }
        for sampler in &mut self.joint_channels {
            let value = sampler.value(time_secs);
            let target = sampler.channel.target;
            match sampler.channel.property {
                Property::Translation => out.translations[target] = Vec3::from_slice(&value),
                Property::Scale => out.scales[target] = Vec3::from_slice(&value),
                _ => out.rotations[target] = Quat::from_array(value),
            }
        }
    }
}

/// Evaluates a channel of a joint at many times, with the bits of [`channel`]: fastest at rising times, of which some lie
/// between the same keys.
#[derive(Debug, Clone)]
pub struct ChannelSampler<'a> {
    channel: &'a Channel,
    still: Option<[f32; 4]>,
    /// The one in which it was evaluated last.
    segment: Segment,
}

impl<'a> ChannelSampler<'a> {
    /// Starts before the first key.
    pub fn new(channel: &'a Channel) -> Self {
        let nowhere = Segment {
            start_secs: f32::INFINITY,
            end_secs: f32::NEG_INFINITY,
            after: 0,
            curve: Curve::Spline,
        };
        Self {
            channel,
            still: still(channel),
            segment: nowhere,
        }
    }

    /// The value, if it has the same bits at all times.
    pub fn still(&self) -> Option<[f32; 4]> {
        self.still
    }

    /// The value at a time: x, y, z and w of a unit rotation, or x, y, z of a translation or scale, in the units of
    /// the channel, and 0.
    ///
    /// # Panics
    /// If the channel has no key, too few values for its keys, or is not that of a joint.
    pub fn value(&mut self, time_secs: f32) -> [f32; 4] {
        if let Some(still) = self.still {
            return still;
        }
        let segment = &self.segment;
        if !(segment.start_secs..segment.end_secs).contains(&time_secs) {
            let after = segment.key_after(&self.channel.times_secs, time_secs);
            self.segment = Segment::before(self.channel, after);
        }
        self.segment.value(self.channel, time_secs)
    }
}

/// An interval of a channel without a key inside.
#[derive(Debug, Clone, Copy)]
struct Segment {
    start_secs: f32,
    end_secs: f32,
    /// The key at its end.
    after: usize,
    curve: Curve,
}

#[derive(Debug, Clone, Copy)]
enum Curve {
    Constant([f32; 4]),
    Line([f32; 4], [f32; 4]),
    Arc(LibmArc<Quat>),
    Spline,
}

/// The value of a channel of a joint at all times, if all keys are equal and interpolation gives their bits.
fn still(c: &Channel) -> Option<[f32; 4]> {
    if !c.property.is_of_joint() || c.interpolation == Interpolation::CubicSpline {
        return None;
    }
    let width = width(c.property);
    let mut keys = c.values.chunks_exact(width).take(c.times_secs.len());
    let key = keys.next()?;
    if !keys.all(|other| std::iter::zip(key, other).all(|(a, b)| a.to_bits() == b.to_bits())) {
        return None;
    }
    let mut held = [0.0; 4];
    held[..width].copy_from_slice(key);
    let between = match c.property {
        Property::Rotation => {
            let rotation = quat(key);
            held = rotation.to_array();
            let arc = rotation.libm_arc(same_hemisphere(rotation, rotation));
            (!arc.turns()).then(|| quat(&arc.at(0.0).to_array()).to_array())
        }
        // Interpolation adds 0, which changes -0 alone.
        _ => Some(held.map(|a| a + 0.0)).filter(|value| value.iter().all(|a| a.is_finite())),
    };
    let is_held = c.interpolation == Interpolation::Step || c.times_secs.len() == 1;
    let is_same = |between: [f32; 4]| between.map(f32::to_bits) == held.map(f32::to_bits);
    (is_held || between.is_some_and(is_same)).then_some(held)
}

impl Segment {
    /// The first key after a time, which is often that after this segment.
    fn key_after(&self, times: &[f32], time_secs: f32) -> usize {
        let is_next = match times.get(self.after..) {
            Some([start, rest @ ..]) => {
                *start <= time_secs && rest.first().is_none_or(|end| *end > time_secs)
            }
            _ => false,
        };
        match is_next {
            true => self.after + 1,
            false => times.partition_point(|t| *t <= time_secs),
        }
    }

    /// The one that ends at a key, or that after the last one.
    fn before(c: &Channel, after: usize) -> Self {
        let times = &c.times_secs;
        let key = |key: usize| {
            let value = &c.values[key * width(c.property)..][..width(c.property)];
            let mut four = [0.0; 4];
            four[..value.len()].copy_from_slice(value);
            four
        };
        let holds = after == 0 || after == times.len();
        let curve = if c.interpolation == Interpolation::CubicSpline {
            Curve::Spline
        } else if holds || c.interpolation == Interpolation::Step {
            let value = key(after.saturating_sub(1));
            Curve::Constant(match c.property {
                Property::Rotation => quat(&value).to_array(),
                _ => value,
            })
        } else if c.property == Property::Rotation {
            let (a, b) = (quat(&key(after - 1)), quat(&key(after)));
            Curve::Arc(a.libm_arc(same_hemisphere(a, b)))
        } else {
            Curve::Line(key(after - 1), key(after))
        };
        let before = after.checked_sub(1);
        Self {
            start_secs: before.map_or(f32::NEG_INFINITY, |before| times[before]),
            end_secs: times.get(after).copied().unwrap_or(f32::INFINITY),
            after,
            curve,
        }
    }

    fn value(&self, c: &Channel, time_secs: f32) -> [f32; 4] {
        let share = || (time_secs - self.start_secs) / (self.end_secs - self.start_secs);
        match &self.curve {
            Curve::Constant(value) => *value,
            Curve::Line(a, b) => {
                let share = share();
                std::array::from_fn(|i| a[i] + (b[i] - a[i]) * share)
            }
            Curve::Arc(arc) => quat(&arc.at(share()).to_array()).to_array(),
            Curve::Spline => {
                let mut value = [0.0; 4];
                channel(c, time_secs, &mut value[..width(c.property)]);
                value
            }
        }
    }
}

/// Number of floats in a value of a channel of a joint.
fn width(property: Property) -> usize {
    match property {
        Property::Rotation => 4,
        _ => 3,
    }
}

fn quat(value: &[f32]) -> Quat {
    let v = Vec4::from_slice(value);
    let length = v.length();
    if length > 1e-12 {
        Quat::from_vec4(v / length)
    } else {
        Quat::IDENTITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Transform;
    use crate::math::angle_between;
    use crate::source::Joint;
    use proptest::prelude::*;

    fn keys(interpolation: Interpolation, values: Vec<f32>) -> Channel {
        Channel {
            target: 0,
            property: Property::Translation,
            interpolation,
            times_secs: vec![1.0, 3.0],
            values,
        }
    }

    fn at(c: &Channel, time: f32) -> f32 {
        let mut out = [0.0];
        channel(c, time, &mut out);
        out[0]
    }

    #[test]
    fn three_modes_by_hand() {
        let linear = keys(Interpolation::Linear, vec![2.0, 6.0]);
        assert_eq!(
            (at(&linear, 0.0), at(&linear, 2.0), at(&linear, 9.0)),
            (2.0, 4.0, 6.0)
        );
        let step = keys(Interpolation::Step, vec![2.0, 6.0]);
        assert_eq!((at(&step, 2.999), at(&step, 3.0)), (2.0, 6.0));
        // Hermite from 0 to 0 with out-tangent 1/s over 2 s: at the middle 2 * 0.125 = 0.25.
        let cubic = keys(
            Interpolation::CubicSpline,
            vec![0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
        );
        assert!((at(&cubic, 2.0) - 0.25).abs() < 1e-6);
        assert_eq!((at(&cubic, 1.0), at(&cubic, 3.0)), (0.0, 0.0));
    }

    #[test]
    fn rotations_slerp_on_the_short_way() {
        let b = -Quat::from_rotation_y(1.0);
        let c = Channel {
            property: Property::Rotation,
            values: [Quat::IDENTITY.to_array(), b.to_array()].concat(),
            ..keys(Interpolation::Linear, vec![])
        };
        let mut out = [0.0; 4];
        channel(&c, 1.5, &mut out);
        assert!(angle_between(Quat::from_array(out), Quat::from_rotation_y(0.25)) < 1e-5);
    }

    fn any_channel() -> impl Strategy<Value = Channel> {
        let property = prop_oneof![
            Just(Property::Translation),
            Just(Property::Rotation),
            Just(Property::Scale)
        ];
        let interpolation = prop_oneof![
            Just(Interpolation::Linear),
            Just(Interpolation::Step),
            Just(Interpolation::CubicSpline)
        ];
        let steps = prop::collection::vec(0.01f32..0.5, 1..6);
        let values = prop::collection::vec(-1.0f32..1.0, 60);
        let still = any::<bool>();
        (0..3usize, property, interpolation, steps, values, still).prop_map(
            |(target, property, interpolation, steps, mut values, is_still)| {
                let parts = if interpolation == Interpolation::CubicSpline {
                    3
                } else {
                    1
                };
                values.truncate(steps.len() * parts * width(property));
                if is_still {
                    let key = values[..width(property)].to_vec();
                    values
                        .chunks_exact_mut(key.len())
                        .for_each(|other| other.copy_from_slice(&key));
                }
                let times_secs = steps.iter().scan(-0.1, |secs, step| {
                    *secs += step;
                    Some(*secs)
                });
                Channel {
                    target,
                    property,
                    interpolation,
                    times_secs: times_secs.collect(),
                    values,
                }
            },
        )
    }

    proptest! {
        #[test]
        fn a_sampler_has_the_bits_of_single_poses(
            channels in prop::collection::vec(any_channel(), 0..6),
            mut times in prop::collection::vec(-0.2f32..2.5, 1..20),
            is_sorted: bool,
        ) {
            let joint = |name: &str| Joint {
                name: name.into(),
                parent: None,
                rest: Transform::from_translation(Vec3::Y),
                in_skin: false,
            };
            let skeleton = Skeleton { joints: ["a", "b", "c"].map(joint).to_vec() };
            let on_keys = channels.iter().flat_map(|c| &c.times_secs).copied();
            times.extend(on_keys.collect::<Vec<_>>());
            if is_sorted {
                times.sort_by(f32::total_cmp);
            }
            let clip = RawClip { name: String::new(), duration_secs: 2.0, channels };
            let mut sampler = Sampler::new(&clip, &skeleton);
            let mut wanted: LocalPose = [Transform::IDENTITY; 3].into_iter().collect();
            let mut found = wanted.clone();
            for secs in times {
                pose(&clip, &skeleton, secs, &mut wanted);
                sampler.pose(secs, &mut found);
                let bits = |pose: &LocalPose| -> Vec<u32> {
                    let joints = 0..3;
                    let floats = joints.flat_map(|j| {
                        let rotation = pose.rotations[j].to_array();
                        let [moved, scale] = [pose.translations[j], pose.scales[j]];
                        rotation.into_iter().chain(moved.to_array()).chain(scale.to_array())
                    });
                    floats.map(f32::to_bits).collect()
                };
                prop_assert_eq!(bits(&wanted), bits(&found));
            }
        }
    }
}
