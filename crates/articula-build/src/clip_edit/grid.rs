//! The times at which an edit is verified.

use crate::key_times::{key_times, rising};
use articula_core::source::RawClip;

/// Minimum rate of the grid on which an edit is verified.
pub(crate) const VERIFIED_HZ: f32 = 120.0;

/// All key times of some clips, the ticks of [`VERIFIED_HZ`] up to `end_secs`, and the midpoints of
/// keys that are at most two ticks apart.
pub(crate) fn grid<'a>(clips: impl IntoIterator<Item = &'a RawClip>, end_secs: f32) -> Vec<f32> {
    let keys = clips.into_iter().flat_map(key_times);
    let keys = rising(keys.chain([0.0, end_secs]).collect());
    let ticks = (end_secs * VERIFIED_HZ).ceil() as usize;
    let ticks = (0..ticks).map(|i| i as f32 / VERIFIED_HZ);
    let near = keys.windows(2).filter(|w| w[1] - w[0] <= 2.0 / VERIFIED_HZ);
    let midpoints = near.map(|w| 0.5 * (w[0] + w[1]));
    rising(keys.iter().copied().chain(ticks).chain(midpoints).collect())
}
