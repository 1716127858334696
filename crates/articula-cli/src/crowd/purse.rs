//! What a frame may cost: the budget less what is not evaluation, and unit costs that learn.

use articula_core::budget::{CostModel, Work};
use articula_core::crowd::{Crowd, CrowdModel};

/// Prices are looked at every so many frames, and renewed if they are off by more than this part.
const REPRICE_FRAMES: usize = 8;
const STALE: f64 = 0.05;

/// Share of a new frame in the mean cost of what is not evaluation.
const GAIN: f64 = 0.1;

/// What was decided for a frame, so that it can be decided alike again.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Decision {
    /// What evaluation may cost, nanoseconds.
    pub(crate) cost: f32,
    /// New prices, if there were any.
    pub(crate) prices: Option<CostModel>,
}

impl Decision {
    /// Hands new prices on.
    pub(crate) fn apply(&self, crowd: &mut Crowd, model: &CrowdModel) {
        if let Some(prices) = &self.prices {
            crowd.reprice(model, prices);
        }
    }
}

/// Learns what frames cost.
#[derive(Debug)]
pub(crate) struct Purse {
    budget_ns: f64,
    costs: CostModel,
    /// What the crowd's prices were made from.
    given: CostModel,
    /// Mean of what a frame costs besides evaluation.
    tick_ns: Option<f64>,
    frames: usize,
}

impl Purse {
    /// A purse of so much for each frame.
    pub(crate) fn new(budget_ms: f32) -> Self {
        Self {
            budget_ns: f64::from(budget_ms) * 1e6,
            costs: CostModel::default(),
            given: CostModel::default(),
            tick_ns: None,
            frames: 0,
        }
    }

    /// What the next frame may spend.
    pub(crate) fn decide(&mut self) -> Decision {
        let due = self.frames > 0 && self.frames.is_multiple_of(REPRICE_FRAMES);
        // New prices place everyone anew, which is dear itself.
        let renew = due && is_stale(&self.given, &self.costs);
        if renew {
            self.given = self.costs.clone();
        }
        self.frames += 1;
        let left = self.budget_ns - self.tick_ns.unwrap_or(0.0);
        Decision {
            cost: self.costs.spendable_ns(left.max(0.0)) as f32,
            prices: renew.then(|| self.costs.clone()),
        }
    }

    /// Learns from a frame.
    pub(crate) fn observe(&mut self, work: &Work, tick_ns: f64, evaluate_ns: f64) {
        self.costs.observe(work, evaluate_ns);
        let mean = self.tick_ns.unwrap_or(tick_ns);
        // A frame that was interrupted does not count for more than twice the mean.
        self.tick_ns = Some(mean + GAIN * (tick_ns.min(2.0 * mean) - mean));
    }
}

/// Whether a pose of few or of many joints costs something else by now.
fn is_stale(given: &CostModel, now: &CostModel) -> bool {
    [8, 64].into_iter().any(|joints| {
        let pose = Work {
            characters: 1,
            sampled_joints: joints,
            fk_joints: joints,
            matrices: joints,
        };
        let ratio = now.cost_ns(&pose) / given.cost_ns(&pose);
        !(1.0 - STALE..=1.0 + STALE).contains(&ratio)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_evaluation_is_taken_off() {
        let mut purse = Purse::new(1.0);
        assert_eq!(purse.decide().cost, 1e6);
        let work = Work {
            characters: 1000,
            ..Work::default()
        };
        purse.observe(&work, 200_000.0, 1000.0);
        // A little less where times were seen to spread.
        let about = |cost: f32, left: f32| cost <= left && cost > 0.97 * left;
        assert!(about(purse.decide().cost, 800_000.0));
        // A tenth of the way, and no farther than twice the mean.
        purse.observe(&work, 9e9, 1000.0);
        assert!(about(purse.decide().cost, 780_000.0));
        assert!(Purse::new(0.1).decide().prices.is_none());
        let mut poor = Purse::new(0.1);
        poor.observe(&work, 5e5, 1000.0);
        assert_eq!(poor.decide().cost, 0.0);
    }
}
