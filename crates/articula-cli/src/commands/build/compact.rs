//! `build --compact-clips`: motion streams beside the keys of clips, with sizes and loading times.

use crate::table::Table;
use anyhow::Context;
use articula::Figure;
use articula::build::{ClipOptions, sampled_clip, whole_clip_size};
use articula::formats::{Limits, read_compact_clip};
use articula::stream::StreamLimits;
use articula::stream::abp2::MotionReceiver;
use serde::Serialize;
use std::hint::black_box;
use std::time::Instant;

/// How often a time is taken; the least counts.
const ROUNDS: usize = 5;

/// A clip as keys and as a motion stream.
#[derive(Debug, Serialize)]
pub(super) struct CompactClip {
    /// Size of the stream in bytes.
    bytes: usize,
    /// Size of times and values of the keys in bytes.
    keys_bytes: usize,
    /// Greatest error of the stream over all frames and vertices, in millimetres.
    error_mm: f64,
    /// Time to decode the stream into a clip, in milliseconds on this machine.
    decode_ms: f64,
    /// Time to make the clip of the keys, in milliseconds on this machine.
    resample_ms: f64,
}

impl CompactClip {
    /// Measures a clip whose stored table was just made.
    pub(super) fn measure(
        figure: &Figure,
        clip: usize,
        table: &[u8],
        error_metres: f64,
    ) -> anyhow::Result<Self> {
        let (_, stream) = read_compact_clip(table, &Limits::default())?;
        let asset = &figure.asset;
        let limits = StreamLimits::default();
        let decode_ms = least_ms(|| {
            let received = MotionReceiver::read(stream, &asset.rig, &limits)?;
            black_box(received.clip()?);
            Ok(())
        })?;
        let character = figure.opened.character();
        let raw = &character.clips[clip];
        let options = ClipOptions::default();
        let resample_ms = least_ms(|| {
            black_box(sampled_clip(character, raw, &asset.mesh, &options)?);
            Ok(())
        })
        .with_context(|| format!("clip \"{}\"", raw.name))?;
        Ok(Self {
            bytes: stream.len(),
            keys_bytes: whole_clip_size(raw).bytes,
            error_mm: 1e3 * error_metres,
            decode_ms,
            resample_ms,
        })
    }
}

fn least_ms(mut each: impl FnMut() -> anyhow::Result<()>) -> anyhow::Result<f64> {
    let mut least = f64::INFINITY;
    for _ in 0..ROUNDS {
        let start = Instant::now();
        each()?;
        least = least.min(1e3 * start.elapsed().as_secs_f64());
    }
    Ok(least)
}

/// Table of the streams, if there are any.
pub(super) fn text<'a>(clips: impl Iterator<Item = (&'a str, &'a CompactClip)>) -> String {
    let mut table = Table::new(&[
        "motion stream",
        "bytes",
        "bytes of keys",
        "max error mm",
        "ms to decode",
        "ms from keys",
    ]);
    for (name, clip) in clips {
        table.row([
            name.to_owned(),
            clip.bytes.to_string(),
            clip.keys_bytes.to_string(),
            format!("{:.3}", clip.error_mm),
            format!("{:.2}", clip.decode_ms),
            format!("{:.2}", clip.resample_ms),
        ]);
    }
    if table.is_empty() {
        return String::new();
    }
    format!("\n{}", table.text())
}
