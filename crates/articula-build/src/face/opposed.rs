//! Least squares in which of two unknowns that undo each other one is 0.

use super::bounded::BoundedSolver;

/// Share of the larger of two opposites by which it must be ahead to be used without a limit. Below, it
/// fades, so that neither jumps when the other one gets ahead.
const AHEAD: f64 = 0.25;

/// Solver of min xᵀ G x − 2 bᵀ x over 0 ≤ x ≤ 1, where of each pair of opposites at most one is not 0.
///
/// The problem without the pairs is solved first. Of two opposites, the one whose part x √Gᵢᵢ is
/// smaller then has the limit 0, the other one min(1, (1 − smaller / larger) / [`AHEAD`]), and the
/// problem is solved again within these limits. Both problems are strictly convex and the limits are continuous
/// where the first solution is not 0, so the solution does not depend on the frame before.
#[derive(Debug, Clone)]
pub(super) struct OpposedSolver {
    opposites: Vec<[usize; 2]>,
    /// √Gᵢᵢ.
    lengths: Vec<f64>,
    alone: BoundedSolver,
    limited: BoundedSolver,
    limits: Vec<f64>,
}

impl OpposedSolver {
    pub(super) fn new(gram: Vec<f64>, count: usize, opposites: Vec<[usize; 2]>) -> Self {
        Self {
            opposites,
            lengths: (0..count).map(|i| gram[i * count + i].sqrt()).collect(),
            alone: BoundedSolver::new(gram.clone(), count),
            limited: BoundedSolver::new(gram, count),
            limits: vec![1.0; count],
        }
    }

    /// Returns the solution.
    pub(super) fn solve(&mut self, b: &[f64]) -> &[f64] {
        self.limits.fill(1.0);
        let found = self.alone.solve(b, &self.limits);
        let is_both = |[i, j]: &[usize; 2]| found[*i] > 0.0 && found[*j] > 0.0;
        if !self.opposites.iter().any(is_both) {
            return found;
        }
        for &[i, j] in &self.opposites {
            let [a, c] = [i, j].map(|k| found[k] * self.lengths[k]);
            self.limits[i] = self.limits[i].min(limit(a, c));
            self.limits[j] = self.limits[j].min(limit(c, a));
        }
        self.limited.solve(b, &self.limits)
    }
}

/// The limit of an unknown by its part and that of its opposite.
fn limit(own: f64, other: f64) -> f64 {
    if own <= other {
        return 0.0;
    }
    ((1.0 - other / own) / AHEAD).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The Gram matrix of columns, with a small diagonal.
    fn gram(columns: &[Vec<f64>]) -> Vec<f64> {
        let n = columns.len();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let entry = |k: usize| {
            dot(&columns[k / n], &columns[k % n])
                + f64::from(u8::from(k.is_multiple_of(n + 1))) * 0.01
        };
        (0..n * n).map(entry).collect()
    }

    proptest! {
        #[test]
        fn one_of_two_opposites_is_zero(
            columns in prop::collection::vec(prop::collection::vec(-1.0..1.0_f64, 6), 6),
            targets in prop::collection::vec(prop::collection::vec(-2.0..2.0_f64, 6), 3),
        ) {
            let pairs = vec![[0, 1], [0, 2], [3, 4]];
            let mut solver = OpposedSolver::new(gram(&columns), 6, pairs.clone());
            for b in &targets {
                let found = solver.solve(b).to_vec();
                prop_assert!(pairs.iter().all(|[i, j]| found[*i] == 0.0 || found[*j] == 0.0));
                // As from rest: the frame before does not matter.
                let mut again = OpposedSolver::new(gram(&columns), 6, pairs.clone());
                for (a, b) in found.iter().zip(again.solve(b)) {
                    prop_assert!((a - b).abs() < 1e-9);
                }
            }
        }
    }

    #[test]
    fn opposites_that_cancel_are_both_zero() {
        // Two columns whose sum is a third of each: (1, 3) and (1, -3); (2, 0) is both at once.
        let columns = [vec![1.0, 3.0], vec![1.0, -3.0]];
        let mut free = OpposedSolver::new(gram(&columns), 2, Vec::new());
        assert!(free.solve(&[2.0, 2.0]).iter().all(|x| *x > 0.9));
        let mut tied = OpposedSolver::new(gram(&columns), 2, vec![[0, 1]]);
        assert!(tied.solve(&[2.0, 2.0]).iter().all(|x| *x < 1e-12));
        // (1, 3) alone is as it is without opposites.
        assert!((tied.solve(&[10.0, -8.0])[0] - 10.0 / 10.01).abs() < 1e-9);
    }

    #[test]
    fn limits_fade_towards_a_draw() {
        assert_eq!(
            [
                limit(1.0, 0.0),
                limit(1.0, 0.75),
                limit(1.0, 1.0),
                limit(0.0, 0.0)
            ],
            [1.0, 1.0, 0.0, 0.0]
        );
        assert!((limit(1.0, 0.875) - 0.5).abs() < 1e-12);
    }
}
