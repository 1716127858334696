//! Channels of one morph weight each, combined into one channel of all weights of a mesh.
//!
//! Source: KHR_animation_pointer, `/nodes/{}/weights/{}` and `/meshes/{}/weights/{}`. Weights
//! without a channel keep their defaults.

use super::place::Place;
use super::reader::Reader;
use crate::error::ReadError;
use articula_core::source::{Channel, Interpolation, Property, evaluate};
use std::collections::BTreeMap;

/// Time between the samples of a cubic curve that is combined with curves of other key times.
const SAMPLE_SECS: f32 = 1.0 / 60.0;
/// Maximum number of samples between two keys.
const MAX_SAMPLES: f32 = 64.0;

/// The channels of the weights of each mesh, by mesh and by morph target, with one value per key.
pub(super) type SingleWeights = BTreeMap<usize, BTreeMap<usize, Channel>>;

/// Returns the channel of all weights of a mesh; `rest` are the default weights.
///
/// Curves of equal times and interpolation are combined exactly, and so are linear curves, or
/// steps, of any times. Else the result is linear: steps become steep, cubic curves are sampled.
pub(super) fn combined(
    reader: &mut Reader<'_>,
    place: &Place<'_>,
    (mesh, rest): (usize, &[f32]),
    of_weight: BTreeMap<usize, Channel>,
) -> Result<Option<Channel>, ReadError> {
    let Some(first) = of_weight.values().next() else {
        return Ok(None);
    };
    let interpolation = first.interpolation;
    let alike = of_weight.values().all(|c| c.interpolation == interpolation);
    let in_step = of_weight.values().all(|c| c.times_secs == first.times_secs);
    if alike && (in_step || interpolation != Interpolation::CubicSpline) {
        let times_secs = times(of_weight.values());
        let parts = if interpolation == Interpolation::CubicSpline {
            3
        } else {
            1
        };
        reader.charge(place, (times_secs.len() * parts * rest.len()) as u64)?;
        let mut values = Vec::with_capacity(times_secs.len() * parts * rest.len());
        for (key, &time) in times_secs.iter().enumerate() {
            for part in 0..parts {
                let before = values.len();
                // The tangents of weights without a channel are 0.
                let is_value = part == parts / 2;
                values.extend(rest.iter().map(|w| if is_value { *w } else { 0.0 }));
                for (&weight, channel) in &of_weight {
                    values[before + weight] = match parts {
                        1 => value_at(channel, time),
                        _ => channel.values[key * parts + part],
                    };
                }
            }
        }
        return Ok(Some(Channel {
            target: mesh,
            property: Property::Weights,
            interpolation,
            times_secs,
            values,
        }));
    }
    let what = "single weights of different interpolation or key times are combined into a linear \
                curve; cubic curves are sampled";
    reader.warn(place, what);
    let mut linear = BTreeMap::new();
    for (weight, channel) in of_weight {
        linear.insert(weight, linearised(reader, place, channel)?);
    }
    combined(reader, place, (mesh, rest), linear)
}

fn times<'a>(channels: impl Iterator<Item = &'a Channel>) -> Vec<f32> {
    let mut times: Vec<f32> = channels
        .flat_map(|c| c.times_secs.iter().copied())
        .collect();
    times.sort_by(f32::total_cmp);
    times.dedup();
    times
}

fn value_at(channel: &Channel, time_secs: f32) -> f32 {
    let mut value = [0.0];
    evaluate::channel(channel, time_secs, &mut value);
    value[0]
}

/// Returns a linear curve with nearly the same values.
fn linearised(
    reader: &mut Reader<'_>,
    place: &Place<'_>,
    channel: Channel,
) -> Result<Channel, ReadError> {
    let keys = &channel.times_secs;
    let mut times_secs = Vec::new();
    for (i, &key) in keys.iter().enumerate() {
        if let Some(&before) = i.checked_sub(1).and_then(|i| keys.get(i)) {
            match channel.interpolation {
                Interpolation::Linear => {}
                Interpolation::Step => times_secs.push(key.next_down()),
                Interpolation::CubicSpline => {
                    let samples = ((key - before) / SAMPLE_SECS).ceil().min(MAX_SAMPLES);
                    let step = (key - before) / samples;
                    reader.charge(place, samples as u64)?;
                    let between = (1..samples as usize).map(|n| before + step * n as f32);
                    // Very long spans overflow, very short ones have no time in between.
                    times_secs.extend(between.filter(|time| before < *time && *time < key));
                }
            }
        }
        times_secs.push(key);
    }
    times_secs.dedup();
    let values = times_secs.iter().map(|time| value_at(&channel, *time));
    Ok(Channel {
        values: values.collect(),
        interpolation: Interpolation::Linear,
        times_secs,
        ..channel
    })
}
