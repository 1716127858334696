//! Time budget of a frame: what is left for evaluation, and learnt unit costs.

use articula_core::budget::{CostModel, Workload};
use articula_core::crowd::{Crowd, CrowdModel};

/// Interval of cost checks in frames, and the relative deviation above which costs are updated.
const REPRICE_FRAMES: usize = 8;
const STALE: f64 = 0.05;

/// Weight of a new frame in the mean time spent outside of evaluation.
const GAIN: f64 = 0.1;

/// Evaluation budget of one frame. A recorded value reproduces the decisions of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameBudget {
    /// Time for evaluation, in nanoseconds.
    pub cost_ns: f32,
    /// New unit costs, if the current ones are out of date.
    pub prices: Option<CostModel>,
}

impl FrameBudget {
    /// A budget in nanoseconds at the current unit costs.
    pub fn from_ns(cost_ns: f32) -> Self {
        Self {
            cost_ns,
            prices: None,
        }
    }

    /// Passes new unit costs to the crowd.
    pub(super) fn apply(&self, crowd: &mut Crowd, model: &CrowdModel) {
        if let Some(prices) = &self.prices {
            crowd.reprice(model, prices);
        }
    }
}

/// Learns the cost of frames and computes the evaluation budget of the next one. It reads no clock:
/// the caller passes measured times.
///
/// ```
/// use articula::crowd::BudgetController;
///
/// let mut budget = BudgetController::new(2.0);
/// assert_eq!(budget.next_budget().cost_ns, 2e6);
/// // After the frame: what it did, and the nanoseconds that planning and evaluation took.
/// budget.observe(&Default::default(), 500_000.0, 0.0);
/// assert!(budget.next_budget().cost_ns <= 1.5e6);
/// ```
#[derive(Debug)]
pub struct BudgetController {
    budget_ns: f64,
    costs: CostModel,
    /// Cost model that the crowd uses now.
    given: CostModel,
    /// Mean time of a frame outside of evaluation.
    tick_ns: Option<f64>,
    frames: usize,
}

impl BudgetController {
    /// Creates a controller for a budget in milliseconds of processor time per frame.
    pub fn new(budget_ms: f32) -> Self {
        Self {
            budget_ns: f64::from(budget_ms) * 1e6,
            costs: CostModel::default(),
            given: CostModel::default(),
            tick_ns: None,
            frames: 0,
        }
    }

    /// Returns the budget of the next frame.
    pub fn next_budget(&mut self) -> FrameBudget {
        let due = self.frames > 0 && self.frames.is_multiple_of(REPRICE_FRAMES);
        // New costs rebuild the choice of every character, which is expensive.
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

    /// Learns from a frame: the work that was evaluated and the nanoseconds spent before and in the
    /// evaluation, summed over all threads.
    pub fn observe(&mut self, work: &Workload, tick_ns: f64, evaluate_ns: f64) {
        self.costs.observe(work, evaluate_ns);
        let mean = self.tick_ns.unwrap_or(tick_ns);
        // Clamped to twice the mean, so that an interrupted frame does not distort it.
        self.tick_ns = Some(mean + GAIN * (tick_ns.min(2.0 * mean) - mean));
    }
}

/// Returns whether the cost of a small or a large pose has changed noticeably.
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
        assert_eq!(allocator.next_budget().cost_ns, 1e6);
        let work = Workload {
            characters: 1000,
            ..Workload::default()
        };
        allocator.observe(&work, 200_000.0, 1000.0);
        // A little less, since measured times vary.
        let about = |cost: f32, left: f32| cost <= left && cost > 0.97 * left;
        assert!(about(allocator.next_budget().cost_ns, 800_000.0));
        // Moves by a tenth, towards at most twice the mean.
        allocator.observe(&work, 9e9, 1000.0);
        assert!(about(allocator.next_budget().cost_ns, 780_000.0));
        assert!(BudgetController::new(0.1).next_budget().prices.is_none());
        let mut poor = BudgetController::new(0.1);
        poor.observe(&work, 5e5, 1000.0);
        assert_eq!(poor.next_budget().cost_ns, 0.0);
    }
}
