//! A mean row and components quantised to integers.
//!
//! Source: `docs/methods/vector.md` 8.3; reverse water-filling (Cover and Thomas, *Elements of
//! Information Theory*, 10.3): with orthogonal components, one step for all of them has the least
//! error for the bits. Strong components therefore get large integers and weak ones small.

use super::{Component, LowRank};

/// Bound of the absolute value of all integers.
pub(crate) const MAX_STEPS: i32 = 1 << 26;
/// Significant bits of a component's scale.
const SCALE_BITS: i32 = 16;

/// A quantised matrix: row `i` is `step * mean + sum of scale * coefficients[i] * basis`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Quantised {
    /// Unit of the mean.
    pub step: f64,
    /// Mean of each column, steps.
    pub mean: Vec<i32>,
    /// The components, strongest first.
    pub components: Vec<QuantisedComponent>,
}

/// One quantised component.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct QuantisedComponent {
    /// Unit of the product of coefficient and basis.
    pub scale: f64,
    /// Contribution to each column.
    pub basis: Vec<i32>,
    /// Coefficient of each row.
    pub coefficients: Vec<i32>,
}

/// Quantisation steps of a matrix, in the unit of its values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Steps {
    /// Step of mean and bases, for coefficients with a mean square of one.
    pub basis: f64,
    /// Step of coefficients, for bases with a mean square of one.
    pub coefficients: f64,
}

impl Steps {
    /// Returns the steps that add a mean square error of `variance` to each value at the least cost
    /// for a matrix of this size: the larger factor is quantised more coarsely.
    pub(crate) fn of_variance(variance: f64, rank: usize, rows: usize, columns: usize) -> Self {
        let share = columns as f64 / rows.max(1) as f64;
        let rank = rank as f64;
        // A rounded number has a mean square error of step^2 / 12.
        let coefficients = (12.0 * variance / ((rank + 1.0) * share + rank)).sqrt();
        Self {
            basis: coefficients * share.sqrt(),
            coefficients,
        }
    }

    /// Returns both steps multiplied by a factor.
    pub(crate) fn times(self, factor: f64) -> Self {
        Self {
            basis: self.basis * factor,
            coefficients: self.coefficients * factor,
        }
    }
}

impl Quantised {
    /// Quantises the first `rank` components of a matrix; `None` if an integer exceeds
    /// [`MAX_STEPS`].
    pub(crate) fn new(low: &LowRank, rank: usize, steps: Steps) -> Option<Self> {
        let step = short(steps.basis)?;
        let components = low.components.iter().take(rank);
        Some(Self {
            step,
            mean: low
                .mean
                .iter()
                .map(|m| whole(m / step))
                .collect::<Option<_>>()?,
            components: components
                .map(|component| QuantisedComponent::new(component, step, steps.coefficients))
                .collect::<Option<_>>()?,
        })
    }

    /// Returns one row; linear between rows, clamped at the ends.
    pub(crate) fn row(&self, row: f64) -> Vec<f64> {
        let mut sum: Vec<f64> = self
            .mean
            .iter()
            .map(|m| f64::from(*m) * self.step)
            .collect();
        for component in &self.components {
            let amount = component.amount(row) * component.scale;
            for (s, b) in sum.iter_mut().zip(&component.basis) {
                *s += amount * f64::from(*b);
            }
        }
        sum
    }
}

impl QuantisedComponent {
    fn new(component: &Component, step: f64, coefficient_step: f64) -> Option<Self> {
        let (rows, columns) = (component.coefficients.len(), component.basis.len());
        // RMS of a coefficient, and of the component's contribution to a value.
        let size = (component.energy() / rows as f64).sqrt();
        let strength = size / (columns as f64).sqrt();
        let scale = short(step * coefficient_step / strength)?;
        let basis = |b: &f64| whole(b * size / step);
        let coefficient = |c: &f64| whole(c / size * step / scale);
        Some(Self {
            scale,
            basis: component.basis.iter().map(basis).collect::<Option<_>>()?,
            coefficients: component
                .coefficients
                .iter()
                .map(coefficient)
                .collect::<Option<_>>()?,
        })
    }

    /// Coefficient at a row, linear between rows.
    pub(crate) fn amount(&self, row: f64) -> f64 {
        let last = self.coefficients.len().saturating_sub(1);
        let row = row.clamp(0.0, last as f64);
        let from = row.floor() as usize;
        let of = |r: usize| self.coefficients.get(r).map_or(0.0, |c| f64::from(*c));
        let share = row - from as f64;
        of(from) * (1.0 - share) + of((from + 1).min(last)) * share
    }
}

fn whole(value: f64) -> Option<i32> {
    let rounded = value.round();
    (rounded.abs() < f64::from(MAX_STEPS)).then_some(rounded as i32)
}

/// Rounds to the nearest number of [`SCALE_BITS`] bits; `None` if it cannot be written as an
/// integer over a power of two up to 2^60.
pub(crate) fn short(value: f64) -> Option<f64> {
    if !(value > 0.0 && value < f64::from(1 << SCALE_BITS)) {
        return None;
    }
    let shift = (SCALE_BITS - 1 - value.log2().floor() as i32).clamp(0, 60);
    let unit = f64::from(shift).exp2();
    Some((value * unit).round() / unit).filter(|v| *v > 0.0)
}

#[cfg(test)]
mod tests {
    use super::super::{Table, decompose};
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn scales_are_short_and_near() {
        for value in [1.0, 0.1, 3.7e-9, 12345.678, 1.0 / 3.0] {
            let found = short(value).unwrap();
            assert!((found / value - 1.0).abs() <= 2f64.powi(-SCALE_BITS));
        }
        assert_eq!(short(0.5), Some(0.5));
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e9, 1e-30] {
            assert_eq!(short(bad), None, "{bad}");
        }
    }

    #[test]
    fn amounts_run_straight_between_rows_and_hold() {
        let component = QuantisedComponent {
            scale: 1.0,
            basis: vec![1],
            coefficients: vec![0, 10, 4],
        };
        for (row, wanted) in [
            (-1.0, 0.0),
            (0.25, 2.5),
            (1.0, 10.0),
            (1.5, 7.0),
            (9.0, 4.0),
        ] {
            assert_eq!(component.amount(row), wanted);
        }
    }

    #[test]
    fn what_is_out_of_range_is_refused() {
        let table = Table {
            columns: 1,
            values: vec![1e12, -1e12],
        };
        let low = decompose(&table, |_| true);
        let steps = Steps {
            basis: 0.01,
            coefficients: 0.01,
        };
        assert_eq!(Quantised::new(&low, 1, steps), None);
    }

    proptest! {
        #[test]
        fn rounding_adds_about_the_error_that_was_asked_for(
            values in prop::collection::vec(-50.0f64..50.0, 30 * 40),
            rank in 1usize..30,
            wanted in 0.01f64..1.0,
        ) {
            let table = Table { columns: 40, values };
            let low = decompose(&table, |_| false);
            let steps = Steps::of_variance(wanted * wanted, rank, 30, 40);
            let quantised = Quantised::new(&low, rank, steps).unwrap();
            let mut sum = 0.0;
            for r in 0..30 {
                let mut exact = low.mean.clone();
                for component in &low.components[..rank] {
                    for (e, b) in exact.iter_mut().zip(&component.basis) {
                        *e += b * component.coefficients[r];
                    }
                }
                let row = quantised.row(r as f64);
                sum += row.iter().zip(&exact).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
            }
            let found = (sum / 1200.0).sqrt();
            prop_assert!(found < 1.3 * wanted && found > 0.6 * wanted, "{found} for {wanted}");
        }
    }
}
