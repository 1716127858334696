//! The fade between levels: a parameter that gets its value from elsewhere than before goes there
//! gradually.
//!
//! Form: `docs/formats/afp1.md`, part 5.

use articula_core::face_levels::{FapRole, FapRoles};
use articula_core::fap_table::{LOW_FAP_COUNT, LOW_FAPS};

/// Where the value of each low-level parameter comes from: the number of a parameter, if there is
/// one with a value of its own.
type Sources = [Option<u8>; LOW_FAP_COUNT];

/// State of the fade.
pub(crate) struct Fade {
    /// Number of frames of a fade.
    frames: usize,
    sources: Option<Sources>,
    /// Values shown last.
    shown: [i32; LOW_FAP_COUNT],
    /// For each parameter the value from which it fades, and the number of frames since.
    from: [Option<(i32, usize)>; LOW_FAP_COUNT],
}

impl Fade {
    pub(crate) fn new(frames: usize) -> Self {
        Self {
            frames,
            sources: None,
            shown: [0; LOW_FAP_COUNT],
            from: [None; LOW_FAP_COUNT],
        }
    }

    /// Begins an access unit, in which the parameters have some roles and those of `is_there` (index
    /// 0 is FAP 1) have values.
    pub(crate) fn access_unit(&mut self, roles: &FapRoles, is_there: &[bool]) {
        let first = *LOW_FAPS.start();
        let source = |index: usize| {
            let source = match roles.role(first + index) {
                FapRole::Own => (first + index) as u8,
                FapRole::Copied(leader) => leader,
                FapRole::Removed => return None,
            };
            is_there[usize::from(source) - 1].then_some(source)
        };
        let sources: Sources = std::array::from_fn(source);
        if let Some(before) = self.sources.replace(sources) {
            for index in 0..LOW_FAP_COUNT {
                if before[index] != sources[index] {
                    self.from[index] = Some((self.shown[index], 0));
                }
            }
        }
    }

    /// Applies the fade to the values of a frame.
    pub(crate) fn frame(&mut self, values: &mut [i32; LOW_FAP_COUNT]) {
        let whole = self.frames as i64 + 1;
        for (value, from) in values.iter_mut().zip(&mut self.from) {
            if let Some((start, passed)) = from.filter(|(_, passed)| *passed < self.frames) {
                let part = passed as i64 + 1;
                let (start, end) = (i64::from(start), i64::from(*value));
                // To the nearest whole number, away from zero.
                let sum = start * (whole - part) + end * part;
                *value = ((2 * sum + sum.signum() * whole) / (2 * whole)) as i32;
                *from = Some((start as i32, passed + 1));
            }
        }
        self.shown = *values;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::face_levels::{FaceLevel, FaceLevels};

    #[test]
    fn only_what_changes_its_source_fades() {
        let roles = |level| FaceLevels::all(level).roles();
        let mut fade = Fade::new(3);
        let there = [true; 68];
        // FAP 19 and 20, upper lids: at very low both have the value of 20.
        let mut show = |level, left, right| {
            fade.access_unit(&roles(level), &there);
            [0; 5].map(|_| {
                let mut values = [0; LOW_FAP_COUNT];
                (values[16], values[17]) = (left, right);
                fade.frame(&mut values);
                (values[16], values[17])
            })
        };
        assert_eq!(show(FaceLevel::High, 100, 0), [(100, 0); 5]);
        let coarse = [(75, 8), (50, 8), (25, 8), (0, 8), (0, 8)];
        assert_eq!(show(FaceLevel::VeryLow, 0, 8), coarse);
        assert_eq!(show(FaceLevel::VeryLow, -9, 8), [(-9, 8); 5]);
        let fine = [(-7, 8), (-5, 8), (-2, 8), (0, 8), (0, 8)];
        assert_eq!(show(FaceLevel::High, 0, 8), fine);
    }
}
