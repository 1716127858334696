//! Encoding of a clip: access units of up to 16 frames.

use super::access_unit::{self, CodedFap, Plane};
use super::head;
use crate::component::{Block, CodingType, FRAMES};
use crate::container;
use crate::face::{FaceClip, FaceFrame};
use articula_core::Mismatch;
use articula_core::face_levels::{FaceLevel, FaceLevels, FaceRegion};
use articula_core::fap_table::FAP_COUNT;

/// How a clip is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Afp1Options {
    /// Quantiser, 0 to 31: the step of a parameter is that of its row in the table of parameters
    /// times this, 0 counting as 1.
    pub quantizer: u8,
    /// Form of the values; without one the smaller is taken for each access unit. Only access units
    /// of 16 frames can have the transform.
    pub coding: Option<CodingType>,
    /// Finest level that is written of each region.
    pub levels: FaceLevels,
}

/// The steps of the table, the smaller form, all parameters.
impl Default for Afp1Options {
    fn default() -> Self {
        Self {
            quantizer: 1,
            coding: None,
            levels: FaceLevels::all(FaceLevel::High),
        }
    }
}

impl Afp1Options {
    /// Returns the step of a low-level parameter, by its number, in its unit; 1 for others.
    pub fn step(&self, fap: usize) -> f64 {
        match fap {
            3..=FAP_COUNT => access_unit::step(fap, self.quantizer),
            _ => 1.0,
        }
    }
}

/// Encodes a clip as a file.
///
/// Regions of the face that are neutral in all frames are left out. Of the others all parameters
/// that their level keeps are written, also those that do not move, so that a reader can tell the
/// level from them.
///
/// # Errors
/// A [`Mismatch`] if the quantiser is above 31, a field of FAP 1 or 2 is out of its range
/// ([`FaceClip::check`]), or a value is too great for the step.
pub fn write(clip: &FaceClip, options: &Afp1Options) -> Result<Vec<u8>, Mismatch> {
    if options.quantizer > 31 {
        let what = format!("{}, expected 0 to 31", options.quantizer);
        return Err(Mismatch::new("quantizer", what));
    }
    clip.check()?;
    let faps = faps(clip, &options.levels);
    let access_units = clip.frames.chunks(FRAMES);
    let access_units = access_units.map(|frames| access_unit(clip, frames, &faps, options));
    let access_units = access_units.collect::<Result<Vec<_>, Mismatch>>()?;
    let head = head::of_clip(clip);
    Ok(container::write(head::MAGIC, &head, &access_units))
}

/// The parameters that are written, rising: those that the levels keep, of regions that move.
fn faps(clip: &FaceClip, levels: &FaceLevels) -> Vec<usize> {
    let all = 1..=FAP_COUNT;
    let moves = |fap: usize| clip.frames.iter().any(|frame| frame.moves(fap));
    let moving: Vec<FaceRegion> = all
        .clone()
        .filter(|fap| moves(*fap))
        .filter_map(FaceRegion::of)
        .collect();
    let roles = levels.roles();
    all.filter(|fap| roles.keeps(*fap))
        .filter(|fap| FaceRegion::of(*fap).is_some_and(|region| moving.contains(&region)))
        .collect()
}

/// Writes an access unit in the form that was asked for, or the smaller one.
fn access_unit(
    clip: &FaceClip,
    frames: &[FaceFrame],
    faps: &[usize],
    options: &Afp1Options,
) -> Result<Vec<u8>, Mismatch> {
    let form = if frames.len() == FRAMES {
        options.coding
    } else {
        Some(CodingType::Predictive)
    };
    let mut best: Option<Vec<u8>> = None;
    for coding in [CodingType::Predictive, CodingType::Dct] {
        if form.is_some_and(|form| form != coding) {
            continue;
        }
        let plane = Plane {
            rate: clip.rate,
            frames: frames.len(),
            quantizer: options.quantizer,
            coding,
        };
        let coded = faps.iter().map(|fap| coded(frames, *fap, &plane));
        let coded = coded.collect::<Result<Vec<_>, Mismatch>>()?;
        let bytes = access_unit::write(&plane, &coded);
        if best.as_ref().is_none_or(|best| bytes.len() < best.len()) {
            best = Some(bytes);
        }
    }
    Ok(best.unwrap_or_default())
}

fn coded(frames: &[FaceFrame], fap: usize, plane: &Plane) -> Result<CodedFap, Mismatch> {
    let step = access_unit::step(fap, plane.quantizer);
    let form = access_unit::coding_of(fap, plane.coding);
    let block = |field: usize| {
        let values: Vec<f64> = frames
            .iter()
            .map(|frame| f64::from(frame.field(fap, field)))
            .collect();
        Block::of(&values, step, form).ok_or_else(|| {
            let what = format!("a value beyond 2^30 steps of {step}");
            Mismatch::new(format!("FAP {fap}"), what)
        })
    };
    let blocks = (0..FaceFrame::field_count(fap)).map(block);
    Ok(CodedFap {
        fap,
        blocks: blocks.collect::<Result<_, _>>()?,
    })
}
