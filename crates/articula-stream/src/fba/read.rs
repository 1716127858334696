//! Decoding of a stream.

use super::clip::{FbaClip, FbaFrame, TimeCode};
use super::coder::Decoder;
use super::fields::Fields;
use super::header::{END, Face, PLANE, Plane, STREAM};
use super::quantise;
use super::ranges::Ranges;
use super::slot::{self, Models, Slot, slots};
use crate::bits::BitReader;
use crate::error::StreamError;
use crate::face::FaceFrame;
use crate::frame_rate::FrameRate;
use crate::limits::StreamLimits;
use articula_core::fap_table::FAP_COUNT;

/// Greatest number of a frame.
pub(super) const MOST_NUMBER: u32 = 1 << 20;
/// Greatest magnitude of a value: predictions that go on growing are refused.
const MOST_VALUE: i64 = 1 << 30;
/// Rate of streams that name none.
const DEFAULT_HZ: f64 = 30.0;

/// A decoded stream.
#[derive(Debug, Clone, PartialEq)]
pub struct Decoded {
    /// The clip.
    pub clip: FbaClip,
    /// Number of frames that depend on no other.
    pub intra_frames: usize,
    /// Greatest quantiser of a frame.
    pub quantizer: u8,
}

/// State between frames.
struct Receiver {
    /// From the first intra frame on.
    intra: Option<(Face, Ranges)>,
    models: Models,
    /// What differences are to: the values as decoded, not yet in the range of their field.
    decoded: [i64; slot::COUNT],
    shown: FaceFrame,
}

/// Decodes a stream.
///
/// Parameters that a frame does not code hold their value, also those that a receiver should
/// interpolate (mask type 2).
///
/// # Errors
/// [`StreamError::Malformed`] that names the byte and field, [`StreamError::Unsupported`] for body
/// data and the transform, [`StreamError::LimitExceeded`].
pub fn read(bytes: &[u8], limits: &StreamLimits) -> Result<Decoded, StreamError> {
    StreamLimits::check("byte 0", "bytes", bytes.len() as u64, limits.bytes)?;
    let mut f = Fields {
        reader: BitReader::new(bytes, 0..bytes.len()),
    };
    let code = f.take("fba_object_start_code", 32)? as u32;
    if !STREAM.contains(&code) {
        let what = format!("{code:#010x}, expected {:#010x}", STREAM[0]);
        return Err(f.bad("fba_object_start_code", what));
    }
    let mut receiver = Receiver {
        intra: None,
        models: Models::new(),
        decoded: [0; slot::COUNT],
        shown: FaceFrame::NEUTRAL,
    };
    let mut rate: Option<FrameRate> = None;
    let mut time_code: Option<TimeCode> = None;
    let (mut coded, mut frames) = ([false; FAP_COUNT], Vec::<FbaFrame>::new());
    let (mut intra_frames, mut quantizer) = (0, 0);
    let mut number = 0;
    while !plane_or_end(&mut f)? {
        let elements = (frames.len() as u64 + 1) * FAP_COUNT as u64;
        StreamLimits::check(&f.place("frames"), "elements", elements, limits.elements)?;
        let most_skipped = MOST_NUMBER.saturating_sub(number);
        let plane = Plane::read(&mut f, most_skipped)?;
        if let Some(found) = plane.rate {
            if rate.is_some_and(|rate| rate.hz() != found.hz()) {
                return Err(f.unsupported(
                    "frame_rate",
                    "a change of the frame rate",
                    "write the stream with one rate",
                ));
            }
            rate = Some(found);
        }
        if frames.is_empty() {
            time_code = plane.time_code;
        }
        let face = receiver.frame(&mut f, plane.is_intra)?;
        intra_frames += usize::from(plane.is_intra);
        quantizer = quantizer.max(face.quantizer);
        coded.iter_mut().zip(face.mask).for_each(|(a, b)| *a |= b);
        frames.push(FbaFrame {
            number,
            face: receiver.shown,
        });
        number += 1 + plane.skipped;
    }
    let rate = rate.or_else(|| FrameRate::nearest(DEFAULT_HZ));
    let rate = rate.ok_or_else(|| f.bad("frame_rate", "none"))?;
    Ok(Decoded {
        clip: FbaClip {
            rate,
            time_code,
            coded,
            frames,
        },
        intra_frames,
        quantizer,
    })
}

/// Goes to the next object plane; returns whether the end of the stream is there instead.
fn plane_or_end(f: &mut Fields<'_>) -> Result<bool, StreamError> {
    if let Some((code, after)) = f.start_code() {
        let is_end = code == END;
        if !is_end && !PLANE.contains(&code) {
            let what = format!("{code:#010x}, expected {:#010x} or {END:#010x}", PLANE[0]);
            return Err(f.bad("fba_object_plane_start_code", what));
        }
        f.reader.go_to(after);
        if is_end && after != f.reader.end_at() {
            return Err(f.bad("end code", "bytes after it"));
        }
        return Ok(is_end);
    }
    Ok(false)
}

impl Receiver {
    /// Decodes the face data of a frame.
    fn frame(&mut self, f: &mut Fields<'_>, is_intra: bool) -> Result<Face, StreamError> {
        if is_intra {
            self.intra = Some(Face::read(f, self.intra.map(|(_, ranges)| ranges))?);
            self.models = Models::new();
        }
        let bad = || f.bad("is_intra", "a predicted frame before the first intra frame");
        let (face, ranges) = self.intra.ok_or_else(bad)?;
        for fap in (1..=2).filter(|fap| face.mask[fap - 1]) {
            self.run(f, slots(fap), is_intra, (face.quantizer, &ranges))?;
            let flags: &[&str] = match fap {
                1 => &["viseme_def"],
                _ => &["init_face", "expression_def"],
            };
            for (field, name) in (slots(fap).count()..).zip(flags) {
                let flag = i32::from(f.flag(name)?);
                // A flag is always in its range.
                self.shown.set_field(fap, field, flag);
            }
        }
        let low = (3..=FAP_COUNT).filter(|fap| face.mask[fap - 1]);
        self.run(f, low.flat_map(slots), is_intra, (face.quantizer, &ranges))?;
        Ok(face)
    }

    /// Decodes a run of the arithmetic coder, which has bits also if it has no numbers.
    fn run(
        &mut self,
        f: &mut Fields<'_>,
        slots: impl Iterator<Item = Slot>,
        is_intra: bool,
        (quantizer, ranges): (u8, &Ranges),
    ) -> Result<(), StreamError> {
        let mut decoder = Decoder::new(&f.reader);
        for slot in slots {
            let (min, max) = slot.range(ranges, is_intra);
            let symbols = (max - min + 1) as u32;
            let mut model = self.models.model(slot, is_intra, symbols);
            let level = min + i64::from(decoder.decode(&mut model));
            let mut value = quantise::value(level, slot.step(quantizer));
            if !is_intra {
                value += self.decoded[slot.index()];
            }
            self.decoded[slot.index()] = value;
            // A step need not divide the greatest value.
            if let Some(most) = slot.most().filter(|_| slot.step(quantizer) > 1) {
                value = value.clamp(0, most);
            }
            let fits = (value.abs() <= MOST_VALUE)
                .then(|| self.shown.set_field(slot.fap, slot.field, value as i32));
            if fits.flatten().is_none() {
                let what = format!("a value of {value} is out of its range");
                return Err(f.bad(&slot.name(), what));
            }
        }
        let end = decoder.finish();
        let end = end.map_err(|what| f.bad("coded parameters", what))?;
        f.reader.go_to(end);
        Ok(())
    }
}
