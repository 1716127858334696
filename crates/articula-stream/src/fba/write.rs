//! Encoding of a clip, in a closed loop: differences are to what a receiver shows.

use super::clip::FbaClip;
use super::coder::Encoder;
use super::header::{END, Face, PLANE, Plane, STREAM};
use super::quantise;
use super::ranges::{self, Bounds, Ranges};
use super::read::MOST_NUMBER;
use super::slot::{Models, Slot, slots};
use crate::bits::BitWriter;
use crate::face::{FaceFrame, check_frames};
use articula_core::Mismatch;
use articula_core::fap_table::{FAP_COUNT, LOW_FAP_COUNT, LOW_FAPS};

/// How a clip is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FbaOptions {
    /// Quantiser, 0 to 31: the step of a parameter is that of its row in the table of parameters
    /// times this; 0 quantises nothing, but then only values up to 1860 can be written. If FAP 1 or 2
    /// is coded, 1 is the greatest that is used.
    pub quant: u8,
    /// Frames from one intra frame to the next; without one a second, rounded.
    pub intra_every: Option<u32>,
}

/// The steps of the table, an intra frame each second.
impl Default for FbaOptions {
    fn default() -> Self {
        Self {
            quant: 1,
            intra_every: None,
        }
    }
}

/// Levels of all coded numbers of a frame.
struct Levels {
    is_intra: bool,
    levels: Vec<i64>,
}

/// Encodes a clip.
///
/// A frame that no difference reaches becomes an intra frame. The ranges of the levels are those of
/// the clip, or the defaults if these are enough and the stream is then smaller.
///
/// # Errors
/// A [`Mismatch`] if an option or a field of FAP 1 or 2 is out of its range, numbers of frames do not
/// rise from 0 or are above 2^20, or a value is above 1860 steps of the table.
pub fn write(clip: &FbaClip, options: &FbaOptions) -> Result<Vec<u8>, Mismatch> {
    check(clip, options)?;
    let is_high = clip.coded[0] || clip.coded[1];
    let face = Face {
        quantizer: if is_high {
            options.quant.min(1)
        } else {
            options.quant
        },
        mask: clip.coded,
    };
    let second = clip.rate.hz().round().max(1.0) as u32;
    let every = options.intra_every.unwrap_or(second) as usize;
    let (frames, bounds) = plan(clip, &face, every)?;
    let own = stream(clip, &face, &frames, Some(&bounds));
    let default = ranges::of_table();
    let mut pairs = bounds.iter().flatten().zip(default.iter().flatten());
    if pairs.all(|(own, default)| own <= default) {
        let plain = stream(clip, &face, &frames, None);
        if plain.len() <= own.len() {
            return Ok(plain);
        }
    }
    Ok(own)
}

fn check(clip: &FbaClip, options: &FbaOptions) -> Result<(), Mismatch> {
    if options.quant > 31 {
        let what = format!("{}, expected 0 to 31", options.quant);
        return Err(Mismatch::new("quant", what));
    }
    if options.intra_every == Some(0) {
        return Err(Mismatch::new("intra_every", "0, expected 1 or more"));
    }
    if clip.time_code.is_some_and(|time| !time.is_valid()) {
        return Err(Mismatch::new("time_code", "not a time of a day"));
    }
    let mut next = 0;
    for (f, frame) in clip.frames.iter().enumerate() {
        // A stream begins at frame 0.
        let most = if f == 0 { 0 } else { MOST_NUMBER };
        if frame.number < next || frame.number > most {
            let what = format!("number {}, expected {next} to {most}", frame.number);
            return Err(Mismatch::new(format!("frames[{f}]"), what));
        }
        next = frame.number + 1;
    }
    check_frames(clip.frames.iter().map(|frame| &frame.face))
}

/// The coded numbers of a frame, in their order.
fn coded(face: &Face) -> Vec<Slot> {
    let faps = (1..=FAP_COUNT).filter(|fap| face.mask[fap - 1]);
    faps.flat_map(slots).collect()
}

/// Chooses the levels of all frames, and the least ranges that have them.
fn plan(clip: &FbaClip, face: &Face, every: usize) -> Result<(Vec<Levels>, Bounds), Mismatch> {
    let slots = coded(face);
    let mut bounds: Bounds = [[0; LOW_FAP_COUNT]; 4];
    // Known decoders take bounds of 0 here for ranges that were never sent, and return to the table
    // at the next intra frame.
    bounds[0][4 - LOW_FAPS.start()] = 1;
    let mut shown = FaceFrame::NEUTRAL;
    let mut since = 0;
    let mut planned = Vec::with_capacity(clip.frames.len());
    for (index, frame) in clip.frames.iter().enumerate() {
        let levels_of = |is_intra: bool| {
            let level = |slot: &Slot| {
                let of = |f: &FaceFrame| i64::from(f.field(slot.fap, slot.field));
                let before = if is_intra { 0 } else { of(&shown) };
                quantise::level(of(&frame.face) - before, slot.step(face.quantizer))
            };
            slots.iter().map(level).collect::<Vec<i64>>()
        };
        let beyond = |levels: &[i64]| {
            let mut pairs = slots.iter().zip(levels);
            let is_beyond = |(slot, level): &(&Slot, &i64)| {
                slot.fap > 2 && ranges::count_for(level.abs(), face.quantizer).is_none()
            };
            pairs.find(is_beyond).map(|(slot, _)| *slot)
        };
        let mut is_intra = planned.is_empty() || since >= every;
        let mut levels = levels_of(is_intra);
        if !is_intra && beyond(&levels).is_some() {
            is_intra = true;
            levels = levels_of(true);
        }
        if let Some(slot) = beyond(&levels) {
            let value = frame.face.field(slot.fap, slot.field);
            let what = format!("a value of {value}, more than 1860 steps of the table");
            return Err(Mismatch::new(
                format!("frames[{index}], FAP {}", slot.fap),
                what,
            ));
        }
        for (slot, level) in slots.iter().zip(&levels) {
            let mut value = quantise::value(*level, slot.step(face.quantizer));
            if !is_intra {
                value += i64::from(shown.field(slot.fap, slot.field));
            }
            shown.set_field(slot.fap, slot.field, value as i32);
            if slot.fap > 2 {
                let list = 2 * usize::from(!is_intra) + usize::from(*level < 0);
                let bound = &mut bounds[list][slot.fap - 3];
                let count = ranges::count_for(level.abs(), face.quantizer);
                *bound = (*bound).max(count.unwrap_or(ranges::MOST));
            }
        }
        since = if is_intra { 1 } else { since + 1 };
        planned.push(Levels { is_intra, levels });
    }
    Ok((planned, bounds))
}

/// Writes the stream, with new ranges in the first frame or with the defaults.
fn stream(clip: &FbaClip, face: &Face, planned: &[Levels], own: Option<&Bounds>) -> Vec<u8> {
    let mut out = BitWriter::default();
    out.push(32, u64::from(STREAM[0]));
    let ranges = Ranges::new(own.unwrap_or(&ranges::of_table()), face.quantizer);
    let slots = coded(face);
    let mut models = Models::new();
    for (index, (frame, levels)) in clip.frames.iter().zip(planned).enumerate() {
        let is_first = index == 0;
        if levels.is_intra {
            stuff(&mut out);
            out.push(32, u64::from(PLANE[0]));
            models = Models::new();
        }
        let next = clip.frames.get(index + 1);
        let plane = Plane {
            is_intra: levels.is_intra,
            rate: is_first.then_some(clip.rate),
            time_code: clip.time_code.filter(|_| is_first),
            skipped: next.map_or(0, |next| next.number - frame.number - 1),
        };
        plane.write(&mut out);
        if levels.is_intra {
            face.write(own.filter(|_| is_first), &mut out);
        }
        let mut rest = slots.iter().zip(&levels.levels).peekable();
        // FAP 1, FAP 2, and a run of all others, also if there is none.
        for run in (1..=3).filter(|run| *run == 3 || face.mask[run - 1]) {
            let mut coder = Encoder::new(&mut out);
            while let Some((slot, level)) = rest.next_if(|(slot, _)| slot.fap.min(3) == run) {
                let (min, max) = slot.range(&ranges, levels.is_intra);
                let mut model = models.model(*slot, levels.is_intra, (max - min + 1) as u32);
                coder.encode(&mut model, (level - min) as u32);
            }
            coder.finish();
            match run {
                1 => out.push(1, u64::from(frame.face.viseme[3])),
                2 => {
                    out.push(1, u64::from(frame.face.expression[4]));
                    out.push(1, u64::from(frame.face.expression[5]));
                }
                _ => {}
            }
        }
    }
    stuff(&mut out);
    out.push(32, u64::from(END));
    out.bytes
}

/// Writes stuffing up to a whole byte: a 0, then 1s; a whole byte of them if there is one already.
fn stuff(out: &mut BitWriter) {
    let count = (8 - out.bits % 8) as u32;
    out.push(count, (1 << (count - 1)) - 1);
}
