//! Truncated singular value decomposition of a matrix with one row per frame: mean row and a few
//! components.
//!
//! Source: `docs/methods/vector.md` 8.3; Halko, Martinsson and Tropp, *Finding structure with
//! randomness* (SIAM Review 53, 2011), algorithm 4.4: subspace iteration. Differs: the start is a
//! fixed sequence, so the same matrix gives the same bits, and the block grows until the residual
//! is small enough, so no rank has to be guessed. A block as wide as the matrix is exact.

use super::jacobi::symmetric_eigen;
use super::orthonormal::{add_scaled, dot, orthonormalise};

/// Rounds of subspace iteration; each squares the ratio between kept and lost components.
const ROUNDS: usize = 8;
/// Number of components of the first block.
const FIRST_BLOCK: usize = 16;
/// A direction shorter than this fraction of its length before orthogonalisation is noise.
const NOISE: f64 = 1e-11;

/// A matrix of numbers, row by row, one row per frame.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Table {
    /// Numbers per row.
    pub columns: usize,
    /// `rows * columns` numbers.
    pub values: Vec<f64>,
}

/// One component of a matrix.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Component {
    /// Contribution to each column; of unit length, orthogonal to the other components' bases.
    pub basis: Vec<f64>,
    /// Coefficient of each row; orthogonal to the other components' coefficients.
    pub coefficients: Vec<f64>,
}

/// A matrix as its mean row and components, strongest first.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LowRank {
    /// Mean of each column.
    pub mean: Vec<f64>,
    /// The components.
    pub components: Vec<Component>,
}

impl Table {
    /// Number of rows.
    pub(crate) fn rows(&self) -> usize {
        self.values.len() / self.columns.max(1)
    }

    /// One row.
    pub(crate) fn row(&self, row: usize) -> &[f64] {
        &self.values[row * self.columns..(row + 1) * self.columns]
    }
}

impl Component {
    /// Square of the singular value.
    pub(crate) fn energy(&self) -> f64 {
        dot(&self.coefficients, &self.coefficients)
    }
}

/// Decomposes a matrix, with a growing number of components until `is_enough` returns true or there
/// are no more; the result may have more components than needed.
///
/// O(rows x columns x components).
pub(crate) fn decompose(table: &Table, mut is_enough: impl FnMut(&LowRank) -> bool) -> LowRank {
    let (mean, centred) = centre(table);
    let most = table.rows().min(table.columns);
    let mut block = FIRST_BLOCK.min(most);
    loop {
        let components = strongest(&centred, block);
        let known = LowRank {
            mean: mean.clone(),
            components,
        };
        // Fewer than requested: the rest of the matrix is rounding noise.
        if known.components.len() < block || block == most || is_enough(&known) {
            return known;
        }
        block = (2 * block).min(most);
    }
}

fn centre(table: &Table) -> (Vec<f64>, Table) {
    let mut mean = vec![0.0; table.columns];
    let rows = table.rows();
    for row in 0..rows {
        add_scaled(&mut mean, table.row(row), 1.0 / rows as f64);
    }
    let mut centred = table.clone();
    if table.columns > 0 {
        for row in centred.values.chunks_exact_mut(table.columns) {
            add_scaled(row, &mean, -1.0);
        }
    }
    (mean, centred)
}

/// The strongest components of a centred matrix.
fn strongest(centred: &Table, block: usize) -> Vec<Component> {
    let rows = centred.rows();
    let mut sequence = Sequence(0x9e37_79b9_7f4a_7c15);
    let mut heights: Vec<Vec<f64>> = (0..block)
        .map(|_| (0..rows).map(|_| sequence.next()).collect())
        .collect();
    let mut directions = Vec::new();
    for _ in 0..ROUNDS {
        directions = heights.iter().map(|h| across(centred, h)).collect();
        orthonormalise(&mut directions, |before, length| length <= before * NOISE);
        heights = directions.iter().map(|d| along(centred, d)).collect();
    }
    // Rayleigh-Ritz: rotates the block so that the coefficients are orthogonal too.
    let small: Vec<f64> = heights
        .iter()
        .flat_map(|a| heights.iter().map(move |b| dot(a, b)))
        .collect();
    symmetric_eigen(&small)
        .into_iter()
        .map(|pair| Component {
            basis: mix(&directions, &pair.vector, centred.columns),
            coefficients: mix(&heights, &pair.vector, rows),
        })
        .filter(|component| component.energy() > 0.0)
        .collect()
}

/// Sum of the rows, weighted by `heights`.
fn across(table: &Table, heights: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; table.columns];
    for (row, height) in heights.iter().enumerate() {
        add_scaled(&mut sum, table.row(row), *height);
    }
    sum
}

/// Coefficient of each row along a direction.
fn along(table: &Table, direction: &[f64]) -> Vec<f64> {
    (0..table.rows())
        .map(|row| dot(table.row(row), direction))
        .collect()
}

fn mix(vectors: &[Vec<f64>], weights: &[f64], length: usize) -> Vec<f64> {
    let mut sum = vec![0.0; length];
    for (vector, weight) in vectors.iter().zip(weights) {
        add_scaled(&mut sum, vector, *weight);
    }
    sum
}

/// Pseudorandom numbers between -1 and 1: splitmix64.
struct Sequence(u64);

impl Sequence {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ z >> 31) as f64 / u64::MAX as f64 * 2.0 - 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn rebuilt(low: &LowRank, row: usize, rank: usize) -> Vec<f64> {
        let mut sum = low.mean.clone();
        for component in &low.components[..rank.min(low.components.len())] {
            add_scaled(&mut sum, &component.basis, component.coefficients[row]);
        }
        sum
    }

    /// Mean (1, 2, 3, 4), 6 times (2, 1, 0, 2) / 3 and 3 times (1, -2, 2, 0) / 3 in orthogonal
    /// waves: two components with energies 4 x 36 / 2 and 4 x 9 / 2.
    fn two_components() -> Table {
        let waves = [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
        let mut values = Vec::new();
        for (a, b) in waves {
            let (a, b) = (a * 2.0, b);
            for (mean, (p, q)) in [
                (1.0, (2.0, 1.0)),
                (2.0, (1.0, -2.0)),
                (3.0, (0.0, 2.0)),
                (4.0, (2.0, 0.0)),
            ] {
                values.push(mean + a * p + b * q);
            }
        }
        Table { columns: 4, values }
    }

    #[test]
    fn a_table_made_of_two_components_is_found_exactly() {
        let table = two_components();
        let low = decompose(&table, |_| false);
        assert_eq!(low.components.len(), 2);
        for (mean, expected) in low.mean.iter().zip([1.0, 2.0, 3.0, 4.0]) {
            assert!((mean - expected).abs() < 1e-12);
        }
        // Four rows of (2 x 3)^2 and of (1 x 3)^2.
        assert!((low.components[0].energy() - 144.0).abs() < 1e-9);
        assert!((low.components[1].energy() - 36.0).abs() < 1e-9);
        for row in 0..4 {
            for (found, wanted) in rebuilt(&low, row, 2).iter().zip(table.row(row)) {
                assert!((found - wanted).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_still_or_empty_table_has_no_component() {
        let still = Table {
            columns: 3,
            values: vec![5.0, -1.0, 2.0, 5.0, -1.0, 2.0],
        };
        let low = decompose(&still, |_| false);
        assert_eq!((low.mean, low.components.len()), (vec![5.0, -1.0, 2.0], 0));
        let one = Table {
            columns: 2,
            values: vec![1.0, 2.0],
        };
        assert!(decompose(&one, |_| false).components.is_empty());
        let none = Table {
            columns: 0,
            values: vec![],
        };
        assert!(decompose(&none, |_| false).mean.is_empty());
    }

    proptest! {
        #[test]
        fn components_stand_at_right_angles_and_rebuild_the_table(
            values in prop::collection::vec(-100.0f64..100.0, 5 * 24),
            columns in prop::sample::select(vec![3usize, 5, 8, 24]),
        ) {
            let table = Table { columns, values };
            let low = decompose(&table, |_| false);
            for (i, a) in low.components.iter().enumerate() {
                for (j, b) in low.components.iter().enumerate() {
                    let wanted = if i == j { 1.0 } else { 0.0 };
                    prop_assert!((dot(&a.basis, &b.basis) - wanted).abs() < 1e-9);
                    let skew = dot(&a.coefficients, &b.coefficients);
                    prop_assert!(i == j || skew.abs() < 1e-6);
                }
                prop_assert!(i == 0 || a.energy() <= low.components[i - 1].energy() + 1e-9);
            }
            for row in 0..table.rows() {
                for (found, wanted) in rebuilt(&low, row, usize::MAX).iter().zip(table.row(row)) {
                    prop_assert!((found - wanted).abs() < 1e-7);
                }
            }
        }
    }

    #[test]
    fn a_block_that_is_narrower_than_the_table_finds_the_strongest() {
        // 40 components that each halve, over the orthogonal cosines of a discrete cosine
        // transform; 16 of them are requested.
        let (rows, columns) = (64usize, 80usize);
        let wave = |n: usize, k: usize, i: usize| {
            (std::f64::consts::PI * (i as f64 + 0.5) * k as f64 / n as f64).cos()
                * (2.0 / n as f64).sqrt()
        };
        let mut values = vec![0.0; rows * columns];
        for (i, value) in values.iter_mut().enumerate() {
            let (row, column) = (i / columns, i % columns);
            *value = (1..=40)
                .map(|k| {
                    0.5f64.powi(k) * wave(rows, k as usize, row) * wave(columns, k as usize, column)
                })
                .sum();
        }
        let low = decompose(&Table { columns, values }, |_| true);
        assert_eq!(low.components.len(), 16);
        for (k, component) in low.components.iter().take(12).enumerate() {
            let wanted = 0.5f64.powi(k as i32 + 1);
            let found = component.energy().sqrt();
            assert!((found / wanted - 1.0).abs() < 1e-6, "{found} for {wanted}");
        }
    }
}
