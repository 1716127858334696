//! Operations on one channel: the floats of its keys, its value at a time, inserting a key without
//! a change of the motion.

use super::spline;
use crate::key_times::SAME_SECS;
use articula_core::Mismatch;
use articula_core::source::{Channel, Interpolation, RawClip, evaluate};

/// Number of float arrays per key: in-tangent, value and out-tangent, or the value alone.
pub(crate) fn parts(interpolation: Interpolation) -> usize {
    match interpolation {
        Interpolation::CubicSpline => 3,
        _ => 1,
    }
}

/// Number of floats in one value of a checked channel.
pub(crate) fn width(channel: &Channel) -> usize {
    channel.values.len() / (channel.times_secs.len() * parts(channel.interpolation))
}

/// Rejects channels without keys, with times that do not increase, or with floats that are not
/// finite.
///
/// # Errors
/// A [`Mismatch`] that names the channel.
pub(crate) fn check(clip: &RawClip) -> Result<(), Mismatch> {
    let wrong = |at: String, what: &str| Err(Mismatch::new(at, what));
    if !(clip.duration_secs.is_finite() && clip.duration_secs >= 0.0) {
        return wrong(
            format!("clip \"{}\"", clip.name),
            "duration_secs must be finite and at least 0",
        );
    }
    for (c, channel) in clip.channels.iter().enumerate() {
        let at = || format!("clip \"{}\".channels[{c}]", clip.name);
        let times = &channel.times_secs;
        let unit = times.len() * parts(channel.interpolation);
        if unit == 0 || channel.values.is_empty() || !channel.values.len().is_multiple_of(unit) {
            let what = format!("{} values for {} keys", channel.values.len(), times.len());
            return wrong(at(), &what);
        }
        let rise = times.windows(2).all(|w| w[0] < w[1]);
        if !rise || !times.iter().all(|t| t.is_finite()) {
            return wrong(at(), "the key times must be finite and rise");
        }
        if !channel.values.iter().all(|v| v.is_finite()) {
            return wrong(at(), "the key values must be finite");
        }
    }
    Ok(())
}

/// The exact value at a time.
pub(crate) fn value(channel: &Channel, time_secs: f32) -> Vec<f32> {
    let mut out = vec![0.0; width(channel)];
    evaluate::channel(channel, time_secs, &mut out);
    out
}

/// The value stored with a key.
pub(crate) fn key_value(channel: &Channel, key: usize) -> &[f32] {
    let width = width(channel);
    let parts = parts(channel.interpolation);
    let first = (key * parts + parts / 2) * width;
    &channel.values[first..first + width]
}

/// The value stored with a key, mutable.
pub(crate) fn key_value_mut(channel: &mut Channel, key: usize) -> &mut [f32] {
    let width = width(channel);
    let parts = parts(channel.interpolation);
    let first = (key * parts + parts / 2) * width;
    &mut channel.values[first..first + width]
}

/// The key at a time, if there is one.
pub(crate) fn key_at(channel: &Channel, time_secs: f32) -> Option<usize> {
    let times = &channel.times_secs;
    let after = times.partition_point(|t| *t < time_secs - SAME_SECS);
    (after < times.len() && times[after] <= time_secs + SAME_SECS).then_some(after)
}

/// Inserts a key at a time without changing the motion and returns its index. Splines of rotations
/// get more than one key where that is needed to keep the curve (see [`spline`]).
pub(crate) fn put_key(channel: &mut Channel, time_secs: f32) -> usize {
    if let Some(key) = key_at(channel, time_secs) {
        return key;
    }
    if channel.interpolation == Interpolation::CubicSpline {
        spline::put_key(channel, time_secs);
    } else {
        let value = value(channel, time_secs);
        let key = channel.times_secs.partition_point(|t| *t < time_secs);
        channel.times_secs.insert(key, time_secs);
        let at = key * value.len();
        channel.values.splice(at..at, value);
    }
    channel.times_secs.partition_point(|t| *t < time_secs)
}

/// Gives a channel a key at the end of the clip if no channel has one: file formats store the
/// length of a clip as the time of its last key.
pub(crate) fn keep_length(clip: &mut RawClip) {
    let end = clip.duration_secs;
    let reaches = |c: &Channel| c.times_secs.last().is_some_and(|t| *t >= end - SAME_SECS);
    if clip.channels.iter().any(reaches) {
        return;
    }
    // A spline would need a tangent there; any other channel will do.
    let plain = |c: &&mut Channel| c.interpolation != Interpolation::CubicSpline;
    if let Some(channel) = clip.channels.iter_mut().find(plain) {
        put_key(channel, end);
    } else if let Some(channel) = clip.channels.first_mut() {
        put_key(channel, end);
    }
}
