//! Clips as they read after their values were rounded, without writing them.
//!
//! Close to what [`write_compressed`](articula_formats::gltf::Document::write_compressed) stores: the
//! written file is measured again.

use articula_core::source::{Channel, Interpolation, Property, RawClip};
use articula_formats::gltf::{KeySteps, key_time_step, rotation_units};

/// A clip whose values are rounded to the steps of their channels.
pub(super) fn rounded(clip: &RawClip, steps: &[KeySteps]) -> RawClip {
    let channels = clip.channels.iter().zip(steps);
    RawClip {
        channels: channels.map(|(c, step)| of_channel(c, *step)).collect(),
        ..clip.clone()
    }
}

fn of_channel(channel: &Channel, steps: KeySteps) -> Channel {
    let mut out = channel.clone();
    let unit = power_below(key_time_step(&out.times_secs, steps.times_secs));
    let times = out.times_secs.iter().map(|t| (t / unit).round() * unit);
    let times: Vec<f32> = times.collect();
    if times.is_sorted_by(|a, b| a < b) {
        out.times_secs = times;
    }
    if channel.interpolation == Interpolation::CubicSpline
        || channel.property == Property::Expression
    {
        return out;
    }
    // Only the times are rounded.
    if steps.values == 0.0 {
        return out;
    }
    if channel.property == Property::Rotation {
        let turns = out.values.as_chunks_mut::<4>().0;
        turns
            .iter_mut()
            .for_each(|q| *q = rotation(*q, steps.values));
        return out;
    }
    let unit = power_below(steps.values);
    for x in &mut out.values {
        *x = (*x / unit).round() * unit;
    }
    out
}

/// Three components rounded, the largest as the others leave it.
fn rotation(q: [f32; 4], step: f32) -> [f32; 4] {
    let units = rotation_units(step);
    let largest = (0..4)
        .max_by(|a, b| q[*a].abs().total_cmp(&q[*b].abs()))
        .unwrap_or(3);
    let sign = if q[largest] < 0.0 { -1.0 } else { 1.0 };
    let mut out = q.map(|x| {
        let scaled = sign * x * std::f32::consts::SQRT_2 * units;
        scaled.round() / (std::f32::consts::SQRT_2 * units)
    });
    let rest: f32 = (0..4)
        .filter(|i| *i != largest)
        .map(|i| out[i] * out[i])
        .sum();
    out[largest] = (1.0 - rest).max(0.0).sqrt();
    out
}

/// The largest power of two that is at most `step`.
fn power_below(step: f32) -> f32 {
    f32::from_bits(step.max(f32::MIN_POSITIVE).to_bits() & 0xff80_0000)
}
