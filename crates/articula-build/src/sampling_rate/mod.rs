//! The rate at which frames of a clip represent its keys.
//!
//! A clip whose keys lie on the grid of its usual key interval gets that rate, multiplied where it
//! turns so fast that blends of frames would leave it; if there are less than 20 keys a second, the lowest
//! multiple whose frames [follow](deviation) the keys. Every other clip gets the lowest of the
//! [candidates](candidates) that does so: hand-set and thinned keys lie on a finer grid than their
//! usual interval, keys that begin late between the frames of one that begins at 0, and splines bend
//! between keys.

mod candidates;
mod deviation;

use crate::key_times::rising;
use articula_core::source::evaluate::ChannelSampler;
use articula_core::source::{Channel, Interpolation, Property, RawClip, Skeleton};
use articula_core::{angle_between, nlerp};
use deviation::Follower;
use glam::{Quat, Vec3};

pub use deviation::sampling_bound_metres;

/// Greatest difference of rates that are taken to be one.
const NEAR_SHARE: f32 = 5e-3;

/// Common authoring rates; a key grid near one is taken to be it.
const USUAL_RATES_HZ: [f32; 14] = [
    10.0, 12.0, 15.0, 20.0, 24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 90.0, 100.0, 120.0, 240.0,
];

/// Maximum rate to which that of regular keys is multiplied.
const MAX_MULTIPLIED_HZ: f32 = 120.0;

/// Least rate of regular keys that are taken to be the frames of a capture or of a baked clip. Between
/// sparser ones joints turn so far that blends lag visibly.
const BAKED_HZ: f32 = 20.0;

/// Maximum difference between a clip of regular keys and its source between frames; on a limb of
/// 0.4 m, about two millimetres. A joint that turns by 60 degrees in a frame stays below it under a
/// normalised linear blend.
const CHORD_RADIANS: f32 = 5e-3;
/// As a share of the figure's extent; a millimetre on an adult.
const CHORD_SHARE: f32 = 6e-4;
/// Of scales.
const CHORD_SCALE: f32 = 1e-3;

/// Distance of a key from a frame, in frames, within which it lies on the grid.
const ON_GRID_FRAMES: f64 = 1e-3;

/// A rate, and the number of its frames per key where the keys are regular.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SamplingRate {
    pub(crate) rate_hz: f32,
    pub(crate) frames_per_key: usize,
}

/// Returns the rate in hertz at which a clip was keyed: that of its most densely keyed channel, from 1
/// to 240, or 30 where there are fewer than three keys. A usual rate within half a percent stands for
/// it, unless it would have another number of frames over the keys. Frames at this rate may miss keys:
/// see [`sampling_rate_hz`](crate::sampling_rate_hz).
pub fn source_rate_hz(clip: &RawClip) -> f32 {
    let densest = clip.channels.iter().max_by_key(|c| c.times_secs.len());
    let Some(channel) = densest.filter(|c| c.times_secs.len() > 2) else {
        return 30.0;
    };
    let times = &channel.times_secs;
    let mut gaps: Vec<f32> = times.windows(2).map(|w| w[1] - w[0]).collect();
    gaps.sort_by(f32::total_cmp);
    // The median is robust against exporters that thin out keys or start late.
    let median = 1.0 / gaps[gaps.len() / 2].max(1e-4);
    let is_near = |a: f32, b: f32| (a / b - 1.0).abs() < NEAR_SHARE;
    // Without gaps, the number of keys tells more than the rounded times do: 654 rows of 0.008342 s
    // are not rows of 120 Hz.
    let (count, span) = (gaps.len() as f32, times[times.len() - 1] - times[0]);
    let is_whole = is_near(count / span, median);
    let rate = if is_whole { count / span } else { median };
    let has_keys = |usual: f32| !is_whole || (usual * span - count).abs() < 0.5;
    let usual = USUAL_RATES_HZ
        .into_iter()
        .find(|usual| is_near(*usual, median) && has_keys(*usual));
    usual.unwrap_or(rate.clamp(1.0, 240.0))
}

/// Chooses the rate of a checked clip whose frames are blended by normalised linear interpolation.
/// Rates that do not `fit` in memory are not chosen unless none does.
pub(crate) fn blended_rate(
    clip: &RawClip,
    skeleton: &Skeleton,
    fits: &dyn Fn(f32) -> bool,
) -> SamplingRate {
    let keyed = source_rate_hz(clip);
    let mut frames_per_key = multiple(clip, &skeleton.local_extents());
    while frames_per_key > 1 && !fits(keyed * frames_per_key as f32) {
        frames_per_key /= 2;
    }
    let usual = SamplingRate {
        rate_hz: keyed * frames_per_key as f32,
        frames_per_key,
    };
    chosen(clip, skeleton, usual, BAKED_HZ, fits)
}

/// As [`blended_rate`], of frames that are keys of channels, between which rotations are interpolated
/// spherically: regular keys keep their rate.
pub(crate) fn keyed_rate(
    clip: &RawClip,
    skeleton: &Skeleton,
    fits: &dyn Fn(f32) -> bool,
) -> SamplingRate {
    let usual = SamplingRate {
        rate_hz: source_rate_hz(clip),
        frames_per_key: 1,
    };
    chosen(clip, skeleton, usual, 0.0, fits)
}

/// The usual rate if keys are regular, at `regular_hz` or more, or if its frames follow them; otherwise
/// the best candidate.
fn chosen(
    clip: &RawClip,
    skeleton: &Skeleton,
    usual: SamplingRate,
    regular_hz: f32,
    fits: &dyn Fn(f32) -> bool,
) -> SamplingRate {
    let keyed = source_rate_hz(clip);
    let keys = corners(clip);
    let duration = clip.duration_secs;
    let is_regular = is_on_grid(&keys, duration, keyed);
    let is_plain = |c: &Channel| match c.interpolation {
        Interpolation::Linear => c.jump_times().next().is_none(),
        Interpolation::Step => true,
        Interpolation::CubicSpline => false,
    };
    let is_regular_and_plain = is_regular && clip.channels.iter().all(is_plain);
    if is_regular_and_plain && keyed >= regular_hz || !fits(usual.rate_hz) {
        return usual;
    }
    let mut follower = Follower::new(clip, skeleton);
    if follower.follows(usual.rate_hz) {
        return usual;
    }
    let rates = match is_regular_and_plain {
        true => candidates::multiples(keyed),
        false => candidates::rates(&keys, duration, keyed),
    };
    let rates: Vec<f32> = rates.into_iter().filter(|r| fits(*r)).collect();
    let rate_hz = follower.best(&rates).unwrap_or(usual.rate_hz);
    let times = (rate_hz / keyed).round();
    let is_multiple = is_regular && (times * keyed / rate_hz - 1.0).abs() < 1e-5;
    SamplingRate {
        rate_hz,
        frames_per_key: if is_multiple { times as usize } else { 1 },
    }
}

/// Times of the frames of a clip at about a rate, from 0 to its end, which is one of them: the rate
/// is scaled by less than half a frame. The frame of a jump is at the time of its key. Returns the
/// scaled rate too; `steps` is the number of intervals.
pub(crate) fn frame_times(clip: &RawClip, wanted: f32, steps: usize) -> (f32, Vec<f32>) {
    if steps == 0 {
        return (wanted, vec![0.0]);
    }
    let duration = clip.duration_secs;
    let rate = steps as f32 / duration;
    let mut times: Vec<f32> = (0..=steps)
        .map(|i| duration * (i as f32 / steps as f32))
        .collect();
    for channel in &clip.channels {
        for jump in channel.jump_times() {
            let frame = (jump * rate).round() as usize;
            if let Some(time) = times.get_mut(frame) {
                *time = frame_time(channel, true, *time, rate);
            }
        }
    }
    (rate, times)
}

/// The rate at which frame `steps` is the end; `wanted` if the two differ by rounding alone.
pub(crate) fn exact_rate(steps: usize, duration: f32, wanted: f32) -> f32 {
    let exact = steps as f32 / duration;
    if (exact / wanted - 1.0).abs() < 1e-5 {
        wanted
    } else {
        exact
    }
}

/// Time at which a channel that `jumps` is evaluated for a frame: that of the key which the frame
/// shows, where the two differ by rounding alone.
pub(crate) fn frame_time(channel: &Channel, jumps: bool, time: f32, rate: f32) -> f32 {
    if !jumps {
        return time;
    }
    let near = ON_GRID_FRAMES as f32 / rate;
    let times = &channel.times_secs;
    let after = times.partition_point(|t| *t <= time + near);
    match after.checked_sub(1) {
        Some(key) if times[key] >= time - near => times[key],
        _ => time,
    }
}

/// All key times between which the clip may bend, rising: of a jump the later key.
fn corners(clip: &RawClip) -> Vec<f32> {
    let mut all = Vec::new();
    for channel in &clip.channels {
        let times = &channel.times_secs;
        let mut jumps = channel.jump_times().peekable();
        for (i, time) in times.iter().enumerate() {
            let is_next_jump = times.get(i + 1).is_some() && times.get(i + 1) == jumps.peek();
            if is_next_jump {
                jumps.next();
            }
            let is_step = channel.interpolation == Interpolation::Step;
            if time.is_finite() && (is_step || !is_next_jump) {
                all.push(*time);
            }
        }
    }
    rising(all)
}

/// Whether all keys are frames of a rate, which is scaled so that the end is a frame.
fn is_on_grid(keys: &[f32], duration: f32, rate: f32) -> bool {
    let steps = (f64::from(duration) * f64::from(rate)).round();
    if steps < 1.0 {
        return true;
    }
    // Not the rounded rate: over many frames, rows of 0.0083333 s leave those of 120 Hz.
    let rate = steps / f64::from(duration);
    keys.iter().all(|t| {
        let at = f64::from(*t) * rate;
        (at - at.round()).abs() <= ON_GRID_FRAMES + 2.0 * f64::from(f32::EPSILON) * at
    })
}

/// Number of frames per key interval with which straight lines (and normalised linear blends)
/// follow regular keys within [`CHORD_SHARE`] and [`CHORD_RADIANS`].
fn multiple(clip: &RawClip, extents: &[f32]) -> usize {
    let rate = source_rate_hz(clip);
    let mut factor = 1;
    while factor < 8
        && rate * (factor * 2) as f32 <= MAX_MULTIPLIED_HZ
        && curves(clip, extents, rate * factor as f32)
    {
        factor *= 2;
    }
    factor
}

/// Whether any channel leaves the chord between neighbouring frames by more than the bounds.
fn curves(clip: &RawClip, extents: &[f32], rate: f32) -> bool {
    let frames = (clip.duration_secs * rate).ceil().clamp(0.0, 1e5) as usize;
    clip.channels
        .iter()
        .filter(|c| c.interpolation != Interpolation::Step && c.property.is_of_joint())
        .any(|c| {
            let bound = match c.property {
                Property::Rotation => CHORD_RADIANS,
                Property::Scale => CHORD_SCALE,
                _ => CHORD_SHARE * extents[c.target],
            };
            let time = |i: usize| i as f32 / rate;
            let mut sampler = ChannelSampler::new(c);
            let mut from = sampler.value(time(0));
            (0..frames).any(|i| {
                // Rising times, so that neighbouring ones share what their keys have in common.
                let (start, end) = (time(i), time(i + 1));
                let inner = QUARTERS.map(|u| sampler.value(start + (end - start) * u));
                let to = sampler.value(end);
                let leaves = leaves_chord(c.property, [from, to], inner, bound);
                from = to;
                leaves
            })
        })
}

/// Where curves are compared with their chords. Keys inside the interval are corners, which no chord follows; the
/// quarter points detect the curvature of splines and of fast turns.
const QUARTERS: [f32; 3] = [0.25, 0.5, 0.75];

/// Whether a value at a quarter is farther from the chord between two values than the bound.
fn leaves_chord(
    property: Property,
    [a, b]: [[f32; 4]; 2],
    inner: [[f32; 4]; 3],
    bound: f32,
) -> bool {
    QUARTERS.iter().zip(inner).any(|(&u, m)| {
        if property == Property::Rotation {
            let chord = nlerp(Quat::from_array(a), Quat::from_array(b), u);
            return angle_between(chord, Quat::from_array(m)) > bound;
        }
        let [a, m, b] = [a, m, b].map(|v| Vec3::from_slice(&v));
        (a.lerp(b, u) - m).length() > bound
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::Transform;
    use articula_core::source::Joint;

    /// A joint at half a metre from the root that turns by an angle from key to key.
    fn turning(count: usize, step_secs: f32, step_radians: f32) -> (RawClip, Skeleton) {
        let times_secs: Vec<f32> = (0..count).map(|i| i as f32 * step_secs).collect();
        let turn = |i: usize| Quat::from_rotation_z(i as f32 * step_radians).to_array();
        let clip = RawClip {
            duration_secs: times_secs[count - 1],
            channels: vec![Channel {
                target: 0,
                property: Property::Rotation,
                interpolation: Interpolation::Linear,
                times_secs,
                values: (0..count).flat_map(turn).collect(),
            }],
            ..RawClip::default()
        };
        let joint = |name: &str, parent, y| Joint {
            name: name.to_owned(),
            parent,
            rest: Transform {
                translation: Vec3::Y * y,
                ..Transform::IDENTITY
            },
            in_skin: true,
        };
        let joints = vec![joint("a", None, 0.0), joint("b", Some(0), 0.5)];
        (clip, Skeleton { joints })
    }

    #[test]
    fn rounded_frame_times_are_regular_however_long_the_clip() {
        for (step_secs, rate_hz) in [(0.008_333_3, 120.0), (0.033_333, 30.0), (0.016_67, 60.0)] {
            let (clip, skeleton) = turning(2000, step_secs, 0.2);
            let found = keyed_rate(&clip, &skeleton, &|_| true);
            assert!((found.rate_hz / rate_hz - 1.0).abs() < 1e-3, "{found:?}");
            assert_eq!(found.frames_per_key, 1);
        }
    }

    #[test]
    fn sparse_regular_keys_get_the_frames_that_they_need() {
        let rate = |step_secs: f32, step_radians| {
            let (clip, skeleton) = turning(9, step_secs, step_radians);
            blended_rate(&clip, &skeleton, &|_| true)
        };
        // A quarter turn between keys half a second apart, at 0.5 m: a normalised linear blend of
        // two frames that are apart by a small angle a lags by at most a^3 / 249 (series of the arc tangent).
        let fast = rate(0.5, 1.5);
        let angle = 1.5 / fast.frames_per_key as f32;
        assert!((fast.rate_hz / (2.0 * fast.frames_per_key as f32) - 1.0).abs() < 1e-4);
        assert!(0.5 * angle.powi(3) / 249.0 < 1.0e-4, "{fast:?}");
        let one_less = 1.5 / (fast.frames_per_key - 1) as f32;
        assert!(0.5 * one_less.powi(3) / 249.0 > 0.5e-4, "{fast:?}");
        // Slow turns, and the keys of captures, keep their rate.
        assert_eq!(rate(0.5, 0.05).frames_per_key, 1);
        assert_eq!(rate(1.0 / 30.0, 0.4).frames_per_key, 1);
    }
}
