//! Percentiles, as used for every error and time statistic of this workspace.

use std::cmp::Ordering;
use std::ops::{Add, Mul, Sub};

/// A floating-point type of which percentiles can be computed: `f32` and `f64`.
pub trait Float: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    #[doc(hidden)]
    const ZERO: Self;
    #[doc(hidden)]
    fn order(a: &Self, b: &Self) -> Ordering;
    #[doc(hidden)]
    fn of(count: usize) -> Self;
    #[doc(hidden)]
    fn whole(self) -> usize;
}

macro_rules! real {
    ($($number:ty),*) => {$(
        impl Float for $number {
            const ZERO: Self = 0.0;

            fn order(a: &Self, b: &Self) -> Ordering {
                a.total_cmp(b)
            }

            fn of(count: usize) -> Self {
                count as Self
            }

            fn whole(self) -> usize {
                self as usize
            }
        }
    )*};
}

real!(f32, f64);

/// Returns the value below which a fraction (0 to 1) of the values lies, by linear interpolation
/// between neighbours: the 95th percentile of 5 values is at position 0.95 * 4 = 3.8, four fifths
/// between the fourth and the fifth. 0 for an empty slice.
///
/// Reorders the slice. O(values); does not allocate. May return NaN if a neighbouring value is
/// infinite.
///
/// ```
/// use articula_core::percentile;
///
/// let mut metres = [4.0, 0.0, 3.0, 1.0, 2.0_f32];
/// assert_eq!(percentile(&mut metres, 0.5), 2.0);
/// assert!((percentile(&mut metres, 0.95) - 3.8).abs() < 1e-6);
/// ```
pub fn percentile<T: Float>(values: &mut [T], fraction: T) -> T {
    if values.is_empty() {
        return T::ZERO;
    }
    let at = fraction * T::of(values.len() - 1);
    // With millions of values the position may be rounded up past the last one.
    let below = at.whole().min(values.len() - 1);
    let (_, low, rest) = values.select_nth_unstable_by(below, T::order);
    let low = *low;
    let high = rest.iter().copied().min_by(T::order).unwrap_or(low);
    low + (high - low) * (at - T::of(below))
}

/// Returns the percentile without interpolation, always one of the values: the smallest with at
/// least that fraction of the other values at or below it. 0 for an empty slice.
///
/// Reorders the slice. O(values); does not allocate.
pub fn percentile_at_or_above(values: &mut [f64], fraction: f64) -> f64 {
    let at = (fraction * values.len().saturating_sub(1) as f64).ceil() as usize;
    if at >= values.len() {
        return 0.0;
    }
    *values.select_nth_unstable_by(at, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_by_hand() {
        let of = |fraction| percentile(&mut [4.0, 0.0, 3.0, 1.0, 2.0_f32], fraction);
        assert_eq!([0.0, 0.5, 1.0].map(of), [0.0, 2.0, 4.0]);
        assert!((of(0.95) - 3.8).abs() < 1e-6, "between the last two");
        assert_eq!(percentile(&mut [7.0_f32], 0.95), 7.0);
        assert_eq!(percentile::<f32>(&mut [], 0.5), 0.0);
        // docs/metrics.md: of 0, 1, 2, 3 and 8 the 95th is at position 0.95 * 4 = 3.8.
        let p95 = percentile(&mut [3.0, 8.0, 0.0, 2.0, 1.0_f64], 0.95);
        assert!((p95 - 7.0).abs() < 1e-12);
    }

    #[test]
    fn at_or_above_is_one_of_the_values() {
        let mut values: Vec<f64> = (0..=100).rev().map(f64::from).collect();
        assert_eq!(percentile_at_or_above(&mut values, 0.95), 95.0);
        assert_eq!(percentile_at_or_above(&mut [3.0, 1.0, 2.0], 0.5), 2.0);
        assert_eq!(
            percentile_at_or_above(&mut [3.0, 8.0, 0.0, 2.0, 1.0], 0.8),
            8.0
        );
        assert_eq!(percentile_at_or_above(&mut [], 0.95), 0.0);
    }
}
