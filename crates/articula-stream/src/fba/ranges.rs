//! Ranges of the levels: bounds of low-level parameters in sixties, of the table or of the stream,
//! divided by the quantiser of the plane that brings them; a later quantiser does not change them.

use articula_core::fap_table::{LOW_FAP_COUNT, TABLE};

/// Levels per count of a bound, at quantiser 1.
pub(super) const UNIT: i64 = 60;
/// Greatest blend and intensity.
pub(super) const HIGH_MOST: i64 = 63;
/// Greatest count, five bits.
pub(super) const MOST: u8 = 31;

/// Bounds of the low-level parameters, in sixties: greatest and least levels of intra frames, then
/// of predicted ones; the least as magnitudes.
pub(super) type Bounds = [[u8; LOW_FAP_COUNT]; 4];

/// Bounds as levels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Ranges {
    /// In the order of [`Bounds`].
    pub(super) levels: [[i64; LOW_FAP_COUNT]; 4],
    /// Greatest level of a blend and of an intensity.
    pub(super) high: i64,
}

/// The bounds of the table, rounded up to sixties.
pub(super) fn of_table() -> Bounds {
    let sixties = |largest: u16| largest.div_ceil(UNIT as u16) as u8;
    let intra = std::array::from_fn(|i| sixties(TABLE[i + 2].largest.0));
    let predicted = std::array::from_fn(|i| sixties(TABLE[i + 2].largest.1));
    [intra, intra, predicted, predicted]
}

/// Greatest level of a blend and of an intensity.
pub(super) fn high(quantizer: u8) -> i64 {
    let q = i64::from(quantizer.max(1));
    (HIGH_MOST + q / 2) / q
}

/// Greatest level that a count stands for.
pub(super) fn reach(count: u8, quantizer: u8) -> i64 {
    UNIT * i64::from(count) / i64::from(quantizer.max(1))
}

impl Ranges {
    /// Bounds that came with a quantiser.
    pub(super) fn new(bounds: &Bounds, quantizer: u8) -> Self {
        Self {
            levels: bounds.map(|list| list.map(|count| reach(count, quantizer))),
            high: high(quantizer),
        }
    }

    /// Least and greatest level of a parameter (index 0 is FAP 3).
    pub(super) fn of(&self, index: usize, is_intra: bool) -> (i64, i64) {
        let first = if is_intra { 0 } else { 2 };
        (-self.levels[first + 1][index], self.levels[first][index])
    }
}

/// Whether a marker bit comes before the bound of a parameter (index 0 is FAP 3): at every fourth
/// of a group, whether these are coded or not.
pub(super) fn has_marker(index: usize) -> bool {
    let group = |index: usize| TABLE[index + 2].group;
    let before = (0..index).rev().take_while(|i| group(*i) == group(index));
    before.count().is_multiple_of(4)
}

/// The least count that reaches a level.
pub(super) fn count_for(level: i64, quantizer: u8) -> Option<u8> {
    (0..=MOST).find(|count| reach(*count, quantizer) >= level)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_sixties() {
        // FAP 3: 1080 and 360; FAP 63: 680, rounded up, and 180.
        let ranges = |quantizer| Ranges::new(&of_table(), quantizer);
        assert_eq!(ranges(1).of(0, true), (-1080, 1080));
        assert_eq!(ranges(7).of(0, false), (-51, 51));
        assert_eq!(ranges(0).of(60, true), (-720, 720));
        assert_eq!([0, 1, 2, 5, 31].map(high), [63, 63, 32, 13, 2]);
        assert_eq!(count_for(1860, 1), Some(31));
        assert_eq!(count_for(1861, 1), None);
        assert_eq!(count_for(0, 5), Some(0));
        // 60 / 31 is 1.
        assert_eq!(count_for(1, 31), Some(1));
        assert_eq!(count_for(2, 31), Some(2));
    }

    #[test]
    fn runs_of_four_start_anew_in_each_group() {
        let marked: Vec<usize> = (0..66).filter(|i| has_marker(*i)).map(|i| i + 3).collect();
        let expected = [
            3, 7, 11, 15, 19, 23, 27, 31, 35, 39, 43, 47, 48, 51, 55, 59, 61, 65,
        ];
        assert_eq!(marked, expected);
    }
}
