//! Quantisation by whole numbers.

use articula_core::fap_table::TABLE;

/// Step of a low-level parameter, by its number; 0 for none.
pub(super) fn step(fap: usize, quantizer: u8) -> i64 {
    i64::from(TABLE[fap - 1].step) * i64::from(quantizer)
}

/// The nearest level; halves go to zero or away from it, as the reference encoder has them.
pub(super) fn level(value: i64, step: i64) -> i64 {
    if step == 0 {
        return value;
    }
    let half = step / 2;
    if value.abs() <= half {
        return 0;
    }
    value.signum() * ((value.abs() + half) / step)
}

/// The value of a level.
pub(super) fn value(level: i64, step: i64) -> i64 {
    level * step.max(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn halves() {
        // Half a step is 2: it is 0 as a first level, and rounds up from the second on.
        assert_eq!(
            [2, 3, 5, 6, -2, -3, -6].map(|v| level(v, 4)),
            [0, 1, 1, 2, 0, -1, -2]
        );
        assert_eq!([2, 3, 7, 8].map(|v| level(v, 5)), [0, 1, 1, 2]);
        assert_eq!((level(-7, 0), value(-7, 0)), (-7, -7));
    }

    proptest! {
        #[test]
        fn no_value_is_off_by_more_than_half_a_step(v in -400_000i64..400_000, step in 0i64..16_000) {
            prop_assert!(2 * (value(level(v, step), step) - v).abs() <= step);
        }
    }
}
