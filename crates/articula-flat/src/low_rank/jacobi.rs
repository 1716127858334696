//! Eigenvalues and eigenvectors of a small symmetric matrix.
//!
//! Source: C. G. J. Jacobi 1846; Golub and Van Loan, *Matrix Computations*, 8.5: cyclic rotations,
//! each of which makes one pair of entries zero. Slow beyond a few hundred rows, accurate to
//! machine precision.

/// Maximum number of sweeps over all pairs; about ten are enough.
const SWEEPS: usize = 60;

/// An eigenvalue with its eigenvector of unit length.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct EigenPair {
    /// The eigenvalue.
    pub value: f64,
    /// The eigenvector.
    pub vector: Vec<f64>,
}

/// Returns all eigenpairs of a symmetric matrix given row by row, largest eigenvalue first.
pub(super) fn symmetric_eigen(matrix: &[f64]) -> Vec<EigenPair> {
    let n = matrix.len().isqrt();
    let mut a = matrix.to_vec();
    let mut vectors: Vec<Vec<f64>> = (0..n)
        .map(|i| (0..n).map(|j| if i == j { 1.0 } else { 0.0 }).collect())
        .collect();
    for _ in 0..SWEEPS {
        let mut is_diagonal = true;
        for p in 0..n {
            for q in p + 1..n {
                let off = a[p * n + q];
                let size = (a[p * n + p] * a[q * n + q]).abs().sqrt();
                if off.abs() <= size * 1e-15 || off.abs() < f64::MIN_POSITIVE {
                    continue;
                }
                is_diagonal = false;
                let (cos, sin) = rotation(a[p * n + p], a[q * n + q], off);
                rotate(&mut a, n, (p, q), (cos, sin));
                let (head, tail) = vectors.split_at_mut(q);
                for (x, y) in head[p].iter_mut().zip(&mut tail[0]) {
                    (*x, *y) = (cos * *x - sin * *y, sin * *x + cos * *y);
                }
            }
        }
        if is_diagonal {
            break;
        }
    }
    let mut pairs: Vec<EigenPair> = vectors
        .into_iter()
        .enumerate()
        .map(|(i, vector)| EigenPair {
            value: a[i * n + i],
            vector,
        })
        .collect();
    pairs.sort_by(|a, b| b.value.total_cmp(&a.value));
    pairs
}

/// Cosine and sine of the smaller angle that makes an off-diagonal entry zero.
fn rotation(pp: f64, qq: f64, pq: f64) -> (f64, f64) {
    let theta = (qq - pp) / (2.0 * pq);
    let tan = theta.signum() / (theta.abs() + theta.hypot(1.0));
    let cos = 1.0 / tan.hypot(1.0);
    (cos, tan * cos)
}

fn rotate(a: &mut [f64], n: usize, (p, q): (usize, usize), (cos, sin): (f64, f64)) {
    for k in 0..n {
        let (x, y) = (a[k * n + p], a[k * n + q]);
        a[k * n + p] = cos * x - sin * y;
        a[k * n + q] = sin * x + cos * y;
    }
    for k in 0..n {
        let (x, y) = (a[p * n + k], a[q * n + k]);
        a[p * n + k] = cos * x - sin * y;
        a[q * n + k] = sin * x + cos * y;
    }
    a[p * n + q] = 0.0;
    a[q * n + p] = 0.0;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_of_three_rows_has_its_known_pairs() {
        // Eigenvalues 4, 2 and 1 by hand: (1, 1, 0), (1, -1, 0) and (0, 0, 1).
        let pairs = symmetric_eigen(&[3.0, 1.0, 0.0, 1.0, 3.0, 0.0, 0.0, 0.0, 1.0]);
        let half = 0.5f64.sqrt();
        let expected = [
            (4.0, [half, half, 0.0]),
            (2.0, [half, -half, 0.0]),
            (1.0, [0.0, 0.0, 1.0]),
        ];
        for (pair, (value, vector)) in pairs.iter().zip(expected) {
            assert!((pair.value - value).abs() < 1e-14);
            let same: f64 = pair.vector.iter().zip(vector).map(|(a, b)| a * b).sum();
            assert!((same.abs() - 1.0).abs() < 1e-14);
        }
        assert!(symmetric_eigen(&[]).is_empty());
    }

    #[test]
    fn every_pair_solves_its_equation() {
        let n = 20usize;
        let entry =
            |i: usize, j: usize| ((i * j + i + j) as f64 * 0.37).sin() + 3.0 * f64::from(i == j);
        let matrix: Vec<f64> = (0..n * n).map(|k| entry(k / n, k % n)).collect();
        let pairs = symmetric_eigen(&matrix);
        let trace: f64 = pairs.iter().map(|pair| pair.value).sum();
        let wanted: f64 = (0..n).map(|i| matrix[i * n + i]).sum();
        assert!((trace - wanted).abs() < 1e-9);
        for pair in pairs {
            for i in 0..n {
                let left: f64 = (0..n).map(|j| matrix[i * n + j] * pair.vector[j]).sum();
                assert!((left - pair.value * pair.vector[i]).abs() < 1e-9);
            }
        }
    }
}
