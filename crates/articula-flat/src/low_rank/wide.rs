//! Truncated singular value decomposition of few, very long rows.
//!
//! Source: Eckart and Young 1936; subspace iteration on the Gram matrix of the rows. Deterministic:
//! the start is fixed.

use super::orthonormal::{dot, orthonormalise};

/// Rounds of the iteration; significant modes converge in a few.
const ROUNDS: usize = 40;

/// Returns the leading left singular vectors of a matrix, orthonormal, the strongest first.
///
/// `rows` have equal lengths. The result is shorter if the matrix has a lower rank.
pub(crate) fn modes(rows: &[Vec<f64>], most: usize) -> Vec<Vec<f64>> {
    let count = rows.len();
    let mut gram = vec![0.0; count * count];
    for i in 0..count {
        for j in 0..=i {
            let dot = dot(&rows[i], &rows[j]);
            gram[i * count + j] = dot;
            gram[j * count + i] = dot;
        }
    }
    let total: f64 = (0..count).map(|i| gram[i * count + i]).sum();
    if total.is_nan() || total <= 0.0 {
        return Vec::new();
    }
    let mut found: Vec<Vec<f64>> = (0..most.min(count)).map(|k| start(count, k)).collect();
    for round in 0..ROUNDS {
        for vector in &mut found {
            let product = |i: usize| dot(&gram[i * count..(i + 1) * count], vector);
            *vector = (0..count).map(product).collect();
        }
        let last = round + 1 == ROUNDS;
        let least = if last { total * 1e-13 } else { 0.0 };
        orthonormalise(&mut found, |_, length| length <= least);
    }
    found
}

/// A fixed start vector without symmetry.
fn start(count: usize, k: usize) -> Vec<f64> {
    let value = |i: usize| ((i * (2 * k + 3) + 7 * k) as f64 * 0.618_033_988_7).fract() - 0.5;
    (0..count).map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_of_rank_two_comes_back_from_two_modes() {
        // Rows are combinations of (1 0 2 0) and (0 3 0 1).
        let row = |a: f64, b: f64| vec![a, 3.0 * b, 2.0 * a, b];
        let rows = [row(1.0, 0.0), row(2.0, -1.0), row(0.5, 4.0), row(0.0, 1.0)];
        let found = modes(&rows, 4);
        assert_eq!(found.len(), 2);
        assert!((dot(&found[0], &found[0]) - 1.0).abs() < 1e-12);
        assert!(dot(&found[0], &found[1]).abs() < 1e-12);
        for column in 0..4 {
            let values: Vec<f64> = rows.iter().map(|r| r[column]).collect();
            let mut left = values.clone();
            for mode in &found {
                let share = dot(mode, &values);
                left.iter_mut().zip(mode).for_each(|(l, m)| *l -= share * m);
            }
            assert!(dot(&left, &left) < 1e-18, "{left:?}");
        }
        assert!(modes(&[vec![0.0; 3], vec![0.0; 3]], 2).is_empty());
        assert!(modes(&[], 2).is_empty());
    }

    #[test]
    fn the_first_mode_is_the_strongest() {
        // Diagonal: singular values 5, 3 and 1 along the axes.
        let rows = [
            vec![3.0, 0.0, 0.0],
            vec![0.0, 1.0, 0.0],
            vec![0.0, 0.0, 5.0],
        ];
        let found = modes(&rows, 2);
        assert!((found[0][2].abs() - 1.0).abs() < 1e-6, "{found:?}");
        assert!((found[1][0].abs() - 1.0).abs() < 1e-6, "{found:?}");
    }
}
