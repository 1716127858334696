//! Encoding of a clip: access units of 16 coded frames.

use super::access_unit::{self, CodedBone, Plane};
use super::clip::{Abp1Clip, TrackKind};
use super::head::{self, BaseSteps};
use crate::component::{Block, CodingType, FRAMES};
use crate::container;
use articula_core::Mismatch;

/// How a clip is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Abp1Options {
    /// Quantiser, 1 to 31: the step of all values is 0.0001 (metres, radians, factors) times this.
    pub quantizer: u8,
    /// Power of two, 0 to 7, by which the step is further multiplied.
    pub power: u8,
    /// Form of the values; without one the smaller is taken for each access unit.
    pub coding: Option<CodingType>,
    /// Number of frames between two coded ones that are left out and interpolated by the reader, 0
    /// to 31.
    pub interpolated: u8,
}

/// Steps of 0.0001, the smaller form, every frame.
impl Default for Abp1Options {
    fn default() -> Self {
        Self {
            quantizer: 1,
            power: 0,
            coding: None,
            interpolated: 0,
        }
    }
}

impl Abp1Options {
    /// Returns the step of a kind.
    ///
    /// Predictive values are off by at most half of it; the squares of the 16 errors of a transform
    /// sum to at most those of 16 such errors.
    pub fn step(&self, kind: TrackKind) -> f64 {
        BaseSteps::OWN.of(kind) * f64::from(u32::from(self.quantizer) << self.power)
    }

    fn check(&self) -> Result<(), Mismatch> {
        let within = |name: &str, found: u8, least: u8, most: u8| {
            if (least..=most).contains(&found) {
                return Ok(());
            }
            let what = format!("{found}, expected {least} to {most}");
            Err(Mismatch::new(name, what))
        };
        within("quantizer", self.quantizer, 1, 31)?;
        within("power", self.power, 0, 7)?;
        within("interpolated", self.interpolated, 0, 31)
    }
}

/// Encodes a clip as a file.
///
/// # Errors
/// A [`Mismatch`] if an option is out of range, the clip contradicts itself ([`Abp1Clip::check`]),
/// has 2^32 frames, or a value is not finite or too great for the step.
pub fn write(clip: &Abp1Clip, options: &Abp1Options) -> Result<Vec<u8>, Mismatch> {
    options.check()?;
    clip.check()?;
    if u32::try_from(clip.frames).is_err() {
        return Err(Mismatch::new("frames", "more than 32 bits can count"));
    }
    let coded = Coded {
        clip,
        options,
        stride: usize::from(options.interpolated) + 1,
    };
    let count = coded.frames().div_ceil(FRAMES);
    let access_units = (0..count).map(|i| coded.access_unit(i));
    let access_units = access_units.collect::<Result<Vec<_>, Mismatch>>()?;
    Ok(container::write(
        head::MAGIC,
        &head::of_clip(clip),
        &access_units,
    ))
}

/// The coded frames of a clip.
struct Coded<'a> {
    clip: &'a Abp1Clip,
    options: &'a Abp1Options,
    /// Frames from one coded frame to the next.
    stride: usize,
}

impl Coded<'_> {
    /// Number of coded frames.
    fn frames(&self) -> usize {
        let frames = self.clip.frames;
        frames.div_ceil(self.stride) + usize::from(self.is_beyond())
    }

    /// Whether the last coded frame lies beyond the last frame.
    fn is_beyond(&self) -> bool {
        self.clip.frames > 0 && !(self.clip.frames - 1).is_multiple_of(self.stride)
    }

    /// Value of an axis in a coded frame. Beyond the last frame that value by which interpolation
    /// gives the last frame; then the same value, which fills the access unit.
    fn value(&self, track: &[[f32; 3]], axis: usize, coded: usize) -> f64 {
        let coded = coded.min(self.frames() - 1);
        let last = track.len() - 1;
        let frame = coded * self.stride;
        let at = |frame: usize| f64::from(track[frame][axis]);
        if frame <= last {
            return at(frame);
        }
        let before = frame - self.stride;
        let part = (last - before) as f64 / self.stride as f64;
        at(before) + (at(last) - at(before)) / part
    }

    /// Writes an access unit in the form that was asked for, or the smaller one.
    fn access_unit(&self, number: usize) -> Result<Vec<u8>, Mismatch> {
        let both = [CodingType::Predictive, CodingType::Dct];
        let forms = both
            .into_iter()
            .filter(|form| self.options.coding.is_none_or(|c| c == *form));
        let mut best: Option<Vec<u8>> = None;
        for form in forms {
            let bytes = self.in_form(number, form)?;
            if best.as_ref().is_none_or(|best| bytes.len() < best.len()) {
                best = Some(bytes);
            }
        }
        Ok(best.unwrap_or_default())
    }

    fn in_form(&self, number: usize, coding: CodingType) -> Result<Vec<u8>, Mismatch> {
        let mut bones = Vec::new();
        for (b, tracks) in self.clip.tracks.iter().enumerate() {
            if tracks.0.iter().all(Option::is_none) {
                continue;
            }
            let mut bone = CodedBone {
                id: b as u16,
                kinds: [None; TrackKind::ALL.len()],
                blocks: Vec::new(),
            };
            for (kind, track) in TrackKind::ALL.into_iter().zip(&tracks.0) {
                let Some(track) = track else { continue };
                let mut axes = [false; 3];
                for (axis, is_coded) in axes.iter_mut().enumerate() {
                    let block = self.block(kind, b, (track, axis), number, coding)?;
                    *is_coded = block.is_some();
                    bone.blocks.extend(block);
                }
                bone.kinds[kind as usize] = Some(axes);
            }
            bones.push(bone);
        }
        let plane = Plane {
            rate: self.clip.rate,
            interpolated: self.options.interpolated,
            quantizer: self.options.quantizer,
            power: self.options.power,
            coding,
        };
        Ok(access_unit::write(&plane, &bones))
    }

    /// The block of an axis of a track, or none if it is at rest.
    fn block(
        &self,
        kind: TrackKind,
        bone: usize,
        (track, axis): (&[[f32; 3]], usize),
        number: usize,
        coding: CodingType,
    ) -> Result<Option<Block>, Mismatch> {
        let step = self.options.step(kind);
        let values: [f64; FRAMES] =
            std::array::from_fn(|i| self.value(track, axis, number * FRAMES + i));
        let always = kind == TrackKind::ScaleOrientation;
        let rest = f64::from(kind.rest(&self.clip.bones[bone])[axis]);
        if !always && values.iter().all(|v| (v - rest).abs() <= step / 2.0) {
            return Ok(None);
        }
        let block = Block::of(&values, step, coding);
        block.map(Some).ok_or_else(|| {
            let at = format!("tracks[{bone}].{kind:?}");
            let what = format!("a value that is not finite, or beyond 2^30 steps of {step}");
            Mismatch::new(at, what)
        })
    }
}
