//! Equality and order of key times.

/// Two times of a clip that differ by less than this are equal: after half a minute single
/// precision does not resolve more.
pub(crate) const SAME_SECS: f32 = 2e-6;

/// Sorts times and removes those that count as equal to their predecessor.
pub(crate) fn rising(mut times: Vec<f32>) -> Vec<f32> {
    times.sort_by(f32::total_cmp);
    times.dedup_by(|b, a| *b - *a <= SAME_SECS);
    times
}
