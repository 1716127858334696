//! Exact evaluation of keyed channels at any time, as defined by appendix C of the glTF 2.0
//! specification.
//!
//! Linear rotations use spherical interpolation along the shorter arc; cubic ones are Hermite
//! splines, normalised afterwards. A channel holds its first value before its first key and its
//! last value after its last key.

use super::{Channel, Interpolation, Property, RawClip, Skeleton};
use crate::LibmQuat;
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
    use crate::math::angle_between;

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
}
