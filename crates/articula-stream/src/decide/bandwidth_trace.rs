//! Bandwidth over time: recorded or made.

use crate::StreamError;
use articula_core::Libm;

/// Bandwidth as steps over time. Before the first step the first value holds, after the last one the
/// last.
///
/// ```
/// use articula_stream::decide::BandwidthTrace;
///
/// let trace = BandwidthTrace::read("# seconds, bits per second\n0 1000\n2 0\n3 500\n")?;
/// assert_eq!(trace.at(1.5), 1000.0);
/// // From 1 s on: 1000 bits by 2 s, none for a second, the other 250 in half a second.
/// assert_eq!(trace.finish(1.0, 1250.0), 3.5);
/// # Ok::<(), articula_stream::StreamError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct BandwidthTrace {
    /// Start in seconds, rising, and bits per second; at least one.
    steps: Vec<(f64, f64)>,
}

/// Maximum number of lines of a recorded trace.
const MAX_LINES: usize = 1 << 20;
/// Times and rates of a trace are below this.
const MOST: f64 = 1e15;

impl BandwidthTrace {
    /// The same bandwidth at all times; negative or NaN counts as 0.
    pub fn constant(bits_per_second: f64) -> Self {
        Self::of([(0.0, bits_per_second)])
    }

    /// One bandwidth before, another one from a time on.
    pub fn step(before: f64, after: f64, at_secs: f64) -> Self {
        Self::of([(0.0, before), (at_secs, after)])
    }

    /// From one bandwidth to another between two times, in steps of half a second.
    pub fn ramp(from: f64, to: f64, start_secs: f64, end_secs: f64) -> Self {
        let count = count(end_secs - start_secs);
        let step = |i: usize| {
            let share = i as f64 / count as f64;
            let at = start_secs + share * (end_secs - start_secs);
            (at, from + share * (to - from))
        };
        Self::of((0..=count).map(step))
    }

    /// Alternates between two bandwidths, each for half of a period, up to a time.
    pub fn square(first: f64, second: f64, period_secs: f64, end_secs: f64) -> Self {
        let half = (0.5 * period_secs).max(1e-3);
        let of = |i: usize| {
            (
                i as f64 * half,
                if i.is_multiple_of(2) { first } else { second },
            )
        };
        let count = (end_secs / half).clamp(0.0, MAX_LINES as f64) as usize;
        Self::of((0..=count).map(of))
    }

    /// A bandwidth that is 0 between two times.
    pub fn drop_to_zero(bits_per_second: f64, from_secs: f64, to_secs: f64) -> Self {
        Self::of([
            (0.0, bits_per_second),
            (from_secs, 0.0),
            (to_secs, bits_per_second),
        ])
    }

    /// A bandwidth that wanders around a value, in steps of half a second up to a time: its logarithm
    /// has a standard deviation of about 0.5 and forgets itself within a few seconds. The same seed
    /// gives the same trace.
    pub fn noisy(seed: u64, bits_per_second: f64, end_secs: f64) -> Self {
        let mut state = seed;
        let mut wander = 0.0;
        let step = |i: usize| {
            // The sum of four uniform numbers is near enough to a normal one.
            let sum: f64 = (0..4).map(|_| uniform(&mut state) - 0.5).sum();
            wander = 0.8 * wander + 0.52 * sum;
            (0.5 * i as f64, bits_per_second * wander.libm_exp())
        };
        let steps: Vec<(f64, f64)> = (0..=count(end_secs)).map(step).collect();
        Self::of(steps)
    }

    /// Reads lines of seconds and bits per second, separated by blanks, tabs or a comma. Empty lines
    /// and those that start with `#` are left out.
    ///
    /// # Errors
    /// [`StreamError::Malformed`] with the number of the line if it does not have two numbers of at
    /// least 0, if times do not rise, or if there is no line; [`StreamError::LimitExceeded`] if there
    /// are more than a million.
    pub fn read(text: &str) -> Result<Self, StreamError> {
        let mut steps: Vec<(f64, f64)> = Vec::new();
        for (index, line) in text.lines().enumerate() {
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let at = || format!("line {}", index + 1);
            if steps.len() == MAX_LINES {
                return Err(StreamError::LimitExceeded {
                    at: at(),
                    which: "lines",
                    found: index as u64 + 1,
                    limit: MAX_LINES as u64,
                });
            }
            let number = |word: &str| {
                let value = word.parse::<f64>().ok();
                value.filter(|v| (0.0..MOST).contains(v))
            };
            let separated = |c: char| c.is_whitespace() || c == ',';
            let words: Vec<&str> = line
                .split(separated)
                .filter(|w| !w.is_empty())
                .take(3)
                .collect();
            let (secs, rate) = match words.as_slice() {
                [secs, rate] => (number(secs), number(rate)),
                _ => (None, None),
            };
            let (Some(secs), Some(rate)) = (secs, rate) else {
                let what = "expected seconds and bits per second, two numbers of at least 0";
                return Err(StreamError::malformed(at(), what));
            };
            if steps.last().is_some_and(|last| last.0 >= secs) {
                let what = format!("{secs} s does not come after the line before; sort the lines");
                return Err(StreamError::malformed(at(), what));
            }
            steps.push((secs, rate));
        }
        if steps.is_empty() {
            let what = "no line with seconds and bits per second";
            return Err(StreamError::malformed("line 1", what));
        }
        Ok(Self { steps })
    }

    /// Steps in order; those that do not come after the one before replace it.
    fn of(all: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let mut steps: Vec<(f64, f64)> = Vec::new();
        let number = |value: f64| if value > 0.0 { value.min(MOST) } else { 0.0 };
        for (secs, rate) in all {
            let step = (number(secs), number(rate));
            if steps.last().is_some_and(|last| last.0 >= step.0) {
                steps.pop();
            }
            steps.push(step);
        }
        Self { steps }
    }

    /// Bandwidth at a time, bits per second.
    pub fn at(&self, secs: f64) -> f64 {
        self.steps[self.index(secs)].1
    }

    /// Time at which a number of bits is through that starts at a time; infinite if never.
    pub fn finish(&self, start_secs: f64, bits: f64) -> f64 {
        let (mut now, mut left) = (start_secs, bits);
        for index in self.index(start_secs).. {
            let rate = self.steps[index].1;
            let Some(next) = self.steps.get(index + 1) else {
                return if left <= 0.0 { now } else { now + left / rate };
            };
            let through = rate * (next.0 - now);
            if through >= left {
                return if left <= 0.0 { now } else { now + left / rate };
            }
            left -= through;
            now = next.0;
        }
        f64::INFINITY
    }

    /// Bits that come through between two times.
    pub fn bits(&self, start_secs: f64, end_secs: f64) -> f64 {
        let mut now = start_secs;
        let mut bits = 0.0;
        for index in self.index(start_secs)..self.steps.len() {
            let next = self.steps.get(index + 1).map_or(f64::INFINITY, |s| s.0);
            let until = next.min(end_secs);
            if until > now {
                bits += self.steps[index].1 * (until - now);
                now = until;
            }
            if next >= end_secs {
                break;
            }
        }
        bits
    }

    fn index(&self, secs: f64) -> usize {
        self.steps.partition_point(|s| s.0 <= secs).max(1) - 1
    }
}

/// Number of half seconds of a stretch, at least 1.
fn count(secs: f64) -> usize {
    (2.0 * secs).clamp(1.0, MAX_LINES as f64) as usize
}

/// SplitMix64 (Sebastiano Vigna, 2014), 0 to 1.
fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_mutate::{Edit, Mutations, cut_off};
    use proptest::prelude::*;

    #[test]
    fn made_traces_by_hand() {
        let ramp = BandwidthTrace::ramp(100.0, 200.0, 10.0, 20.0);
        assert_eq!(
            [0.0, 10.0, 15.0, 99.0].map(|t| ramp.at(t)),
            [100.0, 100.0, 150.0, 200.0]
        );
        let square = BandwidthTrace::square(1.0, 9.0, 10.0, 60.0);
        assert_eq!(
            [0.0, 4.9, 5.0, 12.0, 16.0].map(|t| square.at(t)),
            [1.0, 1.0, 9.0, 1.0, 9.0]
        );
        let drop = BandwidthTrace::drop_to_zero(8.0, 3.0, 5.0);
        assert_eq!(drop.bits(2.0, 6.0), 16.0);
        assert_eq!(drop.finish(2.0, 16.0), 6.0);
        assert_eq!(
            BandwidthTrace::step(8.0, 0.0, 3.0).finish(2.0, 9.0),
            f64::INFINITY
        );
        assert_eq!(BandwidthTrace::constant(f64::NAN).at(1.0), 0.0);
    }

    #[test]
    fn noise_stays_around_its_value() {
        let trace = BandwidthTrace::noisy(7, 1e6, 1000.0);
        assert_eq!(trace, BandwidthTrace::noisy(7, 1e6, 1000.0));
        assert_ne!(trace, BandwidthTrace::noisy(8, 1e6, 1000.0));
        let logs: Vec<f64> = trace.steps.iter().map(|s| (s.1 / 1e6).ln()).collect();
        let mean = logs.iter().sum::<f64>() / logs.len() as f64;
        let spread = logs.iter().map(|l| l * l).sum::<f64>() / logs.len() as f64;
        assert!(mean.abs() < 0.1, "{mean}");
        assert!((spread.sqrt() - 0.5).abs() < 0.08, "{}", spread.sqrt());
    }

    #[test]
    fn bad_lines_are_named() {
        let error = |text: &str| BandwidthTrace::read(text).unwrap_err().to_string();
        let numbers = "expected seconds and bits per second, two numbers of at least 0";
        assert_eq!(error("0 1\n1 -5"), format!("line 2: {numbers}"));
        assert_eq!(error("0 1\n\n# x\n1 NaN"), format!("line 4: {numbers}"));
        assert_eq!(error("0 1 2"), format!("line 1: {numbers}"));
        assert!(error("0 1\n0 2").starts_with("line 2: 0 s does not come after"));
        assert!(error("# nothing").contains("no line"));
        let read = BandwidthTrace::read("0,5e3\r\n1.5\t7").unwrap();
        assert_eq!(read.steps, [(0.0, 5e3), (1.5, 7.0)]);
    }

    #[test]
    fn mutants_give_a_trace_or_an_error() {
        let good = b"# log\n0 100000\n0.5 250000\n1.25, 0\n30 1e6\n";
        let edits = [
            Edit::FlipBit,
            Edit::Delete(5),
            Edit::Repeat(9),
            Edit::Word(&["NaN", "-1", "inf", "1e400"]),
        ];
        let read = |bytes: &[u8]| {
            let Ok(text) = std::str::from_utf8(bytes) else {
                return false;
            };
            let Ok(trace) = BandwidthTrace::read(text) else {
                return false;
            };
            assert!(trace.at(0.7) >= 0.0 && trace.bits(0.0, 40.0).is_finite());
            assert!(trace.finish(0.0, 1e5) >= 0.0);
            true
        };
        let mutations = Mutations {
            edits: &edits,
            most: 3,
        };
        let found = mutations.read_of(good, 2000, read);
        assert!(found > 100 && found < 1900, "{found}");
        assert!(cut_off(good).filter(|b| read(b)).count() > 5);
    }

    proptest! {
        #[test]
        fn what_is_through_at_the_finish_is_what_was_sent(
            seed: u64,
            start in 0.0_f64..50.0,
            bits in 1.0_f64..1e6,
        ) {
            let trace = BandwidthTrace::noisy(seed, 1e4, 60.0);
            let end = trace.finish(start, bits);
            prop_assert!((trace.bits(start, end) - bits).abs() < 1e-6 * bits);
            prop_assert!(trace.bits(start, end - 1e-3) < bits);
        }
    }
}
