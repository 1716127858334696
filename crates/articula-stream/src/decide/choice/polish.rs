//! Improves a choice by changing one part, or two at once, until no such change helps.

use super::problem::{Picks, Problem};

/// Maximum number of changes.
const ROUNDS: usize = 24;

/// Takes the change of one part or of two that lowers the error most, within the budgets, again and
/// again. The choice given must fit.
pub(super) fn polish(problem: &Problem, mut picks: Picks) -> Picks {
    let mut cost = problem.sums(&picks).cost;
    for _ in 0..ROUNDS {
        let Some(changes) = best_change(problem, &picks, cost) else {
            break;
        };
        for (part, to) in changes {
            picks[part] = to;
        }
        cost = problem.sums(&picks).cost;
    }
    picks
}

/// The change of one part, or of two, that drops the error most; a change of one part is given
/// twice.
fn best_change(problem: &Problem, picks: &[usize], cost: [u64; 2]) -> Option<[(usize, usize); 2]> {
    // Smaller drops are rounding.
    let mut most = 1e-9;
    let mut best = None;
    for (a, part) in problem.parts.iter().enumerate() {
        let old = part[picks[a]];
        for (to, item) in part.iter().enumerate() {
            let without = [0, 1].map(|i| cost[i] - old.cost[i] + item.cost[i]);
            let drop = old.error - item.error;
            if drop > most && problem.fits(without) {
                (most, best) = (drop, Some([(a, to); 2]));
            }
            if to == picks[a] {
                continue;
            }
            for (b, other) in problem.parts.iter().enumerate().skip(a + 1) {
                let old = other[picks[b]];
                for (to_b, item) in other.iter().enumerate() {
                    let drop = drop + old.error - item.error;
                    if drop <= most {
                        continue;
                    }
                    let with = [0, 1].map(|i| without[i] - old.cost[i] + item.cost[i]);
                    if problem.fits(with) {
                        (most, best) = (drop, Some([(a, to), (b, to_b)]));
                    }
                }
            }
        }
    }
    best
}
