//! Dense systems of linear equations.

/// Solves `matrix · x = right` for several right-hand sides at once, by elimination with the
/// largest pivot of each column. `matrix` has n² values and `right` n · `sides`, both row by row;
/// `right` is replaced by the solution. `None` if the matrix is singular. O(n³ + n² · `sides`).
pub(super) fn solve(matrix: &mut [f64], right: &mut [f64], sides: usize) -> Option<()> {
    let n = right.len() / sides.max(1);
    assert_eq!(matrix.len(), n * n, "a square matrix");
    let scale = matrix.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    for column in 0..n {
        let size = |row: &usize| matrix[row * n + column].abs();
        let pivot = (column..n).max_by(|a, b| size(a).total_cmp(&size(b)))?;
        if size(&pivot) <= 1e-14 * scale {
            return None;
        }
        for k in 0..n {
            matrix.swap(column * n + k, pivot * n + k);
        }
        for k in 0..sides {
            right.swap(column * sides + k, pivot * sides + k);
        }
        for row in column + 1..n {
            let factor = matrix[row * n + column] / matrix[column * n + column];
            if factor == 0.0 {
                continue;
            }
            for k in column..n {
                matrix[row * n + k] -= factor * matrix[column * n + k];
            }
            for k in 0..sides {
                right[row * sides + k] -= factor * right[column * sides + k];
            }
        }
    }
    for row in (0..n).rev() {
        for k in 0..sides {
            let known: f64 = (row + 1..n)
                .map(|other| matrix[row * n + other] * right[other * sides + k])
                .sum();
            right[row * sides + k] = (right[row * sides + k] - known) / matrix[row * n + row];
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_system_whose_first_pivot_is_zero() {
        // y + z = 2, x + y + z = 4, x + 2 y - z = 3, and the same with twice the right-hand side.
        let mut matrix = [0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 2.0, -1.0];
        let mut right = [2.0, 4.0, 4.0, 8.0, 3.0, 6.0];
        solve(&mut matrix, &mut right, 2).unwrap();
        let expected = [2.0, 4.0, 1.0, 2.0, 1.0, 2.0];
        for (a, b) in right.iter().zip(expected) {
            assert!((a - b).abs() < 1e-12, "{right:?}");
        }
    }

    #[test]
    fn a_singular_system_has_no_solution() {
        assert_eq!(solve(&mut [1.0, 2.0, 2.0, 4.0], &mut [1.0, 2.0], 1), None);
    }
}
