//! The values of all 68 facial animation parameters in one frame.

use articula_core::Mismatch;
use articula_core::fap_table::LOW_FAP_COUNT;

/// Fields of FAP 1, and the greatest value of each.
const VISEME: [u8; 4] = [14, 14, 63, 1];
/// Fields of FAP 2, and the greatest value of each.
const EXPRESSION: [u8; 6] = [6, 63, 6, 63, 1, 1];

/// Values of all facial animation parameters in one frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FaceFrame {
    /// FAP 1: both visemes, 0 to 14, the weight of the first in 63rds, and whether the low-level
    /// parameters define it, 0 or 1.
    pub viseme: [u8; 4],
    /// FAP 2: the first expression, 0 to 6, its intensity in 63rds, the same of the second, whether
    /// the low-level parameters first set the neutral face and whether they define it, 0 or 1.
    pub expression: [u8; 6],
    /// FAP 3 at index 0 up to FAP 68, each in its unit.
    pub low: [i32; LOW_FAP_COUNT],
}

impl FaceFrame {
    /// The neutral face.
    pub const NEUTRAL: Self = Self {
        viseme: [0; 4],
        expression: [0; 6],
        low: [0; LOW_FAP_COUNT],
    };

    /// Number of fields of a FAP, by its number.
    pub(crate) fn field_count(fap: usize) -> usize {
        match fap {
            1 => VISEME.len(),
            2 => EXPRESSION.len(),
            _ => 1,
        }
    }

    /// Value of a field of a FAP, by its number.
    pub(crate) fn field(&self, fap: usize, field: usize) -> i32 {
        match fap {
            1 => i32::from(self.viseme[field]),
            2 => i32::from(self.expression[field]),
            _ => self.low[fap - 3],
        }
    }

    /// Sets a field of a FAP, by its number, unless the value is out of the range of the field.
    pub(crate) fn set_field(&mut self, fap: usize, field: usize, value: i32) -> Option<()> {
        let (target, most) = match fap {
            1 => (&mut self.viseme[field], VISEME[field]),
            2 => (&mut self.expression[field], EXPRESSION[field]),
            _ => {
                self.low[fap - 3] = value;
                return Some(());
            }
        };
        *target = u8::try_from(value).ok().filter(|v| *v <= most)?;
        Some(())
    }

    /// Whether a FAP, by its number, is other than neutral.
    pub(crate) fn moves(&self, fap: usize) -> bool {
        (0..Self::field_count(fap)).any(|field| self.field(fap, field) != 0)
    }
}

/// Checks that the fields of FAP 1 and 2 are in their ranges; an error names the first frame where
/// one is not.
pub(crate) fn check_frames<'a>(
    frames: impl Iterator<Item = &'a FaceFrame>,
) -> Result<(), Mismatch> {
    for (f, frame) in frames.enumerate() {
        let viseme = frame.viseme.iter().zip(VISEME);
        let expression = frame.expression.iter().zip(EXPRESSION);
        if let Some((found, most)) = viseme.chain(expression).find(|(v, most)| *v > most) {
            let what = format!("a field of FAP 1 or 2 is {found}, at most {most} is allowed");
            return Err(Mismatch::new(format!("frames[{f}]"), what));
        }
    }
    Ok(())
}
