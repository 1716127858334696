//! The choice as a problem of numbers: parts of items with two costs and an error.

/// An option as numbers. Costs are whole, so sums do not depend on their order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Item {
    /// Index among the options of the part.
    pub(super) option: u16,
    /// The two costs.
    pub(super) cost: [u64; 2],
    /// What is made small.
    pub(super) error: f64,
    /// The costs as shares of the budgets.
    pub(super) share: [f64; 2],
}

/// One item of each part is chosen, within two budgets, with the least sum of errors.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Problem {
    /// Items that fit alone and that no other dominates; by cost, then by error.
    pub(super) parts: Vec<Vec<Item>>,
    pub(super) budget: [u64; 2],
}

/// Indices of the chosen items.
pub(super) type Picks = Vec<usize>;

/// Sums of a choice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sums {
    pub(super) cost: [u64; 2],
    pub(super) error: f64,
}

impl Problem {
    /// Sorts out items that do not fit or are dominated: another one has no greater cost and error.
    /// `None` if a part has no item left, or the cheapest items of all parts exceed a budget.
    pub(super) fn new(
        items: impl Iterator<Item = Vec<(u16, [u64; 2], f64)>>,
        budget: [u64; 2],
    ) -> Option<Self> {
        let share = |cost: u64, axis: usize| match budget[axis] {
            0 => 0.0,
            whole => cost as f64 / whole as f64,
        };
        let mut parts = Vec::new();
        for part in items {
            let fits = |i: &(u16, [u64; 2], f64)| i.1[0] <= budget[0] && i.1[1] <= budget[1];
            let mut all: Vec<Item> = part
                .into_iter()
                .filter(fits)
                .map(|(option, cost, error)| Item {
                    option,
                    cost,
                    error,
                    share: [share(cost[0], 0), share(cost[1], 1)],
                })
                .collect();
            all.sort_by(|a, b| {
                let by_cost = a.cost.cmp(&b.cost);
                by_cost
                    .then(a.error.total_cmp(&b.error))
                    .then(a.option.cmp(&b.option))
            });
            // A dominating item precedes: it is cheaper, or as cheap with no greater error.
            let mut kept: Vec<Item> = Vec::with_capacity(all.len());
            for item in all {
                let worse = |k: &Item| k.cost[1] <= item.cost[1] && k.error <= item.error;
                if !kept.iter().any(worse) {
                    kept.push(item);
                }
            }
            if kept.is_empty() {
                return None;
            }
            parts.push(kept);
        }
        let problem = Self { parts, budget };
        let least = |axis: usize| -> u64 {
            let of = |part: &Vec<Item>| part.iter().map(|i| i.cost[axis]).min().unwrap_or(0);
            problem.parts.iter().map(of).sum()
        };
        (least(0) <= budget[0] && least(1) <= budget[1]).then_some(problem)
    }

    pub(super) fn sums(&self, picks: &[usize]) -> Sums {
        let mut sums = Sums {
            cost: [0; 2],
            error: 0.0,
        };
        for (part, pick) in self.parts.iter().zip(picks) {
            let item = &part[*pick];
            sums.cost[0] += item.cost[0];
            sums.cost[1] += item.cost[1];
            sums.error += item.error;
        }
        sums
    }

    pub(super) fn fits(&self, cost: [u64; 2]) -> bool {
        cost[0] <= self.budget[0] && cost[1] <= self.budget[1]
    }
}

/// Replaces the best choice so far by another if that fits and has a smaller error, or an equal one
/// and a smaller cost.
pub(super) fn keep_better(problem: &Problem, best: &mut Option<(Picks, Sums)>, picks: &[usize]) {
    let sums = problem.sums(picks);
    if !problem.fits(sums.cost) {
        return;
    }
    let better = best.as_ref().is_none_or(|(_, old)| {
        let by_error = sums.error.total_cmp(&old.error);
        by_error.then(sums.cost.cmp(&old.cost)).is_lt()
    });
    if better {
        *best = Some((picks.to_vec(), sums));
    }
}
