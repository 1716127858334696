//! Seeded random numbers, the same on all platforms.

use std::f32::consts::TAU;

/// State of SplitMix64 (Steele, Lea and Flood 2014); the seed is its initial value.
pub(super) struct Random(pub(super) u64);

impl Random {
    /// A uniform number in [0, 1).
    pub(super) fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u32 << 24) as f32
    }

    /// A uniform whole number from `low` to `high`.
    pub(super) fn within(&mut self, low: usize, high: usize) -> usize {
        low + (self.unit() * (high - low + 1) as f32) as usize
    }

    /// One of a list that is not empty.
    pub(super) fn one<'a, T>(&mut self, list: &'a [T]) -> &'a T {
        &list[self.within(0, list.len() - 1)]
    }

    /// A number of mean 0 and deviation 1, by Box and Muller.
    pub(super) fn normal(&mut self) -> f32 {
        let (a, b) = (self.unit(), self.unit());
        (-2.0 * (1.0 - a).ln()).sqrt() * (TAU * b).cos()
    }
}
