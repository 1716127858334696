//! Pose units: for each track of a group whether it moves, its reference value, its step, and the
//! planes that each tier drops.
//!
//! Form: `docs/formats/abp2.md`, part 3.

use super::contexts::{Contexts, MOST, flag};
use super::step::MOST_CODE;
use crate::range_coder::{Coder, Decoder, Encoder};

/// Most tiers of a stream.
pub(super) const MOST_TIERS: usize = 8;
/// Most planes that a tier drops.
pub(super) const MOST_PLANES: u8 = 12;
/// Reference values of moving tracks are multiples of 1/64.
pub(super) const REFERENCE: f64 = 64.0;
/// Greatest exponent of a translation's unit, either way.
pub(super) const MOST_EXPONENT: i32 = 40;
/// The step code that the first track differs from.
const FIRST_CODE: i32 = 64;

/// The property of a track.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Kind {
    Rotation,
    Translation,
    Scale,
    Morph,
}

impl Kind {
    /// Number of values at a time.
    pub(super) fn axes(self) -> usize {
        if self == Self::Morph { 1 } else { 3 }
    }

    /// Flags that tell whether a track moves, and whether it is constant.
    fn flags(self) -> [usize; 2] {
        match self {
            Self::Rotation => [3, 5],
            Self::Translation | Self::Morph => [2, 4],
            Self::Scale => [6, 7],
        }
    }

    fn bucket(self) -> usize {
        if self == Self::Rotation { 8 } else { 9 }
    }
}

/// How a track is coded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum TrackForm {
    /// The rest value.
    #[default]
    Rest,
    /// `numbers` times the step of `code`.
    Constant {
        code: i32,
        exponent: i32,
        numbers: [i32; 3],
    },
    /// Levels in the access units, around `numbers` / 64.
    Moving {
        code: i32,
        /// A translation counts 2^-exponent of the joint's unit, about a metre; 0 for other tracks.
        exponent: i32,
        numbers: [i32; 3],
        /// Planes dropped at each tier; 0 at tier 0, not falling.
        planes: [u8; MOST_TIERS],
    },
}

/// Codes the forms of the tracks of a group. A decoder that meets a number out of range returns
/// what is wrong.
fn code(
    coder: &mut impl Coder,
    tiers: usize,
    kinds: &[Kind],
    forms: &mut [TrackForm],
) -> Result<(), String> {
    let mut contexts = Contexts::untrained();
    let mut before = FIRST_CODE;
    let mut exponent_before = 0;
    for (kind, form) in kinds.iter().zip(forms) {
        let [moves, is_constant] = kind.flags();
        let none = [0; MOST_TIERS];
        let (is_moving, given_code, mut exponent, mut numbers, mut planes) = match *form {
            TrackForm::Rest => (false, 0, 0, [0; 3], none),
            TrackForm::Constant {
                code,
                exponent,
                numbers,
            } => (false, code, exponent, numbers, none),
            TrackForm::Moving {
                code,
                exponent,
                numbers,
                planes,
            } => (true, code, exponent, numbers, planes),
        };
        let is_moving = contexts.bit(coder, flag(moves), is_moving);
        let constant = *form != TrackForm::Rest;
        if !is_moving && !contexts.bit(coder, flag(is_constant), constant) {
            *form = TrackForm::Rest;
            continue;
        }
        let code = before + contexts.value(coder, 1, 12, given_code - before);
        if !(0..=MOST_CODE).contains(&code) {
            return Err(format!("step code {code}, expected 0 to {MOST_CODE}"));
        }
        before = code;
        if *kind == Kind::Translation {
            let change = contexts.value(coder, 1, 13, exponent - exponent_before);
            exponent = exponent_before + change;
            if exponent.abs() > MOST_EXPONENT {
                let what = format!("exponent {exponent}, expected up to {MOST_EXPONENT}");
                return Err(what);
            }
            exponent_before = exponent;
        }
        let class = usize::from(!is_moving);
        for number in numbers.iter_mut().take(kind.axes()) {
            *number = contexts.value(coder, class, kind.bucket(), *number);
        }
        if !is_moving {
            *form = TrackForm::Constant {
                code,
                exponent,
                numbers,
            };
            continue;
        }
        for tier in 1..tiers {
            let above = i32::from(planes[tier - 1]);
            let more = i32::from(planes[tier]) - above;
            let more = contexts.value(coder, 1, (14 + tier).min(19), more);
            let dropped = above.saturating_add(more);
            if more < 0 || dropped > i32::from(MOST_PLANES) {
                return Err(format!(
                    "{dropped} planes dropped at tier {tier} after {above}"
                ));
            }
            planes[tier] = dropped as u8;
        }
        *form = TrackForm::Moving {
            code,
            exponent,
            numbers,
            planes,
        };
    }
    Ok(())
}

/// Writes a pose unit.
///
/// The numbers must be within [`MOST`] and the codes in range: a form that cannot be coded is an
/// error of the encoder.
pub(super) fn write(tiers: usize, kinds: &[Kind], forms: &[TrackForm]) -> Vec<u8> {
    let mut coder = Encoder::new();
    let coded = code(&mut coder, tiers, kinds, &mut forms.to_vec());
    debug_assert!(coded.is_ok() && forms.iter().all(can_code));
    coder.finish()
}

/// Returns whether all numbers of a form can be coded.
pub(super) fn can_code(form: &TrackForm) -> bool {
    match form {
        TrackForm::Rest => true,
        TrackForm::Constant { numbers, .. } | TrackForm::Moving { numbers, .. } => {
            numbers.iter().all(|n| n.unsigned_abs() <= MOST as u32)
        }
    }
}

/// Reads a pose unit with one track for each of `kinds`.
///
/// # Errors
/// What is wrong, without a place.
pub(super) fn read(bytes: &[u8], tiers: usize, kinds: &[Kind]) -> Result<Vec<TrackForm>, String> {
    let mut coder = Decoder::new(bytes);
    let mut forms = vec![TrackForm::Rest; kinds.len()];
    code(&mut coder, tiers, kinds, &mut forms)?;
    if coder.is_exhausted() {
        return Err("the pose unit ends too early".into());
    }
    Ok(forms)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn one_joint_by_hand() {
        let mut planes = [0; MOST_TIERS];
        planes[..5].copy_from_slice(&[0, 1, 2, 2, 2]);
        let numbers = [0; 3];
        let forms = [
            TrackForm::Moving {
                code: 80,
                exponent: 0,
                numbers,
                planes,
            },
            TrackForm::Rest,
        ];
        let kinds = [Kind::Rotation, Kind::Translation];
        let bytes = write(5, &kinds, &forms);
        assert_eq!(bytes, [0xf8, 0x45, 0xdc]);
        assert_eq!(read(&bytes, 5, &kinds), Ok(forms.to_vec()));
    }

    fn form() -> impl Strategy<Value = TrackForm> {
        let numbers = prop::array::uniform3(prop_oneof![-3..3, -MOST..=MOST]);
        let planes = prop::array::uniform8(0u8..3);
        let exponents = -MOST_EXPONENT..=MOST_EXPONENT;
        (0..=MOST_CODE, exponents, numbers, planes, 0..3).prop_map(
            |(code, exponent, numbers, rises, which)| {
                let mut planes = [0; MOST_TIERS];
                for tier in 1..MOST_TIERS {
                    planes[tier] = (planes[tier - 1] + rises[tier]).min(MOST_PLANES);
                }
                match which {
                    0 => TrackForm::Rest,
                    1 => TrackForm::Constant {
                        code,
                        exponent,
                        numbers,
                    },
                    _ => TrackForm::Moving {
                        code,
                        exponent,
                        numbers,
                        planes,
                    },
                }
            },
        )
    }

    proptest! {
        #[test]
        fn forms_come_back(forms in prop::collection::vec(form(), 0..20), tiers in 1usize..=8) {
            let kinds: Vec<Kind> = (0..forms.len()).map(|i| [Kind::Rotation, Kind::Translation, Kind::Scale][i % 3]).collect();
            let forms: Vec<TrackForm> = forms.into_iter().zip(&kinds).map(|(mut form, kind)| {
                if let TrackForm::Moving { exponent, .. } | TrackForm::Constant { exponent, .. } = &mut form
                    && *kind != Kind::Translation
                {
                    *exponent = 0;
                }
                if let TrackForm::Moving { planes, .. } = &mut form {
                    planes[tiers..].fill(0);
                }
                form
            }).collect();
            let bytes = write(tiers, &kinds, &forms);
            prop_assert_eq!(read(&bytes, tiers, &kinds), Ok(forms));
        }

        #[test]
        fn any_bytes_end(bytes in prop::collection::vec(any::<u8>(), 0..60), tiers in 1usize..=8) {
            let kinds = [Kind::Rotation, Kind::Translation, Kind::Scale, Kind::Morph];
            if let Ok(forms) = read(&bytes, tiers, &kinds) {
                prop_assert!(forms.iter().all(can_code));
            }
        }
    }
}
