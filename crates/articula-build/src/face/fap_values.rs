//! Values of the low-level FAPs, and their length in millimetres.

use articula_core::arkit_table::outer_lip;
use articula_core::fap_table::{FapUnit, LOW_FAP_COUNT, LOW_FAPS, TABLE};

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

/// Returns the length of one unit of a FAP (3 to 68) on an average face, in millimetres.
///
/// Distances are those of the neutral head of ICT-FaceKit; angles count at 12 mm, the radius of an
/// eye.
pub fn unit_mm(fap: usize) -> f32 {
    let action = fap.checked_sub(1).and_then(|i| TABLE.get(i)?.action);
    let length = match action.map(|a| a.unit) {
        None => return 0.0,
        Some(FapUnit::Angle) => return 12.0e-5,
        Some(FapUnit::IrisDiameter) => 8.3,
        Some(FapUnit::EyeSeparation) => 62.3,
        Some(FapUnit::EyeNose) => 48.0,
        Some(FapUnit::MouthNose) => 21.2,
        Some(FapUnit::MouthWidth) => 50.7,
    };
    length / 1024.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_of_units() {
        // 1024 units of MNS are the distance between mouth and nose.
        assert!((1024.0 * unit_mm(3) - 21.2).abs() < 1e-4);
        // A quarter turn of an eye of 12 mm.
        let quarter = std::f32::consts::FRAC_PI_2 * 1e5;
        assert!((quarter * unit_mm(23) - 12.0 * std::f32::consts::FRAC_PI_2).abs() < 1e-3);
        assert_eq!([unit_mm(0), unit_mm(1), unit_mm(2), unit_mm(69)], [0.0; 4]);
    }
}
