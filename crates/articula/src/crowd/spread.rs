//! Median and 95th percentile of what is measured in every frame.

use articula_core::percentile;
use serde::Serialize;

/// Median and 95th percentile of a set of values.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Spread {
    /// Median.
    pub median: f64,
    /// 95th percentile.
    pub p95: f64,
}

impl Spread {
    /// Of values in any order; zeros if there are none.
    pub(super) fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.into_iter().collect();
        Self {
            median: percentile(&mut values, 0.5),
            p95: percentile(&mut values, 0.95),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_by_hand() {
        // docs/metrics.md: of 0, 1, 2, 3 and 8 the 95th lies at 0.95 * 4 = 3.8.
        let spread = Spread::of([3.0, 8.0, 0.0, 2.0, 1.0]);
        assert!((spread.median - 2.0).abs() < 1e-12);
        assert!((spread.p95 - 7.0).abs() < 1e-12);
        assert_eq!(Spread::of([]), Spread::default());
        assert_eq!(Spread::of([4.0]).p95, 4.0);
    }
}
