//! Processor time of threads, and its percentiles over frames.

use articula::core::percentile;
use serde::Serialize;

/// Processor time of this thread, nanoseconds.
#[cfg(unix)]
pub(crate) fn thread_ns() -> u64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    // Neither part of a thread's processor time is ever negative.
    time.tv_sec.unsigned_abs() * 1_000_000_000 + time.tv_nsec.unsigned_abs()
}

/// Wall-clock time in nanoseconds: other systems have no equally precise time of a thread.
#[cfg(not(unix))]
pub(crate) fn thread_ns() -> u64 {
    use std::sync::OnceLock;
    use std::time::Instant;
    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_nanos() as u64
}

/// Median and 95th percentile of a set of values.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub(crate) struct Spread {
    pub(crate) median: f64,
    pub(crate) p95: f64,
}

impl Spread {
    /// Of values in any order; zeros if there are none.
    pub(crate) fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.into_iter().collect();
        Self {
            median: percentile(&mut values, 0.5),
            p95: percentile(&mut values, 0.95),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_by_hand() {
        // docs/metrics.md: of 0, 1, 2, 3 and 8 the 95th lies at 0.95 * 4 = 3.8.
        let spread = Spread::of([3.0, 8.0, 0.0, 2.0, 1.0]);
        assert!((spread.median - 2.0).abs() < 1e-12);
        assert!((spread.p95 - 7.0).abs() < 1e-12);
        assert_eq!(Spread::of([]), Spread::default());
        assert_eq!(Spread::of([4.0]).p95, 4.0);
    }

    #[test]
    fn a_thread_that_works_takes_time() {
        let before = thread_ns();
        let mut sum = 0u64;
        for i in 0..2_000_000u64 {
            sum = std::hint::black_box(sum.wrapping_mul(31).wrapping_add(i));
        }
        assert!(thread_ns() > before, "{sum}");
    }
}
