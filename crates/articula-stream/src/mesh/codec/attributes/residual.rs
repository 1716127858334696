//! Differences from a prediction, each coded in several contexts at once.

use super::super::mixing::{MixedNatural, Weights, decide};
use crate::range_coder::{Bit, Coder};

/// Number of contexts of a difference.
pub(super) const CONTEXTS: usize = 4;

/// Model of signed numbers in several contexts.
#[derive(Debug)]
pub(super) struct Residuals {
    magnitude: MixedNatural<CONTEXTS>,
    signs: [Vec<Bit>; 2],
    sign_weights: Weights<2>,
}

impl Residuals {
    /// Creates models for the given number of contexts of each kind and of signs.
    pub(super) fn new(contexts: [usize; CONTEXTS], signs: usize) -> Self {
        Self {
            magnitude: MixedNatural::new(contexts),
            signs: [
                vec![Bit::default(); signs],
                vec![Bit::default(); contexts[2]],
            ],
            sign_weights: Weights::default(),
        }
    }

    /// Codes a number between -2^30 and 2^30; a decoder returns the decoded value.
    pub(super) fn code(
        &mut self,
        coder: &mut impl Coder,
        at: [usize; CONTEXTS],
        sign: usize,
        value: i32,
    ) -> i32 {
        let given = value.unsigned_abs().min(1 << 30);
        let magnitude = self.magnitude.code(coder, at, given).min(1 << 30) as i32;
        if magnitude == 0 {
            return 0;
        }
        let [first, second] = &mut self.signs;
        let models = [&mut first[sign], &mut second[at[2]]];
        let is_negative = decide(coder, models, &mut self.sign_weights, value < 0);
        if is_negative { -magnitude } else { magnitude }
    }
}

/// Number of classes of [`class_of`].
pub(super) const SIZES: usize = 20;

/// Size of a number in half octaves: 0, 1, 2, 3, 4-5, 6-7, 8-11 ..
pub(super) fn class_of(x: u32) -> usize {
    let bits = 32 - x.leading_zeros();
    let class = match bits {
        0 | 1 => x,
        _ => 2 * bits - 2 + (x >> (bits - 2) & 1),
    };
    (class as usize).min(SIZES - 1)
}

/// The sign of a number as a context.
pub(super) fn sign_of(x: i32) -> usize {
    (x.signum() + 1) as usize
}

/// Prediction error of each coded element.
#[derive(Debug)]
pub(super) struct Misses {
    from: usize,
    sizes: Vec<u32>,
}

/// Number of contexts of [`Misses::near`].
pub(super) const NEAR: usize = SIZES * 3;

impl Misses {
    /// Creates errors for the elements from `from` to `count`; those below `from` are known without
    /// prediction.
    pub(super) fn new(from: usize, count: usize) -> Self {
        Self {
            from,
            sizes: vec![0; count - from],
        }
    }

    /// Stores the error of an element, summed over its values.
    pub(super) fn note(&mut self, v: u32, missed: &[i32]) {
        let sum = |sum: u32, x: &i32| sum.saturating_add(x.unsigned_abs());
        self.sizes[v as usize - self.from] = missed.iter().fold(0, sum);
    }

    /// Copies the error of an element whose value is copied.
    pub(super) fn copy(&mut self, v: u32, from: u32) {
        let of = |v: u32| (v as usize).checked_sub(self.from);
        self.sizes[v as usize - self.from] = of(from).map_or(0, |i| self.sizes[i]);
    }

    /// Context from the mean error of neighbours and their number.
    pub(super) fn near(&self, neighbours: impl Iterator<Item = u32>) -> usize {
        let (mut sum, mut count) = (0u64, 0);
        for u in neighbours.filter(|u| *u as usize >= self.from) {
            sum += u64::from(self.sizes[u as usize - self.from]);
            count += 1;
        }
        let mean = (2 * sum).checked_div(count).unwrap_or(0);
        class_of(mean.min(1 << 30) as u32) + SIZES * count.min(2) as usize
    }
}

/// Number of contexts of [`both`].
pub(super) const BOTH: usize = SIZES / 2 * NEAR.div_ceil(2);

/// Combines a size and a context of [`Misses::near`], each at half resolution.
pub(super) fn both(size: usize, near: usize) -> usize {
    size / 2 * NEAR.div_ceil(2) + near / 2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_by_hand() {
        let found = [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 12, 15, 16, 23].map(class_of);
        assert_eq!(found, [0, 1, 2, 3, 4, 4, 5, 5, 6, 6, 7, 7, 8, 8]);
        assert_eq!([767, 768, u32::MAX].map(class_of), [18, 19, 19]);
        assert_eq!([-5, 0, 5].map(sign_of), [0, 1, 2]);
        let all = (0..SIZES).flat_map(|s| (0..NEAR).map(move |n| both(s, n)));
        assert_eq!(all.max(), Some(BOTH - 1));
    }

    #[test]
    fn errors_of_neighbours_by_hand() {
        let mut misses = Misses::new(2, 6);
        misses.note(2, &[3, -4]);
        misses.note(3, &[1, 0]);
        misses.copy(4, 2);
        misses.copy(5, 1);
        assert_eq!(misses.sizes, [7, 1, 7, 0]);
        let near = |list: &[u32]| misses.near(list.iter().copied());
        // Twice the mean of those that are coded, and their number up to 2.
        assert_eq!(near(&[0, 1]), 0);
        assert_eq!(near(&[0, 3]), class_of(2) + SIZES);
        assert_eq!(near(&[2, 3]), class_of(8) + 2 * SIZES);
        assert_eq!(near(&[2, 3, 4]), class_of(10) + 2 * SIZES);
    }
}
