//! Sifting: moves single triangles to where they leave the fewest wrong samples.
//!
//! Source: sifting after Rudell 1993, here with the exact number of wrong samples: each set of
//! [`Overlaps`] constrains one member only, to come before or after one position.

use super::overlap::Overlaps;

/// Maximum number of rounds over all triangles; ends as soon as nothing moves.
const MAX_ROUNDS: usize = 24;

/// Improves an order for sets that count `weights` samples each. Triangles in no set keep their
/// relative positions.
pub(super) fn sift(overlaps: &Overlaps, weights: &[(u32, u64)], order: &mut Vec<u32>) {
    let mut sifter = Sifter::new(overlaps, weights, std::mem::take(order));
    for _ in 0..MAX_ROUNDS {
        if !sifter.round() {
            break;
        }
    }
    *order = sifter.order;
}

struct Sifter<'a> {
    overlaps: &'a Overlaps,
    weights: &'a [(u32, u64)],
    order: Vec<u32>,
    place: Vec<usize>,
    /// Indices into `weights` of the sets that contain each triangle.
    of: Vec<Vec<u32>>,
    /// Positions at which the cost of the current triangle changes, and by how much.
    steps: Vec<(usize, i64)>,
}

impl<'a> Sifter<'a> {
    fn new(overlaps: &'a Overlaps, weights: &'a [(u32, u64)], order: Vec<u32>) -> Self {
        let count = order.iter().max().map_or(0, |t| *t as usize + 1);
        let mut place = vec![0; count];
        for (p, t) in order.iter().enumerate() {
            place[*t as usize] = p;
        }
        let mut of = vec![Vec::new(); count];
        for (entry, (set, _)) in weights.iter().enumerate() {
            for t in overlaps.members(*set as usize) {
                of[*t as usize].push(entry as u32);
            }
        }
        Self {
            overlaps,
            weights,
            order,
            place,
            of,
            steps: Vec::new(),
        }
    }

    /// Tries to move every triangle once; returns whether any moved.
    fn round(&mut self) -> bool {
        let mut moved = false;
        for t in self.order.clone() {
            if let Some(place) = self.better_place(t) {
                self.shift(t, place);
                moved = true;
            }
        }
        moved
    }

    /// Nearest position with the least cost, if that is less than the current one.
    fn better_place(&mut self, triangle: u32) -> Option<usize> {
        let mut cost = self.collect_steps(triangle);
        self.steps.sort_unstable();
        let here = self.place[triangle as usize];
        let end = self.order.len() - 1;
        // Spans of positions (among the others) of equal cost, from the front.
        let (mut best, mut cost_here) = ((i64::MAX, usize::MAX, 0), 0);
        let (mut from, mut next) = (0, 0);
        loop {
            let to = self.steps.get(next).map_or(end, |step| step.0 - 1);
            if from <= to {
                let nearest = here.clamp(from, to);
                if nearest == here {
                    cost_here = cost;
                }
                best = best.min((cost, nearest.abs_diff(here), nearest));
            }
            let Some((start, _)) = self.steps.get(next).copied() else {
                break;
            };
            while let Some((_, change)) = self.steps.get(next).filter(|s| s.0 == start) {
                cost += change;
                next += 1;
            }
            from = start;
        }
        (best.0 < cost_here).then_some(best.2)
    }

    /// Fills [`Self::steps`]; returns the cost of the first position.
    fn collect_steps(&mut self, triangle: u32) -> i64 {
        self.steps.clear();
        let here = self.place[triangle as usize];
        // Position among the others.
        let without = |t: u32| {
            let p = self.place[t as usize];
            p - usize::from(p > here)
        };
        let mut first = 0;
        for entry in &self.of[triangle as usize] {
            let (set, weight) = self.weights[*entry as usize];
            let members = self.overlaps.members(set as usize);
            let others = members[1..].iter().filter(|t| **t != triangle);
            let last = others.map(|t| without(*t)).max();
            let weight = weight as i64;
            if members[0] == triangle {
                if let Some(last) = last {
                    first += weight;
                    self.steps.push((last + 1, -weight));
                }
            } else {
                let owner = without(members[0]);
                if last.is_none_or(|last| last < owner) {
                    self.steps.push((owner + 1, weight));
                }
            }
        }
        first
    }

    fn shift(&mut self, triangle: u32, to: usize) {
        let from = self.place[triangle as usize];
        if from < to {
            self.order[from..=to].rotate_left(1);
        } else {
            self.order[to..=from].rotate_right(1);
        }
        for p in from.min(to)..=from.max(to) {
            self.place[self.order[p] as usize] = p;
        }
    }
}
