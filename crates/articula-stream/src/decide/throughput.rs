//! Estimate of the bandwidth from finished transfers.
//!
//! Two exponentially weighted means with half-lives of 3 s and 9 s, of which the smaller counts, as
//! in players of video (hls.js); `docs/methods/adaptation.md` part 5. Different here: a sample weighs
//! the time that it stands for, not its own duration, since transfers of animation are short and far
//! apart; and the first guess is a sample like others.

use articula_core::Libm;

/// A transfer, without the time to its first byte.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transfer {
    /// Bytes of the body.
    pub bytes: u64,
    /// Time of the first byte, seconds on the caller's clock.
    pub first_byte_secs: f64,
    /// Time of the last byte.
    pub last_byte_secs: f64,
}

/// Options of a [`ThroughputEstimator`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThroughputOptions {
    /// Half-lives of the two means, seconds.
    pub half_lives_secs: [f64; 2],
    /// Estimate before the first transfer, bits per second.
    pub first_bits_per_second: f64,
    /// Weight of that estimate, seconds.
    pub first_weight_secs: f64,
    /// Transfers of fewer bytes weigh in proportion.
    pub whole_bytes: u64,
    /// Transfers with at most this pause between them are one sample, seconds.
    pub join_secs: f64,
    /// Joined samples end at this length, and a pause before a sample counts up to this, seconds.
    pub longest_secs: f64,
}

impl Default for ThroughputOptions {
    /// 3 s and 9 s, 500 kbit/s for half a second, 8 kB, 0.1 s, 1 s.
    fn default() -> Self {
        Self {
            half_lives_secs: [3.0, 9.0],
            first_bits_per_second: 500e3,
            first_weight_secs: 0.5,
            whole_bytes: 8192,
            join_secs: 0.1,
            longest_secs: 1.0,
        }
    }
}

/// A weighted mean in which a sample counts half after a time.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Mean {
    half_life: f64,
    sum: f64,
    weight: f64,
}

impl Mean {
    fn add(&mut self, value: f64, weight: f64) {
        let kept = 0.5_f64.libm_powf(weight / self.half_life);
        self.sum = kept * self.sum + (1.0 - kept) * value;
        self.weight = kept * self.weight + (1.0 - kept);
    }

    fn value(&self) -> f64 {
        self.sum / self.weight
    }
}

/// Estimator of bandwidth: a state machine on the caller's clock.
///
/// ```
/// use articula_stream::decide::{ThroughputEstimator, ThroughputOptions, Transfer};
///
/// let mut throughput = ThroughputEstimator::new(ThroughputOptions::default());
/// assert!((throughput.bits_per_second() - 500e3).abs() < 1e-6);
/// for second in 0..30 {
///     let first_byte_secs = f64::from(second);
///     let last_byte_secs = first_byte_secs + 0.5;
///     throughput.add(Transfer { bytes: 50_000, first_byte_secs, last_byte_secs });
/// }
/// assert!((throughput.bits_per_second() / 800e3 - 1.0).abs() < 0.05);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ThroughputEstimator {
    options: ThroughputOptions,
    means: [Mean; 2],
    /// Transfers that may be joined by the next one.
    open: Option<Transfer>,
    /// Time of the last byte before the open transfers.
    end_secs: f64,
}

impl ThroughputEstimator {
    /// Creates an estimator that knows nothing but the first estimate. Options that are not positive
    /// count as a millionth.
    pub fn new(options: ThroughputOptions) -> Self {
        let positive = |value: f64| if value > 1e-6 { value } else { 1e-6 };
        let means = options.half_lives_secs.map(|half_life| {
            let mut mean = Mean {
                half_life: positive(half_life),
                sum: 0.0,
                weight: 0.0,
            };
            let first = positive(options.first_bits_per_second);
            mean.add(first, positive(options.first_weight_secs));
            mean
        });
        Self {
            options,
            means,
            open: None,
            end_secs: f64::NEG_INFINITY,
        }
    }

    /// Adds a transfer, finished or given up. One without bytes counts: it says that nothing came
    /// through. Transfers of no duration, that precede others, or whose times are no numbers are left
    /// out.
    pub fn add(&mut self, transfer: Transfer) {
        let secs = transfer.last_byte_secs - transfer.first_byte_secs;
        let last = self.open.map_or(self.end_secs, |t| t.last_byte_secs);
        // Finite, in order, and not NaN.
        let is_next = secs > 0.0 && secs < f64::INFINITY && transfer.last_byte_secs >= last;
        if !is_next {
            return;
        }
        if let Some(open) = &mut self.open {
            let pause = transfer.first_byte_secs - open.last_byte_secs;
            let length = transfer.last_byte_secs - open.first_byte_secs;
            if pause <= self.options.join_secs && length <= self.options.longest_secs {
                // The pause is the server's, not the network's.
                open.first_byte_secs += pause.max(0.0);
                open.last_byte_secs = transfer.last_byte_secs;
                open.bytes += transfer.bytes;
                return;
            }
            let open = *open;
            self.close(open);
        }
        self.open = Some(transfer);
    }

    /// The estimate, bits per second; the transfers of the moment are included.
    pub fn bits_per_second(&self) -> f64 {
        let mut means = self.means;
        if let Some(open) = &self.open {
            let (rate, weight) = self.sample(open);
            means.iter_mut().for_each(|m| m.add(rate, weight));
        }
        means[0].value().min(means[1].value())
    }

    fn close(&mut self, transfer: Transfer) {
        let (rate, weight) = self.sample(&transfer);
        self.means.iter_mut().for_each(|m| m.add(rate, weight));
        self.end_secs = transfer.last_byte_secs;
    }

    /// Rate and weight of a sample.
    fn sample(&self, transfer: &Transfer) -> (f64, f64) {
        let secs = transfer.last_byte_secs - transfer.first_byte_secs;
        let since = transfer.last_byte_secs - self.end_secs;
        let stands_for = since.min(self.options.longest_secs).max(secs);
        let size = transfer.bytes as f64 / self.options.whole_bytes.max(1) as f64;
        // What took long says something, however few bytes came.
        let share = size
            .max(secs / self.options.longest_secs.max(1e-6))
            .min(1.0);
        (8.0 * transfer.bytes as f64 / secs, stands_for * share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn transfer(bytes: u64, first_byte_secs: f64, secs: f64) -> Transfer {
        Transfer {
            bytes,
            first_byte_secs,
            last_byte_secs: first_byte_secs + secs,
        }
    }

    fn after(transfers: &[Transfer]) -> f64 {
        let mut of = ThroughputEstimator::new(ThroughputOptions::default());
        transfers.iter().for_each(|t| of.add(*t));
        of.bits_per_second()
    }

    #[test]
    fn one_sample_by_hand() {
        // 10,000 bytes in 1 s: 80 kbit/s with a weight of 1 s; the first guess has half a second.
        // Half-life 9 s: kept = 0.5^(1/9), first = 1 - 0.5^(0.5/9).
        let (kept, first) = (0.5_f64.powf(1.0 / 9.0), 1.0 - 0.5_f64.powf(0.5 / 9.0));
        let value = (kept * first * 500e3 + (1.0 - kept) * 80e3) / (kept * first + 1.0 - kept);
        let short = 0.5_f64.powf(1.0 / 3.0);
        let first = 1.0 - 0.5_f64.powf(0.5 / 3.0);
        let fast = (short * first * 500e3 + (1.0 - short) * 80e3) / (short * first + 1.0 - short);
        let found = after(&[transfer(10_000, 0.0, 1.0)]);
        assert!((found - value.min(fast)).abs() < 1e-6, "{found}");
    }

    #[test]
    fn a_fall_is_seen_within_seconds_and_a_rise_later() {
        let steady: Vec<Transfer> = (0..60)
            .map(|s| transfer(125_000, f64::from(s), 0.5))
            .collect();
        let before = after(&steady);
        assert!((before / 2e6 - 1.0).abs() < 0.01);
        let then = |bytes: u64, secs: f64| {
            let mut all = steady.clone();
            let mut count = 0;
            while after(&all) == before || (after(&all) / 2e6).ln().abs() < 2.0_f64.ln() {
                all.push(transfer(bytes, 60.0 + f64::from(count), secs));
                count += 1;
            }
            count
        };
        // To 200 kbit/s, and to 20 Mbit/s: seconds until the estimate is half, and double.
        let (fall, rise) = (then(20_000, 0.8), then(1_000_000, 0.4));
        assert!(fall <= 4, "{fall}");
        assert!(rise > 0 && rise <= 3, "{rise}");
    }

    #[test]
    fn small_transfers_say_little_and_ranges_back_to_back_are_one() {
        let small = after(&[transfer(80, 0.0, 0.1)]);
        let large = after(&[transfer(8000, 0.0, 10.0)]);
        assert!(small > 400e3 && large < 100e3, "{small} {large}");
        let one = after(&[transfer(9000, 0.0, 0.3)]);
        let three = [0.0, 0.1, 0.2].map(|at| transfer(3000, at, 0.1));
        assert!((after(&three) - one).abs() < 1e-6);
        // The pauses between them are the server's.
        let paused = [0.0, 0.15, 0.3].map(|at| transfer(3000, at, 0.1));
        assert!(after(&paused) > 0.99 * one);
    }

    #[test]
    fn nonsense_is_left_out() {
        let of = |t: Transfer| after(&[t]);
        for t in [
            transfer(100, 0.0, 0.0),
            transfer(100, 0.0, f64::NAN),
            transfer(100, f64::NAN, 1.0),
            transfer(100, 0.0, f64::INFINITY),
            transfer(100, 0.0, -1.0),
        ] {
            assert_eq!(of(t), after(&[]), "{t:?}");
        }
        let order = [transfer(9000, 5.0, 1.0), transfer(9_000_000, 0.0, 1.0)];
        assert_eq!(after(&order), after(&order[..1]));
    }

    proptest! {
        #[test]
        fn the_estimate_is_between_the_rates(
            all in prop::collection::vec((0_u64..1_000_000, 0.0_f64..2.0, 0.001_f64..5.0), 0..40),
        ) {
            let mut at = 0.0;
            let mut rates = vec![500e3];
            let mut of = ThroughputEstimator::new(ThroughputOptions::default());
            for (bytes, pause, secs) in all {
                at += pause;
                of.add(transfer(bytes, at, secs));
                at += secs;
                rates.push(8.0 * bytes as f64 / secs);
            }
            let least = rates.iter().copied().fold(f64::INFINITY, f64::min);
            let most = rates.iter().copied().fold(0.0, f64::max);
            let found = of.bits_per_second();
            prop_assert!(found >= least * 0.999 && found <= most * 1.001);
        }
    }
}
