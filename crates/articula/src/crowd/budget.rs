//! What a frame may cost: the budget less what is not evaluation, and unit costs that learn.

use articula_core::budget::{CostModel, Workload};
use articula_core::crowd::{Crowd, CrowdModel};

/// Prices are looked at every so many frames, and renewed if they are off by more than this part.
const REPRICE_FRAMES: usize = 8;
const STALE: f64 = 0.05;

/// Share of a new frame in the mean cost of what is not evaluation.
const GAIN: f64 = 0.1;

/// What a frame may spend. Kept, it makes another run decide alike.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameBudget {
    /// What evaluation may cost, nanoseconds.
    pub cost_ns: f32,
    /// New prices of poses, if the old ones were off.
    pub prices: Option<CostModel>,
}

impl FrameBudget {
    /// So many nanoseconds at the prices that are known.
    pub fn of_ns(cost_ns: f32) -> Self {
        Self {
            cost_ns,
            prices: None,
        }
    }

    /// Hands new prices on.
    pub(super) fn apply(&self, crowd: &mut Crowd, model: &CrowdModel) {
        if let Some(prices) = &self.prices {
            crowd.reprice(model, prices);
        }
    }
}

/// Learns what frames cost, and says what the next one may spend on evaluation. It has no clock:
/// what frames took is told by the caller.
///
/// ```
/// use articula::crowd::BudgetController;
///
/// let mut budget = BudgetController::new(2.0);
/// assert_eq!(budget.decide().cost_ns, 2e6);
/// // After the frame: what it did, and the nanoseconds that planning and evaluation took.
/// budget.observe(&Default::default(), 500_000.0, 0.0);
/// assert!(budget.decide().cost_ns <= 1.5e6);
/// ```
#[derive(Debug)]
pub struct BudgetController {
    budget_ns: f64,
    costs: CostModel,
    /// What the crowd's prices were made from.
    given: CostModel,
    /// Mean of what a frame costs besides evaluation.
    tick_ns: Option<f64>,
    frames: usize,
}

impl BudgetController {
    /// So many milliseconds of processor time for each frame.
    pub fn new(budget_ms: f32) -> Self {
        Self {
            budget_ns: f64::from(budget_ms) * 1e6,
            costs: CostModel::default(),
            given: CostModel::default(),
            tick_ns: None,
            frames: 0,
        }
    }

    /// What the next frame may spend.
    pub fn decide(&mut self) -> FrameBudget {
        let due = self.frames > 0 && self.frames.is_multiple_of(REPRICE_FRAMES);
        // New prices place everyone anew, which is dear itself.
        let renew = due && is_stale(&self.given, &self.costs);
        if renew {
            self.given = self.costs.clone();
        }
        self.frames += 1;
        let left = self.budget_ns - self.tick_ns.unwrap_or(0.0);
        FrameBudget {
            cost_ns: self.costs.spendable_ns(left.max(0.0)) as f32,
            prices: renew.then(|| self.costs.clone()),
        }
    }

    /// Learns from a frame: what was evaluated, and the nanoseconds that everything before the
    /// evaluation, and the evaluation took, on all threads together.
    pub fn observe(&mut self, work: &Workload, tick_ns: f64, evaluate_ns: f64) {
        self.costs.observe(work, evaluate_ns);
        let mean = self.tick_ns.unwrap_or(tick_ns);
        // A frame that was interrupted does not count for more than twice the mean.
        self.tick_ns = Some(mean + GAIN * (tick_ns.min(2.0 * mean) - mean));
    }
}

/// Whether a pose of few or of many joints costs something else by now.
fn is_stale(given: &CostModel, now: &CostModel) -> bool {
    [8, 64].into_iter().any(|joints| {
        let pose = Workload {
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
        let mut allocator = BudgetController::new(1.0);
        assert_eq!(allocator.decide().cost_ns, 1e6);
        let work = Workload {
            characters: 1000,
            ..Workload::default()
        };
        allocator.observe(&work, 200_000.0, 1000.0);
        // A little less where times were seen to spread.
        let about = |cost: f32, left: f32| cost <= left && cost > 0.97 * left;
        assert!(about(allocator.decide().cost_ns, 800_000.0));
        // A tenth of the way, and no farther than twice the mean.
        allocator.observe(&work, 9e9, 1000.0);
        assert!(about(allocator.decide().cost_ns, 780_000.0));
        assert!(BudgetController::new(0.1).decide().prices.is_none());
        let mut poor = BudgetController::new(0.1);
        poor.observe(&work, 5e5, 1000.0);
        assert_eq!(poor.decide().cost_ns, 0.0);
    }
}
