//! Cost of a crowd as a function of the tolerance.
//!
//! Every visible character becomes cheaper at the tolerances at which its next option is within the
//! tolerance. These savings are summed by tolerance, a few cells of the crowd in each frame, so that
//! the cost of any tolerance is a sum over a table.

use super::character_state::CharacterState;
use super::model::CrowdModel;
use super::options::{DetailOption, morphs_ns};
use super::sources::{FACES, KINDS, Source};
use glam::Vec4;

/// Tolerances of the table: four to an octave, from 2^-8 px on.
const BINS: usize = 96;
const PER_OCTAVE_BITS: u32 = 2;
const FIRST_PX: f32 = 1.0 / 256.0;

/// Nominal nanoseconds of each kind of work.
pub(crate) type Costs = [f64; KINDS];

/// Tolerances that a budget asks for, in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tolerances {
    /// Where an entry of the table begins.
    least_px: f32,
    most_px: f32,
}

impl Tolerances {
    /// From the beginning of the entry that has the first one.
    pub(crate) fn new(least_px: f32, most_px: f32) -> Self {
        let bin = bin_of(least_px);
        Self {
            least_px: if bin > 0 { px_of(bin) } else { 0.0 },
            most_px,
        }
    }

    /// The same with another greatest one.
    pub(crate) fn up_to(self, most_px: f32) -> Self {
        Self { most_px, ..self }
    }

    /// The greatest one.
    pub(crate) fn most_px(self) -> f32 {
        self.most_px
    }
}

/// Sum of the costs of characters by tolerance.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Demand {
    /// Nanoseconds with the cheapest option of each character.
    least_ns: Costs,
    /// Nanoseconds that each tolerance saves against the one before, of each kind of work.
    savings_ns: [[f32; KINDS]; BINS],
}

impl Demand {
    pub(crate) const NONE: Self = Self {
        least_ns: [0.0; KINDS],
        savings_ns: [[0.0; KINDS]; BINS],
    };

    /// Adds a character that `px_per_metre` pixels of tolerance make a metre for, with its options,
    /// finest first, none of which is off by more than the most of the tolerances but the first. One that draws
    /// less may cost more: a saving below 0. Tolerances below the least one have the cost of it.
    #[inline]
    pub(crate) fn see(
        &mut self,
        options: &[DetailOption],
        px_per_metre: f32,
        tolerances: Tolerances,
    ) {
        let least_metres = tolerances.least_px / px_per_metre;
        // Most characters are far away, where few options are left.
        let within = options.partition_point(|o| o.error_metres < least_metres);
        let Some((mut last, coarser)) = options
            .get(within.saturating_sub(1)..)
            .and_then(<[_]>::split_first)
        else {
            return;
        };
        for option in coarser {
            let error_px = option.error_metres * px_per_metre;
            if error_px > tolerances.most_px {
                break;
            }
            // All kinds at once.
            let savings = &mut self.savings_ns[bin_of(error_px)];
            let saved = Vec4::from(last.costs_ns) - Vec4::from(option.costs_ns);
            *savings = (Vec4::from(*savings) + saved).to_array();
            last = option;
        }
        for (least, cost) in self.least_ns.iter_mut().zip(last.costs_ns) {
            *least += f64::from(cost);
        }
    }

    /// Adds a character that fades.
    pub(crate) fn see_fading(
        &mut self,
        model: &CrowdModel,
        state: &CharacterState,
        px_per_metre: f32,
        tolerances: Tolerances,
    ) {
        let (from, to) = state.clips();
        let (source, poses) = match state.fade == 0.0 {
            true => (Source::Clip, 1.0),
            false => (Source::Blend, 2.0),
        };
        let parts = model.parts();
        let cost = |level| {
            [
                source.cost_ns(parts, level),
                poses * morphs_ns(parts, level, 0),
            ]
        };
        let mut least = cost(0);
        for level in 1..model.levels() {
            let error_px = model.error_metres(from, to, level) * px_per_metre;
            if error_px > tolerances.most_px {
                break;
            }
            let savings = &mut self.savings_ns[bin_of(error_px)];
            let finer = std::mem::replace(&mut least, cost(level));
            savings[source.kind()] += finer[0] - least[0];
            savings[FACES] += finer[1] - least[1];
        }
        self.least_ns[source.kind()] += f64::from(least[0]);
        self.least_ns[FACES] += f64::from(least[1]);
    }

    /// Nanoseconds with the cheapest option of each character, of each kind of work.
    pub(crate) fn least_ns(&self) -> Costs {
        self.least_ns
    }

    /// Adds the nanoseconds by tolerance at the prices of the kinds of work to a table.
    pub(crate) fn add_priced(&self, prices: &Costs, table: &mut PricedDemand) {
        let priced = |costs: Costs| -> f64 { costs.iter().zip(prices).map(|(c, p)| c * p).sum() };
        table.least_ns += priced(self.least_ns);
        for (sum, savings) in table.savings_ns.iter_mut().zip(&self.savings_ns) {
            *sum += priced(savings.map(f64::from));
        }
    }
}

/// Expected time of several crowds by tolerance.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PricedDemand {
    least_ns: f64,
    savings_ns: [f64; BINS],
}

impl PricedDemand {
    pub(crate) const NONE: Self = Self {
        least_ns: 0.0,
        savings_ns: [0.0; BINS],
    };

    /// Nanoseconds with the cheapest option of each character.
    pub(crate) fn least_ns(&self) -> f64 {
        self.least_ns
    }

    /// Nanoseconds at a tolerance.
    pub(crate) fn cost_ns(&self, px: f32) -> f64 {
        let (bin, part) = bin_and_coarser(px);
        let coarser: f64 = self.savings_ns[bin + 1..].iter().sum();
        self.least_ns + coarser + f64::from(part) * self.savings_ns[bin]
    }

    /// The least tolerance in pixels, not below `least_px`, whose cost is at most `budget_ns`, or
    /// the greatest that changes anything.
    pub(crate) fn px_within(&self, budget_ns: f64, least_px: f32) -> f32 {
        let mut coarser = self.least_ns;
        for bin in (0..BINS).rev() {
            let savings = self.savings_ns[bin];
            if savings > 0.0 && coarser + savings > budget_ns {
                let [low, high] = [px_of(bin), px_of(bin + 1)];
                let left = ((budget_ns - coarser).max(0.0) / savings).min(1.0) as f32;
                return (high - left * (high - low)).max(least_px);
            }
            coarser += savings;
        }
        least_px
    }
}

/// Index of the table for a tolerance in pixels; NaN is in the first.
#[inline]
fn bin_of(px: f32) -> usize {
    let steps = |px: f32| px.to_bits() >> (23 - PER_OCTAVE_BITS);
    if px > FIRST_PX {
        ((steps(px) - steps(FIRST_PX)) as usize).min(BINS - 2)
    } else {
        0
    }
}

/// Index of the table for a tolerance in pixels, and the part of its savings that coarser tolerances have: within an
/// entry the thresholds are taken to be spread evenly.
fn bin_and_coarser(px: f32) -> (usize, f32) {
    let bin = bin_of(px);
    let [low, high] = [px_of(bin), px_of(bin + 1)];
    (bin, ((high - px) / (high - low)).clamp(0.0, 1.0))
}

/// Tolerance in pixels at which an entry of the table begins.
fn px_of(bin: usize) -> f32 {
    let first = FIRST_PX.to_bits() >> (23 - PER_OCTAVE_BITS);
    f32::from_bits((first + bin as u32) << (23 - PER_OCTAVE_BITS))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const ALL: Tolerances = Tolerances {
        least_px: 0.0,
        most_px: f32::INFINITY,
    };

    fn options(steps: &[(f32, f32)]) -> Vec<DetailOption> {
        let option = |(error_metres, cost_ns)| DetailOption {
            level: 0,
            source: Source::Clip,
            morphs: 0,
            error_metres,
            costs_ns: [cost_ns, 0.0, 0.0, 0.0],
            frame_ns: cost_ns,
        };
        steps.iter().copied().map(option).collect()
    }

    /// The demand of options at the prices of the machine whose nominal costs they have.
    fn priced(demand: &Demand) -> PricedDemand {
        let mut priced = PricedDemand::NONE;
        demand.add_priced(&[1.0; KINDS], &mut priced);
        priced
    }

    #[test]
    fn a_demand_by_hand() {
        // 1 px and 4 px are where entries of the table begin.
        let steps = options(&[(0.0, 100.0), (0.01, 40.0), (0.04, 10.0)]);
        let mut demand = Demand::NONE;
        demand.see(&steps, 100.0, ALL);
        demand.see(&steps, 100.0, ALL);
        let at = priced(&demand);
        for (px, cost) in [
            (0.5, 200.0),
            (1.0, 200.0),
            (1.25, 80.0),
            (3.0, 80.0),
            (5.0, 20.0),
        ] {
            assert_eq!(at.cost_ns(px), cost, "{px} px");
        }
        assert_eq!(at.px_within(200.0, 0.25), 0.25);
        assert_eq!(at.px_within(80.0, 0.25), 1.25);
        assert_eq!(at.px_within(140.0, 0.25), 1.125);
        assert_eq!(at.px_within(20.0, 0.25), 5.0);
        assert_eq!(at.px_within(20.0, 9.0), 9.0);
        // Too little for anything: the greatest tolerance that changes anything.
        assert_eq!(at.px_within(0.0, 0.25), 5.0);
    }

    #[test]
    fn near_characters_save_no_more_than_their_tolerance_allows() {
        let steps = options(&[(0.0, 100.0), (0.01, 40.0), (0.04, 10.0)]);
        let mut demand = Demand::NONE;
        demand.see(&steps, 100.0, ALL.up_to(2.0));
        assert_eq!(priced(&demand).cost_ns(100.0), 40.0);
        assert_eq!(priced(&demand).least_ns(), 40.0);
    }

    #[test]
    fn each_kind_of_work_has_its_price() {
        let mut steps = options(&[(0.0, 100.0), (0.01, 40.0), (0.04, 10.0)]);
        steps[1].costs_ns = [0.0, 40.0, 0.0, 0.0];
        steps[2].costs_ns = [0.0, 0.0, 4.0, 6.0];
        let mut demand = Demand::NONE;
        demand.see(&steps, 100.0, ALL);
        let mut table = PricedDemand::NONE;
        demand.add_priced(&[2.0, 3.0, 0.5, 1.5], &mut table);
        for (px, cost) in [(0.5, 200.0), (1.25, 120.0), (5.0, 11.0)] {
            assert_eq!(table.cost_ns(px), cost, "{px} px");
        }
    }

    proptest! {
        /// A table of the tolerances that are asked for has the costs of one of all.
        #[test]
        fn only_the_tolerances_asked_for_are_summed(
            steps in prop::collection::vec((0.0001f32..0.2, 1.0f32..100.0), 1..6),
            spans in prop::collection::vec(1.0f32..1000.0, 1..30),
            least_px in 0.001f32..8.0,
            factor in 1.0f32..8.0,
            most_px in prop::option::of(1.0f32..16.0),
        ) {
            let mut steps = steps;
            steps.sort_by(|a, b| a.0.total_cmp(&b.0));
            let most_px = most_px.unwrap_or(f32::INFINITY);
            let some = Tolerances::new(least_px, most_px);
            let [mut all, mut asked] = [Demand::NONE; 2];
            for span in &spans {
                all.see(&options(&steps), *span, ALL.up_to(most_px));
                asked.see(&options(&steps), *span, some);
            }
            let [all, asked] = [all, asked].map(|demand| priced(&demand));
            let px = factor * least_px;
            let [a, b] = [&all, &asked].map(|table| table.cost_ns(px));
            // Whoever is finer than all tolerances has one option left, whatever its error.
            prop_assert!(most_px < least_px || (a - b).abs() <= 1e-2 + 1e-5 * a, "{a} {b}");
        }

        /// What is found costs no more than the budget, and a little less tolerance costs more.
        #[test]
        fn the_tolerance_found_is_the_least(
            steps in prop::collection::vec((0.0001f32..0.2, 1.0f32..100.0), 1..6),
            spans in prop::collection::vec(1.0f32..1000.0, 1..30),
            share in 0.0f64..1.0,
        ) {
            let (mut errors, mut costs): (Vec<f32>, Vec<f32>) = steps.into_iter().unzip();
            errors.sort_by(f32::total_cmp);
            costs.sort_by(|a, b| b.total_cmp(a));
            let steps: Vec<_> = errors.into_iter().zip(costs).collect();
            let mut demand = Demand::NONE;
            for span in &spans {
                demand.see(&options(&steps), *span, ALL);
            }
            let demand = priced(&demand);
            let [most, least] = [0.0, f32::MAX].map(|px| demand.cost_ns(px));
            prop_assert!(most >= least);
            let budget = least + share * (most - least);
            let px = demand.px_within(budget, FIRST_PX);
            prop_assert!(demand.cost_ns(px) <= budget + 1e-3 * most + 1e-3);
            if px > FIRST_PX {
                prop_assert!(demand.cost_ns(px * 0.999) >= budget - 2e-2 * most);
            }
        }
    }
}
