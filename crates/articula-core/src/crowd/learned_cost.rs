//! What frames of a crowd cost on the machine that shows them, learned from their times.
//!
//! Source: `docs/methods/runtime.md` 4.4. Each crowd has a price for each kind of its work, so a character
//! with a deep rig, few clips in the cache or many faces is learned as it is. A frame tells the sum alone;
//! the prices take its difference from what was expected by their shares of it (normalised least mean
//! squares: Widrow and Hoff 1960, with the step of Nagumo and Noda 1967).

use super::demand::{Costs, Demand, PricedDemand};
use super::sources::KINDS;

/// First frames, in which all levels are chosen and nothing is in the cache of the processor: what they take is
/// forgotten with the next one.
const COLD_FRAMES: u32 = 2;
/// Weight of a new frame in the means, once there were as many as it stands for.
const GAIN: f64 = 0.1;
/// Greatest factor of a new time against the mean; an interrupted frame counts as this.
const OUTLIER: f64 = 1.5;
/// Range of prices, in nanoseconds for a nominal one: no machine is slower or faster than this.
const PRICES: [f64; 2] = [0.01, 1000.0];
/// Frames whose times are remembered for the margin, a second of display, and how many of them may
/// exceed it: less than 5 %.
const REMEMBERED: usize = 64;
const MAY_EXCEED: usize = 2;
/// Margin that is kept before the first frames have shown how much their times vary.
const FIRST_MARGIN: f32 = 1.03;

/// Times of a frame, and the list by which its options were chosen.
#[derive(Debug, Clone, Copy)]
pub(super) struct Times {
    pub(super) tick_ns: f64,
    pub(super) evaluate_ns: f64,
    pub(super) list: usize,
}

/// Prices of the work of each crowd, time outside of evaluation, and how much times vary.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LearnedCost {
    /// Of each crowd and kind of work, measured over nominal nanoseconds.
    prices: Vec<Costs>,
    /// Mean time of a frame outside of evaluation, with the options of each list: what evaluation writes is
    /// what a tick finds in the cache of the processor. `None` before the first.
    tick_ns: [Option<f64>; 2],
    frames: u32,
    /// Ratio of measured to expected time of the last of these frames, and which of them is the oldest.
    ratios: [f32; REMEMBERED],
    oldest: usize,
}

impl LearnedCost {
    pub(super) fn new() -> Self {
        Self {
            prices: Vec::new(),
            tick_ns: [None; 2],
            frames: 0,
            ratios: [FIRST_MARGIN; REMEMBERED],
            oldest: 0,
        }
    }

    /// Number of frames that were learned from.
    pub(super) fn frames(&self) -> u32 {
        self.frames
    }

    /// Mean time of a frame outside of evaluation with the options of a list, or of the other while that is
    /// not known.
    pub(super) fn tick_ns(&self, list: usize) -> f64 {
        let [this, other] = [list, 1 - list].map(|list| self.tick_ns[list]);
        this.or(other).unwrap_or(0.0)
    }

    /// Expected time of work, one entry for each crowd; nominal where nothing is known.
    pub(super) fn evaluate_ns(&self, work: impl Iterator<Item = Costs>) -> f64 {
        let of = |(crowd, costs): (usize, Costs)| dot(&self.prices(crowd), &costs);
        work.enumerate().map(of).sum()
    }

    /// Expected time of all crowds by tolerance.
    pub(super) fn priced<'a>(&self, demands: impl Iterator<Item = &'a Demand>) -> PricedDemand {
        let mut table = PricedDemand::NONE;
        for (crowd, demand) in demands.enumerate() {
            demand.add_priced(&self.prices(crowd), &mut table);
        }
        table
    }

    /// Learns from a frame whose work is given, one entry for each crowd; it is not nothing.
    pub(super) fn learn(&mut self, times: Times, work: impl Iterator<Item = Costs> + Clone) {
        let nominal_ns: f64 = work.clone().flatten().sum();
        if self.frames <= COLD_FRAMES {
            self.prices.clear();
            self.tick_ns = [None; 2];
        }
        let known = self.prices.len();
        let price = (times.evaluate_ns / nominal_ns).clamp(PRICES[0], PRICES[1]);
        self.prices
            .extend(work.clone().skip(known).map(|_| [price; KINDS]));
        self.frames = self.frames.saturating_add(1);
        let expected_ns = self.evaluate_ns(work.clone());
        let warm = self.frames.saturating_sub(COLD_FRAMES).max(1);
        let gain = GAIN.max(1.0 / f64::from(warm));
        let tick_ns = self.tick_ns[times.list].unwrap_or(times.tick_ns);
        if warm > 1 {
            let measured = times.tick_ns + times.evaluate_ns;
            self.ratios[self.oldest] = (measured / (tick_ns + expected_ns)) as f32;
            self.oldest = (self.oldest + 1) % REMEMBERED;
        }
        let tick_error_ns = times.tick_ns.min(OUTLIER * tick_ns) - tick_ns;
        self.tick_ns[times.list] = Some(tick_ns + gain * tick_error_ns);
        let error_ns = times.evaluate_ns.min(OUTLIER * expected_ns) - expected_ns;
        let squares: f64 = work.clone().map(|costs| dot(&costs, &costs)).sum();
        for (prices, costs) in self.prices.iter_mut().zip(work) {
            for (price, cost) in prices.iter_mut().zip(costs) {
                *price = (*price + gain * error_ns * cost / squares).clamp(PRICES[0], PRICES[1]);
            }
        }
    }

    /// Ratio of measured to expected time that few of the last frames exceed.
    pub(super) fn margin(&self) -> f64 {
        let mut ratios = self.ratios;
        let (_, margin, _) = ratios.select_nth_unstable_by(MAY_EXCEED, |a, b| b.total_cmp(a));
        f64::from(*margin).clamp(1.0, OUTLIER)
    }

    fn prices(&self, crowd: usize) -> Costs {
        self.prices.get(crowd).copied().unwrap_or([1.0; KINDS])
    }
}

fn dot(a: &Costs, b: &Costs) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two crowds whose true prices no constant tells, shown with changing shares of their kinds of work.
    #[test]
    fn the_prices_of_each_crowd_are_learned_from_sums() {
        let truth: [Costs; 2] = [[3.0, 0.5, 1.0, 2.0], [0.8, 2.0, 4.0, 0.5]];
        let mut learned = LearnedCost::new();
        let mut last = f64::INFINITY;
        for frame in 0..2000_u32 {
            let share = |i: u32| f64::from(1 + frame * (2 * i + 3) % 101) / 101.0;
            let work = [0, 4].map(|c| [0, 1, 2, 3].map(|k| 1000.0 * share(c + k)));
            let evaluate_ns = work.iter().zip(&truth).map(|(w, t)| dot(w, t)).sum();
            last = learned.evaluate_ns(work.into_iter()) / evaluate_ns;
            let times = Times {
                tick_ns: 500.0,
                evaluate_ns,
                list: 0,
            };
            learned.learn(times, work.into_iter());
        }
        assert!((last - 1.0).abs() < 0.01, "{last}");
        for (found, truth) in learned.prices.iter().flatten().zip(truth.iter().flatten()) {
            assert!((found / truth - 1.0).abs() < 0.05, "{:?}", learned.prices);
        }
        assert!((learned.tick_ns(0) - 500.0).abs() < 1e-6);
    }

    #[test]
    fn an_interrupted_frame_is_no_price() {
        let mut learned = LearnedCost::new();
        let work = || std::iter::once([100.0, 0.0, 0.0, 0.0]);
        let times = |evaluate_ns| Times {
            tick_ns: 10.0,
            evaluate_ns,
            list: 0,
        };
        for frame in 0..100 {
            let ns = if frame == 80 { 1e9 } else { 200.0 };
            learned.learn(times(ns), work());
        }
        let found = learned.evaluate_ns(work());
        assert!((found / 200.0 - 1.0).abs() < 0.01, "{found}");
        // One of 64 may be late without the others being planned for less.
        assert!(learned.margin() < 1.06, "{}", learned.margin());
    }
}
