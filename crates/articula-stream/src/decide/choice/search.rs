//! Branch and bound by reduced costs: proves that a choice is the best, or finds the best.
//!
//! With prices `p, q` an item's reduced cost is how much its priced error exceeds the least of its
//! part. The error of a choice within the budgets is at least the bound of the prices plus the
//! reduced costs of its items, so only choices are visited whose sum stays below the distance of the
//! best one from the bound.

use super::dual::Dual;
use super::problem::{Picks, Problem, Sums, keep_better};

/// State of a search.
struct Search<'a> {
    problem: &'a Problem,
    bound: f64,
    /// Parts, those with the fewest candidates first, with items by rising reduced cost.
    order: Vec<(usize, Vec<(f64, usize)>)>,
    /// Least costs of the parts from each place of the order on.
    least: Vec<[u64; 2]>,
    picks: Picks,
    best: Option<(Picks, Sums)>,
    nodes: u32,
    limit: u32,
}

/// Searches from the best choice known. Returns the best found, and whether it is proved to be the
/// best of all, up to 1e-9 of its error; it is not if `limit` items were visited before the end.
pub(super) fn search(
    problem: &Problem,
    dual: &Dual,
    best: Option<(Picks, Sums)>,
    limit: u32,
) -> (Option<(Picks, Sums)>, bool) {
    let mut order: Vec<(usize, Vec<(f64, usize)>)> = Vec::with_capacity(problem.parts.len());
    for (index, part) in problem.parts.iter().enumerate() {
        let priced = |i: usize| part[i].priced(dual.price);
        let least = (0..part.len()).map(priced).fold(f64::INFINITY, f64::min);
        let mut items: Vec<(f64, usize)> =
            (0..part.len()).map(|i| (priced(i) - least, i)).collect();
        items.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        order.push((index, items));
    }
    let gap = best
        .as_ref()
        .map_or(f64::INFINITY, |b| b.1.error - dual.bound);
    let candidates = |items: &Vec<(f64, usize)>| items.partition_point(|i| i.0 < gap);
    order.sort_by_key(|(index, items)| (candidates(items), *index));
    let mut least = vec![[0; 2]; order.len() + 1];
    for (place, (index, _)) in order.iter().enumerate().rev() {
        let of = |axis: usize| problem.parts[*index].iter().map(|i| i.cost[axis]).min();
        least[place] = [0, 1].map(|a| least[place + 1][a] + of(a).unwrap_or(0));
    }
    let mut search = Search {
        problem,
        bound: dual.bound,
        order,
        least,
        picks: vec![0; problem.parts.len()],
        best,
        nodes: 0,
        limit,
    };
    let ended = search.visit(0, 0.0, [0; 2]);
    (search.best, ended)
}

impl Search<'_> {
    /// Visits all completions of the first `place` parts; false if the limit was reached.
    fn visit(&mut self, place: usize, reduced: f64, cost: [u64; 2]) -> bool {
        if place == self.order.len() {
            keep_better(self.problem, &mut self.best, &self.picks);
            return true;
        }
        let index = self.order[place].0;
        for i in 0..self.order[place].1.len() {
            let (more, item) = self.order[place].1[i];
            let floor = self.bound + reduced + more;
            let hopeless = |best: &(Picks, Sums)| floor >= best.1.error * (1.0 - 1e-9) - 1e-12;
            if self.best.as_ref().is_some_and(hopeless) {
                break;
            }
            if self.nodes == self.limit {
                return false;
            }
            self.nodes += 1;
            let own = self.problem.parts[index][item].cost;
            let rest = self.least[place + 1];
            let with = [0, 1].map(|a| cost[a] + own[a]);
            if !self.problem.fits([0, 1].map(|a| with[a] + rest[a])) {
                continue;
            }
            self.picks[index] = item;
            if !self.visit(place + 1, reduced + more, with) {
                return false;
            }
        }
        true
    }
}
