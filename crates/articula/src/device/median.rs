//! The median of few values, and what bounds the true one.

/// Probability that the true median is outside of an interval.
const DOUBT: f64 = 0.05;

/// Least number of values whose interval holds with that probability: all six of them are on one side of
/// the true median once in 32 times.
pub(super) const LEAST_VALUES: usize = 6;

/// A median with its confidence interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Median {
    pub(super) value: f64,
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Median {
    /// Of some values; `None` of none. The interval is made of two of them, by the binomial distribution
    /// of the number of values below the true median, whatever their distribution is. Of fewer than
    /// [`LEAST_VALUES`] it is from the least to the greatest.
    pub(super) fn of(values: &[f64]) -> Option<Self> {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let n = sorted.len();
        let middle = n / 2;
        let value = match n {
            0 => return None,
            n if n.is_multiple_of(2) => 0.5 * (sorted[middle - 1] + sorted[middle]),
            _ => sorted[middle],
        };
        let outer = outside(n);
        Some(Self {
            value,
            low: sorted[outer],
            high: sorted[n - 1 - outer],
        })
    }
}

/// How many values on each side may be left out of an interval that holds.
fn outside(n: usize) -> usize {
    // P(exactly k of n values are below the median), from k = 0 on.
    let mut probability = 0.5_f64.powi(n as i32);
    let mut sum = 0.0;
    for k in 0..n / 2 {
        sum += probability;
        if sum > 0.5 * DOUBT {
            return k.saturating_sub(1);
        }
        probability *= (n - k) as f64 / (k + 1) as f64;
    }
    0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_those_of_the_tables_of_the_sign_test() {
        // Published ranks of 95 % intervals of a median: 1 of 6, 2 of 9, 2 of 10, 3 of 12, 6 of 20.
        for (n, rank) in [(6, 1), (8, 1), (9, 2), (10, 2), (12, 3), (20, 6)] {
            assert_eq!(outside(n) + 1, rank, "{n}");
        }
        assert_eq!(Median::of(&[]), None);
        let of = |values: &[f64]| {
            Median::of(values)
                .map(|m| (m.low, m.value, m.high))
                .unwrap()
        };
        assert_eq!(of(&[3.0]), (3.0, 3.0, 3.0));
        assert_eq!(of(&[4.0, 1.0]), (1.0, 2.5, 4.0));
        assert_eq!(
            of(&[9.0, 1.0, 8.0, 2.0, 7.0, 3.0, 6.0, 4.0, 5.0]),
            (2.0, 5.0, 8.0)
        );
    }

    #[test]
    fn outliers_do_not_move_it() {
        let mut values = vec![1.0; 9];
        values[..3].fill(1e9);
        assert_eq!(Median::of(&values).map(|m| m.value), Some(1.0));
    }
}
