//! Least squares with every unknown between 0 and a limit.

/// Solver of min xᵀ G x − 2 bᵀ x over 0 ≤ x ≤ l, for a symmetric positive definite G (row by row).
///
/// An active-set method (Björck 1996, Numerical Methods for Least Squares Problems, 5.2): unknowns
/// are held at a bound or free; the free ones are solved exactly, go as far as the first bound, and
/// a held one whose gradient points inwards is set free.
#[derive(Debug, Clone)]
pub(super) struct BoundedSolver {
    gram: Vec<f64>,
    count: usize,
    /// The last solution, from which the next starts.
    x: Vec<f64>,
    is_free: Vec<bool>,
    /// The limits of the last solution.
    limits: Vec<f64>,
    factor: Vec<f64>,
    free: Vec<usize>,
    target: Vec<f64>,
}

/// Maximum number of rounds for each unknown; a few in all are usual.
const ROUNDS: usize = 20;
/// Gradient, relative to the diagonal, below which a held unknown stays held.
const INWARDS: f64 = 1e-9;

impl BoundedSolver {
    pub(super) fn new(gram: Vec<f64>, count: usize) -> Self {
        Self {
            gram,
            count,
            x: vec![0.0; count],
            is_free: vec![false; count],
            limits: vec![1.0; count],
            factor: Vec::new(),
            free: Vec::with_capacity(count),
            target: Vec::with_capacity(count),
        }
    }

    /// Returns the solution. One limit for each unknown; what has the limit 0 is 0.
    pub(super) fn solve(&mut self, b: &[f64], limits: &[f64]) -> &[f64] {
        self.limit(limits);
        for _ in 0..ROUNDS * self.count.max(1) {
            self.solve_free(b);
            if self.step() {
                continue;
            }
            let Some(unknown) = self.most_inwards(b) else {
                break;
            };
            self.is_free[unknown] = true;
        }
        &self.x
    }

    /// Moves the last solution within limits: what is held stays at its bound.
    fn limit(&mut self, limits: &[f64]) {
        for (unknown, &limit) in limits.iter().enumerate() {
            let is_high = self.is_high(unknown);
            let x = &mut self.x[unknown];
            if !self.is_free[unknown] {
                *x = if is_high { limit } else { 0.0 };
            } else if *x > limit || limit <= 0.0 {
                *x = limit;
                self.is_free[unknown] = false;
            }
        }
        self.limits.copy_from_slice(limits);
    }

    /// Whether an unknown is nearer to its limit than to 0.
    fn is_high(&self, unknown: usize) -> bool {
        self.x[unknown] > 0.5 * self.limits[unknown]
    }

    /// Goes towards the solution of the free unknowns; whether one came to a bound, and is held.
    fn step(&mut self) -> bool {
        let mut share = 1.0;
        let mut first = None;
        for (&unknown, &target) in self.free.iter().zip(&self.target) {
            let limit = self.limits[unknown];
            if (0.0..=limit).contains(&target) {
                continue;
            }
            let (at, bound) = (self.x[unknown], if target < 0.0 { 0.0 } else { limit });
            let reach = ((bound - at) / (target - at)).clamp(0.0, 1.0);
            if reach < share || first.is_none() {
                (share, first) = (reach, Some((unknown, bound)));
            }
        }
        for (&unknown, &target) in self.free.iter().zip(&self.target) {
            let x = &mut self.x[unknown];
            *x = (*x + share * (target - *x)).clamp(0.0, self.limits[unknown]);
        }
        if let Some((unknown, bound)) = first {
            self.x[unknown] = bound;
            self.is_free[unknown] = false;
        }
        first.is_some()
    }

    /// The held unknown that would reduce the error most quickly by leaving its bound.
    fn most_inwards(&self, b: &[f64]) -> Option<usize> {
        let held = (0..self.count).filter(|u| !self.is_free[*u] && self.limits[*u] > 0.0);
        let inwards = held.map(|unknown| {
            let row = &self.gram[unknown * self.count..][..self.count];
            let slope: f64 = row.iter().zip(&self.x).map(|(g, x)| g * x).sum();
            let down = b[unknown] - slope;
            let inwards = if self.is_high(unknown) { -down } else { down };
            (inwards / row[unknown], unknown)
        });
        let most = inwards.max_by(|a, b| a.0.total_cmp(&b.0))?;
        (most.0 > INWARDS).then_some(most.1)
    }

    /// Solves the free unknowns, with the held ones at their bounds, by Cholesky's factors.
    fn solve_free(&mut self, b: &[f64]) {
        self.free.clear();
        self.free
            .extend((0..self.count).filter(|u| self.is_free[*u]));
        let n = self.free.len();
        self.factor.resize(n * n, 0.0);
        self.target.clear();
        for (i, &row) in self.free.iter().enumerate() {
            let gram = &self.gram[row * self.count..][..self.count];
            let held = (0..self.count).filter(|u| !self.is_free[*u]);
            let of_held: f64 = held.map(|u| gram[u] * self.x[u]).sum();
            let mut sum = b[row] - of_held;
            for j in 0..=i {
                let (above, below) = (j * n, i * n);
                let product: f64 = (0..j)
                    .map(|k| self.factor[above + k] * self.factor[below + k])
                    .sum();
                let left = gram[self.free[j]] - product;
                self.factor[below + j] = if i == j {
                    left.sqrt()
                } else {
                    left / self.factor[above + j]
                };
            }
            for j in 0..i {
                sum -= self.factor[i * n + j] * self.target[j];
            }
            self.target.push(sum / self.factor[i * n + i]);
        }
        for i in (0..n).rev() {
            for j in i + 1..n {
                self.target[i] -= self.factor[j * n + i] * self.target[j];
            }
            self.target[i] /= self.factor[i * n + i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Projected coordinate descent, many rounds.
    fn plain(gram: &[f64], b: &[f64], limits: &[f64]) -> Vec<f64> {
        let n = b.len();
        let mut x = vec![0.0; n];
        for _ in 0..20_000 {
            for i in 0..n {
                let slope: f64 = (0..n).map(|j| gram[i * n + j] * x[j]).sum();
                x[i] = f64::clamp(x[i] + (b[i] - slope) / gram[i * n + i], 0.0, limits[i]);
            }
        }
        x
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn agrees_with_coordinate_descent(
            rows in prop::collection::vec(prop::collection::vec(-1.0..1.0_f64, 5), 7),
            targets in prop::collection::vec(prop::collection::vec(-2.0..2.0_f64, 7), 3),
            limits in prop::collection::vec(prop::collection::vec(-0.3..1.3_f64, 5), 3),
        ) {
            let n = 5;
            let mut gram = vec![0.0; n * n];
            for i in 0..n {
                for j in 0..n {
                    gram[i * n + j] = rows.iter().map(|r| r[i] * r[j]).sum();
                }
                gram[i * n + i] += 0.05;
            }
            let mut solver = BoundedSolver::new(gram.clone(), n);
            // One after the other, each from the solution of the one before.
            for (target, limits) in targets.iter().zip(&limits) {
                let limits: Vec<f64> = limits.iter().map(|l| l.clamp(0.0, 1.0)).collect();
                let b: Vec<f64> = (0..n).map(|i| rows.iter().zip(target).map(|(r, t)| r[i] * t).sum()).collect();
                let wanted = plain(&gram, &b, &limits);
                let found = solver.solve(&b, &limits);
                for ((found, wanted), limit) in found.iter().zip(&wanted).zip(&limits) {
                    prop_assert!((0.0..=*limit).contains(found));
                    prop_assert!((found - wanted).abs() < 1e-6, "{found}, not {wanted}");
                }
            }
        }
    }

    #[test]
    fn nothing_to_solve() {
        assert!(BoundedSolver::new(Vec::new(), 0).solve(&[], &[]).is_empty());
    }
}
