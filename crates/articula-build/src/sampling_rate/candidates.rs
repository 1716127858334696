//! Rates at which the keys of a clip may all be frames.

use super::{MAX_MULTIPLIED_HZ, USUAL_RATES_HZ};

/// Maximum rate that is chosen automatically.
pub(super) const MAX_RATE_HZ: f32 = 240.0;

/// Rates between 60 and 240 Hz besides the usual ones, and those of NTSC video.
const FURTHER_RATES_HZ: [f32; 6] = [
    24_000.0 / 1001.0,
    30_000.0 / 1001.0,
    60_000.0 / 1001.0,
    144.0,
    180.0,
    200.0,
];

/// Grids on which key times are rounded by authoring programs and text files.
const TIME_BASES_HZ: [f64; 18] = [
    // All of 24, 25, 30, 60, 100, 120 and 150.
    600.0,
    24.0,
    25.0,
    30.0,
    48.0,
    50.0,
    60.0,
    90.0,
    100.0,
    120.0,
    125.0,
    144.0,
    200.0,
    240.0,
    24_000.0 / 1001.0,
    30_000.0 / 1001.0,
    60_000.0 / 1001.0,
    1000.0,
];

/// Maximum distance of a key from a tick of its time base, in ticks and in seconds: milliseconds are
/// often rounded down.
const OFF_TICKS: f64 = 0.1;
const OFF_SECS: f64 = 6e-4;

/// Number of multiples of a rate that are candidates.
const MULTIPLES: usize = 24;

/// Returns rising rates: those whose frames are all keys, by the common divisor of the key times on
/// each time base, their multiples, multiples of the rate at which the clip was keyed, and usual ones.
pub(super) fn rates(keys: &[f32], duration: f32, keyed_hz: f32) -> Vec<f32> {
    let of_base = |base: &f64| common_rate(keys, duration, *base);
    let bases = TIME_BASES_HZ.iter().filter_map(of_base);
    let found = bases.chain([f64::from(keyed_hz)]);
    let multiples = found.flat_map(|rate| (1..=MULTIPLES).map(move |k| (rate * k as f64) as f32));
    let mut rates: Vec<f32> = multiples
        .chain(USUAL_RATES_HZ)
        .chain(FURTHER_RATES_HZ)
        .filter(|r| *r <= MAX_RATE_HZ)
        .collect();
    rates.sort_by(f32::total_cmp);
    rates.dedup_by(|b, a| *b / *a - 1.0 < 1e-6);
    rates
}

/// Multiples of the rate of regular keys, rising, up to [`MAX_MULTIPLIED_HZ`].
pub(super) fn multiples(keyed_hz: f32) -> Vec<f32> {
    let all = (1..=MULTIPLES).map(|k| keyed_hz * k as f32);
    all.filter(|rate| *rate <= MAX_MULTIPLIED_HZ).collect()
}

/// The lowest rate at which all keys and the end are frames, if they are ticks of a base.
fn common_rate(keys: &[f32], duration: f32, base: f64) -> Option<f64> {
    let mut common = 0u64;
    for time in keys.iter().chain([&duration]) {
        let at = f64::from(*time) * base;
        let off = (at - at.round()).abs();
        if off > OFF_TICKS || off > OFF_SECS * base {
            return None;
        }
        common = divisor(common, at.round().max(0.0) as u64);
    }
    (common > 0).then(|| base / common as f64)
}

/// The greatest common divisor; that of 0 and a number is the number.
fn divisor(mut a: u64, mut b: u64) -> u64 {
    while b > 0 {
        (a, b) = (b, a % b);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_common_divisor_of_hand_set_keys_is_a_candidate() {
        // 0.4, 0.6, 2.6 and 3.0 are multiples of 0.2 s.
        let rates = rates(&[0.0, 0.4, 0.6, 2.6, 3.0], 3.0, 2.5);
        assert!(rates.iter().any(|r| (r - 5.0).abs() < 1e-5), "{rates:?}");
        assert!(rates.is_sorted() && rates.iter().all(|r| *r <= 240.0));
    }

    #[test]
    fn keys_that_begin_late_lie_on_a_finer_grid() {
        // 24 keys per second after 1/30 s: 4/120 + 5 i/120.
        let keys: Vec<f32> = (0..20).map(|i| 1.0 / 30.0 + i as f32 / 24.0).collect();
        assert_eq!(common_rate(&keys, keys[19], 120.0), Some(120.0));
        assert_eq!(common_rate(&keys, keys[19], 24.0), None);
    }
}
