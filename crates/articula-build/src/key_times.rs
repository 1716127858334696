//! Equality and order of key times.

use articula_core::source::{Channel, RawClip};

/// Two times of a clip that differ by less than this are equal: after half a minute single
/// precision does not resolve more.
pub(crate) const SAME_SECS: f32 = 2e-6;

/// Sorts times and removes those that count as equal to their predecessor.
pub(crate) fn rising(mut times: Vec<f32>) -> Vec<f32> {
    times.sort_by(f32::total_cmp);
    times.dedup_by(|b, a| *b - *a <= SAME_SECS);
    times
}

/// The key times of a clip, not sorted. Channels that follow each other with the same times give them once.
pub(crate) fn key_times(clip: &RawClip) -> impl Iterator<Item = f32> {
    let is_same = |a: &Channel, b: &Channel| a.times_secs == b.times_secs;
    let runs = clip.channels.chunk_by(is_same);
    runs.flat_map(|run| &run[0].times_secs).copied()
}
