//! The greedy choice: upgrades along the lower hull of each part, by error drop per priced cost.
//!
//! Its error is at most one upgrade above the linear relaxation where one budget binds, and at most
//! two where both do and the options of each part are a chain (`docs/methods/adaptation.md` part 3).

use super::problem::{Item, Picks, Problem};

/// An upgrade from one point of a hull to the next.
#[derive(Debug, Clone, Copy)]
struct Step {
    part: usize,
    to: usize,
    drop: f64,
    /// Error drop per priced cost; infinite where it costs nothing.
    ratio: f64,
}

/// Picks of the greedy choice, within the budgets or not, and the greatest error drop of an upgrade.
pub(super) fn greedy(problem: &Problem, price: [f64; 2]) -> (Picks, f64) {
    let mut steps = Vec::with_capacity(problem.parts.iter().map(Vec::len).sum());
    let mut picks = Vec::with_capacity(problem.parts.len());
    for (i, part) in problem.parts.iter().enumerate() {
        picks.push(hull(i, part, price, &mut steps));
    }
    let largest = steps.iter().map(|s| s.drop).fold(0.0, f64::max);
    steps.sort_by(|a, b| b.ratio.total_cmp(&a.ratio));
    let mut cost = problem.sums(&picks).cost;
    let mut closed = vec![false; problem.parts.len()];
    for step in steps.iter().filter(|s| s.drop > 0.0) {
        let part = &problem.parts[step.part];
        let from = &part[picks[step.part]];
        let to = &part[step.to];
        let with = [0, 1].map(|a| cost[a] - from.cost[a] + to.cost[a]);
        if closed[step.part] {
            continue;
        }
        if problem.fits(with) || !problem.fits(cost) {
            cost = with;
            picks[step.part] = step.to;
        } else {
            // Later upgrades of a hull start from this one.
            closed[step.part] = true;
        }
    }
    (picks, largest)
}

/// Appends the upgrades along the hull of a part over (priced cost, error), and returns its first
/// item, the one of least priced cost.
fn hull(index: usize, part: &[Item], price: [f64; 2], steps: &mut Vec<Step>) -> usize {
    let cost = |i: usize| price[0] * part[i].share[0] + price[1] * part[i].share[1];
    let first_step = steps.len();
    let cheaper = |a: &usize, b: &usize| {
        let by_cost = cost(*a).total_cmp(&cost(*b));
        by_cost.then(part[*a].error.total_cmp(&part[*b].error))
    };
    let first = (0..part.len()).min_by(cheaper).unwrap_or(0);
    let mut at = first;
    // From each point, the next is the one of the steepest descent; of equals the nearest.
    loop {
        let mut next: Option<Step> = None;
        for (to, item) in part.iter().enumerate() {
            let drop = part[at].error - item.error;
            if drop <= 0.0 {
                continue;
            }
            let rise = cost(to) - cost(at);
            let ratio = if rise > 0.0 {
                drop / rise
            } else {
                f64::INFINITY
            };
            let steeper = next.is_none_or(|n| {
                ratio > n.ratio || (ratio == n.ratio && (drop < n.drop) == ratio.is_finite())
            });
            if steeper {
                next = Some(Step {
                    part: index,
                    to,
                    drop,
                    ratio,
                });
            }
        }
        let Some(step) = next else { break };
        at = step.to;
        steps.push(step);
    }
    // Rounding never makes a later upgrade come first.
    for i in first_step + 1..steps.len() {
        steps[i].ratio = steps[i].ratio.min(steps[i - 1].ratio);
    }
    first
}
