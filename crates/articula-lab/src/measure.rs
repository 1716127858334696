//! Times several evaluators ("contestants") against each other in one run.
//!
//! Times are processor time of the thread, not wall-clock time, so that other programs disturb them
//! little. The contestants take turns, each round in another order, and the median and minimum over
//! all rounds are kept; times of one run are comparable only with each other.

use articula_report::thread_ns;
use std::hint::black_box;

/// Evaluates all characters at times of the clip, in seconds.
pub(crate) type Frame<'a> = Box<dyn FnMut(&[f32]) + 'a>;

/// An evaluator that is timed on the same frames as the others.
pub(crate) struct Contestant<'a> {
    pub(crate) name: String,
    pub(crate) frame: Frame<'a>,
}

/// Time of a contestant, in nanoseconds per character and frame.
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize)]
pub(crate) struct Timing {
    pub(crate) median_ns: f64,
    pub(crate) least_ns: f64,
}

/// Times every contestant over all `frames`, `rounds` times, after one more round that is not
/// counted. The timings are in the order of the contestants.
pub(crate) fn race(
    contestants: &mut [Contestant<'_>],
    frames: &[Vec<f32>],
    rounds: usize,
) -> Vec<Timing> {
    let count = contestants.len();
    let shown: usize = frames.iter().map(Vec::len).sum();
    let mut taken = vec![Vec::with_capacity(rounds); count];
    for round in 0..=rounds {
        for turn in 0..count {
            let who = (turn + round) % count;
            let frame = &mut contestants[who].frame;
            let start = thread_ns();
            for secs in frames {
                frame(black_box(secs));
            }
            let ns = (thread_ns() - start) as f64 / shown.max(1) as f64;
            if round > 0 {
                taken[who].push(ns);
            }
        }
    }
    taken.iter_mut().map(|ns| timing(ns)).collect()
}

/// Median and minimum of some times; zeros if there are none.
fn timing(ns: &mut [f64]) -> Timing {
    Timing {
        median_ns: median(ns),
        least_ns: ns.first().copied().unwrap_or(0.0),
    }
}

/// Median, the mean of the middle two of an even number; 0 of none. Sorts the values.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let at = |i: usize| values.get(i).copied().unwrap_or(0.0);
    let middle = values.len() / 2;
    let below = if values.len().is_multiple_of(2) {
        middle.saturating_sub(1)
    } else {
        middle
    };
    0.5 * (at(below) + at(middle))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_and_least_by_hand() {
        let of = |ns: &mut [f64]| {
            let t = timing(ns);
            (t.median_ns, t.least_ns)
        };
        assert_eq!(of(&mut [3.0, 1.0, 2.0]), (2.0, 1.0));
        assert_eq!(of(&mut [4.0, 1.0, 3.0, 2.0]), (2.5, 1.0));
        assert_eq!(of(&mut [7.0]), (7.0, 7.0));
        assert_eq!(of(&mut []), (0.0, 0.0));
    }

    #[test]
    fn everyone_sees_every_frame_in_every_round() {
        let frames = [vec![0.0, 1.0], vec![2.0, 3.0]];
        let mut seen = [0.0f32; 2];
        let [first, second] = &mut seen;
        let contestant = |sum: &'static str| sum.to_owned();
        let mut contestants = [
            Contestant {
                name: contestant("first"),
                frame: Box::new(|secs| *first += secs.iter().sum::<f32>()),
            },
            Contestant {
                name: contestant("second"),
                frame: Box::new(|secs| *second += secs.iter().sum::<f32>()),
            },
        ];
        let timings = race(&mut contestants, &frames, 3);
        assert_eq!(timings.len(), 2);
        drop(contestants);
        assert_eq!(seen, [24.0, 24.0], "three rounds and the first");
    }
}
