//! A clip as a compressed document has it, without writing it: its keys, and its size.

use super::element::{Elements, key_times, key_values};
use super::{Compression, KeySteps};
use crate::meshopt::ViewLayout;
use crate::meshopt::encode::{Bitstream, encode};
use articula_core::source::{Channel, RawClip};
use std::collections::{BTreeMap, HashSet};

/// Bytes of JSON of a channel with its sampler and its values, and of an array of times.
const JSON_OF_CHANNEL: usize = 185;
const JSON_OF_TIMES: usize = 125;

/// Returns a clip as it is read from a document that is written with these steps of its channels.
#[must_use]
pub fn rounded_clip(clip: &RawClip, steps: &[KeySteps]) -> RawClip {
    let channels = clip
        .channels
        .iter()
        .zip(steps)
        .map(|(channel, steps)| Channel {
            times_secs: key_times(&channel.times_secs, steps.times_secs).floats(),
            values: key_values(channel, steps.values).floats(),
            ..channel.clone()
        });
    RawClip {
        channels: channels.collect(),
        ..clip.clone()
    }
}

/// Bytes that the keys of a clip need in a document that is written compressed, with the JSON that
/// describes them. `steps` are those of its channels. Clips of one document share views, and so need a
/// little less.
#[must_use]
pub fn compressed_clip_bytes(
    clip: &RawClip,
    steps: &[KeySteps],
    compression: Compression,
) -> usize {
    let mut streams: BTreeMap<(u8, usize), Elements> = BTreeMap::new();
    let mut timelines: HashSet<Vec<u32>> = HashSet::new();
    let mut json = 0;
    for (channel, step) in clip.channels.iter().zip(steps) {
        json += JSON_OF_CHANNEL;
        let times = channel.times_secs.iter().map(|t| t.to_bits()).collect();
        if timelines.insert(times) {
            json += JSON_OF_TIMES;
            add(
                &mut streams,
                key_times(&channel.times_secs, step.times_secs),
            );
        }
        add(&mut streams, key_values(channel, step.values));
    }
    let version = match compression {
        Compression::Khr => Bitstream::V1,
        Compression::Ext | Compression::Quantized | Compression::None => Bitstream::V0,
    };
    let bytes = streams.values().map(|elements| {
        let layout = ViewLayout {
            mode: elements.mode,
            filter: elements.filter,
            count: elements.count as u64,
            stride: elements.stride as u64,
        };
        let is_compressed = compression.is_of_arrays();
        let encoded = is_compressed.then(|| encode(&elements.bytes, &layout, version));
        encoded
            .flatten()
            .map_or(elements.bytes.len(), |encoded| encoded.len())
    });
    json + bytes.sum::<usize>()
}

fn add(streams: &mut BTreeMap<(u8, usize), Elements>, elements: Elements) {
    let kind = (elements.filter as u8, elements.stride);
    match streams.get_mut(&kind) {
        Some(stream) => {
            stream.bytes.extend_from_slice(&elements.bytes);
            stream.count += elements.count;
        }
        None => {
            streams.insert(kind, elements);
        }
    }
}
