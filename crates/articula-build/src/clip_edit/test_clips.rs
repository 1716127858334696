//! Clips for the tests of this folder: hand-made and random.

use super::channel;
use articula_core::source::{
    Channel, Character, Interpolation, Joint, Property, RawClip, Skeleton,
};
use articula_core::{Articulation, JointArticulation, Region, Transform, same_hemisphere};
use glam::{Quat, Vec3, Vec4};
use proptest::prelude::*;

/// One channel that moves joint 0 along x.
pub(super) fn line(times_secs: &[f32], x: &[f32]) -> RawClip {
    RawClip {
        name: "line".into(),
        duration_secs: *times_secs.last().unwrap(),
        channels: vec![Channel {
            target: 0,
            property: Property::Translation,
            interpolation: Interpolation::Linear,
            times_secs: times_secs.to_vec(),
            values: x.iter().flat_map(|x| [*x, 0.0, 0.0]).collect(),
        }],
    }
}

/// Joints in a row along x, a metre apart, without skin.
pub(super) fn bar(joints: usize) -> (Character, Articulation) {
    let joint = |j: usize| Joint {
        name: format!("j{j}"),
        parent: j.checked_sub(1),
        rest: Transform::from_translation(if j == 0 { Vec3::ZERO } else { Vec3::X }),
        in_skin: true,
    };
    let entry = JointArticulation {
        hanim: None,
        level: 0,
        region: Region::Torso,
    };
    let character = Character {
        skeleton: Skeleton {
            joints: (0..joints).map(joint).collect(),
        },
        ..Character::default()
    };
    let articulation = Articulation {
        profile: String::new(),
        joints: vec![entry; joints],
    };
    (character, articulation)
}

/// Channels of every property and interpolation that end together.
pub(super) fn clips() -> impl Strategy<Value = RawClip> {
    prop::collection::vec((0usize..5, 0usize..3, keys()), 1..6).prop_map(|list| {
        let channels = list
            .into_iter()
            .enumerate()
            .map(|(target, (what, how, keys))| {
                let property = [
                    Property::Translation,
                    Property::Rotation,
                    Property::Scale,
                    Property::Weights,
                    Property::Expression,
                ][what];
                let interpolation = [
                    Interpolation::Linear,
                    Interpolation::Step,
                    Interpolation::CubicSpline,
                ][how];
                channel_of(target, property, interpolation, &keys)
            });
        let channels: Vec<Channel> = channels.collect();
        let ends = channels.iter().filter_map(|c| c.times_secs.last());
        let mut clip = RawClip {
            name: "random".into(),
            duration_secs: ends.copied().fold(0.0, f32::max),
            channels,
        };
        // Clips of nearly zero length are tested by hand.
        clip.duration_secs = clip.duration_secs.max(0.5);
        channel::keep_length(&mut clip);
        clip
    })
}

/// Gaps between keys, and for each key twelve numbers from -1 to 1.
fn keys() -> impl Strategy<Value = Vec<(f32, Vec<f32>)>> {
    prop::collection::vec(
        (0.02f32..0.6, prop::collection::vec(-1.0f32..1.0, 12)),
        1..12,
    )
}

fn channel_of(
    target: usize,
    property: Property,
    interpolation: Interpolation,
    keys: &[(f32, Vec<f32>)],
) -> Channel {
    let width = match property {
        Property::Rotation => 4,
        Property::Translation | Property::Scale => 3,
        Property::Weights => 2,
        Property::Expression => 1,
    };
    let mut time = -keys[0].0;
    let mut before = Quat::IDENTITY;
    let (mut times_secs, mut values) = (Vec::new(), Vec::new());
    for (gap, numbers) in keys {
        time += gap;
        times_secs.push(time);
        let value = if property == Property::Rotation {
            let turn = Quat::from_vec4(Vec4::from_slice(numbers).normalize_or(Vec4::W));
            // Rotations of at most 0.6 rad, so that no spline comes near the centre of the sphere.
            let axis = Vec3::new(turn.x, turn.y, turn.z);
            let step = Quat::from_scaled_axis(0.6 * axis);
            before = same_hemisphere(before, (before * step).normalize());
            before.to_array().to_vec()
        } else {
            numbers[..width].to_vec()
        };
        match interpolation {
            Interpolation::CubicSpline => {
                let slope: Vec<f32> = numbers[4..4 + width].to_vec();
                values.extend(&slope);
                values.extend(value);
                values.extend(&slope);
            }
            _ => values.extend(value),
        }
    }
    Channel {
        target,
        property,
        interpolation,
        times_secs,
        values,
    }
}

/// The maximum difference of any float of two clips at 100 times from 0 to `span`, each mapped to
/// the time of either clip; a rotation and its negative are equal.
pub(super) fn greatest_difference(
    a: &RawClip,
    b: &RawClip,
    in_a: impl Fn(f32) -> f32,
    in_b: impl Fn(f32) -> f32,
    span: f32,
) -> f32 {
    let times = (0..=100).map(|i| span * i as f32 / 100.0);
    let apart = times.map(|t| difference(a, b, in_a(t), in_b(t)));
    apart.fold(0.0, f32::max)
}

/// The maximum difference of any float of two clips, each at its own time; a rotation and its
/// negative are equal.
pub(super) fn difference(a: &RawClip, b: &RawClip, in_a: f32, in_b: f32) -> f32 {
    let mut worst = 0.0f32;
    for (ca, cb) in a.channels.iter().zip(&b.channels) {
        // A jump of a step may be on either side because of rounding.
        let jumps = |c: &Channel, t: f32| {
            c.interpolation == Interpolation::Step
                && c.times_secs.iter().any(|k| (k - t).abs() < 1e-4)
        };
        if jumps(ca, in_a) || jumps(cb, in_b) {
            continue;
        }
        let va = channel::value(ca, in_a);
        let mut vb = channel::value(cb, in_b);
        let dot: f32 = va.iter().zip(&vb).map(|(x, y)| x * y).sum();
        if ca.property == Property::Rotation && dot < 0.0 {
            vb.iter_mut().for_each(|v| *v = -*v);
        }
        let difference = va.iter().zip(&vb).map(|(x, y)| (x - y).abs());
        worst = worst.max(difference.fold(0.0, f32::max));
    }
    worst
}
