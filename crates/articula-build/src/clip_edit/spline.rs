//! Inserts a key into a cubic spline without a change of the curve.
//!
//! Source: the glTF 2.0 specification, appendix C.5. A part of a cubic is a cubic, so for vectors
//! one key with the curve's value and slope is exact. A rotation is the normalised value of such a
//! cubic, which is no cubic itself: its parts get keys on the unit sphere until they agree within
//! [`SAME_RADIANS`].

use articula_core::angle_between;
use articula_core::source::{Channel, Property};
use glam::Quat;

/// Maximum angle between a rotation and the curve that it was cut from.
pub(super) const SAME_RADIANS: f32 = 1e-5;

/// Maximum number of halvings of one interval.
const MAX_HALVINGS: usize = 6;

/// One end of a cubic: value and slope per second.
#[derive(Debug, Clone)]
struct End {
    secs: f32,
    value: Vec<f32>,
    slope: Vec<f32>,
}

/// Inserts a key at a time that has none.
pub(super) fn put_key(channel: &mut Channel, time_secs: f32) {
    let keys = channel.times_secs.len();
    let width = channel.values.len() / (3 * keys);
    let after = channel.times_secs.partition_point(|t| *t < time_secs);
    if after == 0 || after == keys {
        hold(channel, time_secs, width);
        return;
    }
    let [a, b] = [after - 1, after].map(|k| channel.times_secs[k]);
    let at = |k: usize, part: usize| {
        let first = (3 * k + part) * width;
        channel.values[first..first + width].to_vec()
    };
    let whole = [
        End {
            secs: a,
            value: at(after - 1, 1),
            slope: at(after - 1, 2),
        },
        End {
            secs: b,
            value: at(after, 1),
            slope: at(after, 0),
        },
    ];
    let is_rotation = channel.property == Property::Rotation;
    let on_curve = |secs: f32| {
        let end = point(&whole, secs);
        if is_rotation { on_sphere(end) } else { end }
    };
    let mut times = vec![a, time_secs, b];
    if is_rotation {
        times = [refined(&whole, a, time_secs), refined(&whole, time_secs, b)].concat();
        times.dedup();
    }
    let ends: Vec<End> = times.iter().map(|t| on_curve(*t)).collect();
    // The slopes at the old keys are those of the same curve, and change only for rotations.
    set(channel, after - 1, 2, &ends[0].slope);
    set(channel, after, 0, &ends[ends.len() - 1].slope);
    for (i, end) in ends[1..ends.len() - 1].iter().enumerate() {
        insert(
            channel,
            after + i,
            end.secs,
            [&end.slope, &end.value, &end.slope],
        );
    }
}

/// A key before the first or after the last, where the channel holds.
fn hold(channel: &mut Channel, time_secs: f32, width: usize) {
    let keys = channel.times_secs.len();
    let before = time_secs < channel.times_secs[0];
    let (near, slope_part) = if before { (0, 0) } else { (keys - 1, 2) };
    let still = vec![0.0; width];
    // This slope was unused so far and would bend the curve to the new key.
    set(channel, near, slope_part, &still);
    let first = (3 * near + 1) * width;
    let value = channel.values[first..first + width].to_vec();
    let key = if before { 0 } else { keys };
    insert(channel, key, time_secs, [&still, &value, &still]);
}

fn set(channel: &mut Channel, key: usize, part: usize, floats: &[f32]) {
    let first = (3 * key + part) * floats.len();
    channel.values[first..first + floats.len()].copy_from_slice(floats);
}

fn insert(channel: &mut Channel, key: usize, secs: f32, parts: [&[f32]; 3]) {
    channel.times_secs.insert(key, secs);
    let at = 3 * key * parts[0].len();
    channel.values.splice(at..at, parts.concat());
}

/// Value and slope of the cubic between two ends.
fn point([a, b]: &[End; 2], secs: f32) -> End {
    let span = b.secs - a.secs;
    let t = (secs - a.secs) / span;
    let (t2, t3) = (t * t, t * t * t);
    let blend = |f: [f32; 4], i: usize| {
        f[0] * a.value[i] + f[1] * span * a.slope[i] + f[2] * b.value[i] + f[3] * span * b.slope[i]
    };
    let value = [
        2.0 * t3 - 3.0 * t2 + 1.0,
        t3 - 2.0 * t2 + t,
        -2.0 * t3 + 3.0 * t2,
        t3 - t2,
    ];
    let slope = [
        6.0 * t2 - 6.0 * t,
        3.0 * t2 - 4.0 * t + 1.0,
        -6.0 * t2 + 6.0 * t,
        3.0 * t2 - 2.0 * t,
    ];
    End {
        secs,
        value: (0..a.value.len()).map(|i| blend(value, i)).collect(),
        slope: (0..a.value.len()).map(|i| blend(slope, i) / span).collect(),
    }
}

/// The same point of the normalised curve.
fn on_sphere(end: End) -> End {
    let length = end.value.iter().map(|v| v * v).sum::<f32>().sqrt();
    if length < 1e-12 {
        return end;
    }
    let value: Vec<f32> = end.value.iter().map(|v| v / length).collect();
    let along: f32 = value.iter().zip(&end.slope).map(|(v, s)| v * s).sum();
    let slope = value.iter().zip(&end.slope);
    let slope = slope.map(|(v, s)| (s - v * along) / length).collect();
    End {
        secs: end.secs,
        value,
        slope,
    }
}

/// Times from `from` to `to` between which cubics on the sphere follow the curve.
fn refined(whole: &[End; 2], from: f32, to: f32) -> Vec<f32> {
    let mut steps = 1usize;
    loop {
        let time = |i: usize| match i {
            0 => from,
            i if i == steps => to,
            i => from + (to - from) * i as f32 / steps as f32,
        };
        let follows = (0..steps).all(|i| {
            let ends = [time(i), time(i + 1)].map(|t| on_sphere(point(whole, t)));
            [0.25, 0.5, 0.75].iter().all(|u| {
                let t = ends[0].secs + (ends[1].secs - ends[0].secs) * u;
                let [a, b] = [point(whole, t), point(&ends, t)]
                    .map(|end| Quat::from_slice(&on_sphere(end).value));
                angle_between(a, b) <= SAME_RADIANS
            })
        });
        if follows || steps >= 1 << MAX_HALVINGS {
            return (0..=steps).map(time).collect();
        }
        steps *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::source::{Interpolation, evaluate};

    fn channel(property: Property, values: Vec<f32>) -> Channel {
        Channel {
            target: 0,
            property,
            interpolation: Interpolation::CubicSpline,
            times_secs: vec![1.0, 3.0],
            values,
        }
    }

    fn at(c: &Channel, secs: f32) -> Vec<f32> {
        let mut out = vec![0.0; c.values.len() / (3 * c.times_secs.len())];
        evaluate::channel(c, secs, &mut out);
        out
    }

    #[test]
    fn half_of_a_cubic_by_hand() {
        // From 0 to 0 with slope 1 at the start, over 2 s: p(t) = 2 (t^3 - 2 t^2 + t), so at
        // t = 1/2 the value is 0.25 and the slope (3/4 - 2 + 1) = -0.25 a second.
        let mut c = channel(Property::Weights, vec![0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
        put_key(&mut c, 2.0);
        assert_eq!(c.times_secs, [1.0, 2.0, 3.0]);
        assert_eq!(c.values[3..6], [-0.25, 0.25, -0.25]);
    }

    #[test]
    fn before_and_after_its_keys_a_spline_holds() {
        let mut c = channel(Property::Weights, vec![7.0, 1.0, 2.0, 2.0, 4.0, 7.0]);
        let middle = at(&c, 1.7);
        put_key(&mut c, 0.0);
        put_key(&mut c, 4.0);
        for (secs, value) in [(0.0, 1.0), (0.5, 1.0), (3.5, 4.0), (4.0, 4.0)] {
            assert_eq!(at(&c, secs), [value], "{secs}");
        }
        assert!((at(&c, 1.7)[0] - middle[0]).abs() < 1e-6);
    }

    #[test]
    fn a_cut_rotation_turns_as_before() {
        // A fast, uneven turn of 2.2 rad whose cubic leaves the sphere by a third.
        let (a, b) = (
            Quat::IDENTITY,
            Quat::from_rotation_y(2.2) * Quat::from_rotation_x(0.3),
        );
        let slope = [0.3f32, 0.2, -0.1, -0.5];
        let zero = [0.0f32; 4];
        let values = [zero, a.to_array(), slope, slope, b.to_array(), zero].concat();
        let whole = channel(Property::Rotation, values);
        for cut in [1.01f32, 1.5, 2.3, 2.99] {
            let mut c = whole.clone();
            put_key(&mut c, cut);
            assert!(c.times_secs.contains(&cut));
            let worst = (0..=400).map(|i| 1.0 + 2.0 * i as f32 / 400.0).map(|t| {
                let [p, q] = [&whole, &c].map(|c| Quat::from_slice(&at(c, t)));
                angle_between(p, q)
            });
            let worst = worst.fold(0.0, f32::max);
            // The quarter points that are tested come close to the maximum difference.
            assert!(
                worst <= 1.5 * SAME_RADIANS,
                "{worst} after {} keys",
                c.times_secs.len()
            );
        }
    }
}
