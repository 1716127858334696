//! Values of the low-level FAPs.

use articula_core::arkit_table::outer_lip;
use articula_core::fap_table::{LOW_FAP_COUNT, LOW_FAPS};

/// Numbers and values of some FAPs.
pub(super) type FapList = &'static [(u8, i32)];

/// A value for each low-level FAP, 3 to 68, in its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FapValues(pub [f32; LOW_FAP_COUNT]);

impl Default for FapValues {
    fn default() -> Self {
        Self([0.0; LOW_FAP_COUNT])
    }
}

impl FapValues {
    /// Returns the value of a FAP; 0 for numbers other than 3 to 68.
    pub fn get(&self, fap: usize) -> f32 {
        let index = fap.checked_sub(*LOW_FAPS.start());
        index.and_then(|i| self.0.get(i)).copied().unwrap_or(0.0)
    }

    /// Returns the values where one FAP, by its number, has a value and all others are 0.
    ///
    /// # Panics
    /// If the number is not 3 to 68.
    pub fn alone(fap: usize, value: f32) -> Self {
        let mut values = Self::default();
        values.set(fap, value);
        values
    }

    /// Sets the value of a FAP, by its number.
    ///
    /// # Panics
    /// If the number is not 3 to 68.
    pub fn set(&mut self, fap: usize, value: f32) {
        self.0[fap - LOW_FAPS.start()] = value;
    }

    /// Adds values, and those of the inner lips to the outer lips too.
    pub(super) fn add(&mut self, list: FapList, weight: f32) {
        let first = *LOW_FAPS.start();
        for &(fap, value) in list {
            let fap = usize::from(fap);
            for fap in [Some(fap), outer_lip(fap)].into_iter().flatten() {
                self.0[fap - first] += weight * value as f32;
            }
        }
    }

    /// Returns the sum of both, the second with a weight.
    pub(super) fn plus(mut self, other: &Self, weight: f32) -> Self {
        let sum = self.0.iter_mut().zip(&other.0);
        sum.for_each(|(a, b)| *a += weight * b);
        self
    }
}
