//! The head of an object plane, and of the face data of an intra frame.
//!
//! Form: `docs/formats/fba.md`, parts 2 and 3.

use super::clip::TimeCode;
use super::fields::Fields;
use super::ranges::{self, Bounds, Ranges};
use crate::bits::BitWriter;
use crate::error::StreamError;
use crate::frame_rate::FrameRate;
use articula_core::fap_table::{FAP_COUNT, GROUPS, LOW_FAP_COUNT};

/// Start of a stream, today and in old ones.
pub(super) const STREAM: [u32; 2] = [0x1ba, 0x101];
/// Start of an object plane, today and in old ones.
pub(super) const PLANE: [u32; 2] = [0x1bb, 0x103];
/// End of a stream.
pub(super) const END: u32 = 0x1b1;

const FACE: u64 = 1;
const RANGE_FIELDS: [&str; 4] = [
    "is_i_new_max",
    "is_i_new_min",
    "is_p_new_max",
    "is_p_new_min",
];

/// The head of an object plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Plane {
    pub(super) is_intra: bool,
    pub(super) rate: Option<FrameRate>,
    pub(super) time_code: Option<TimeCode>,
    /// Number of frames skipped after this one, which is shown for longer.
    pub(super) skipped: u32,
}

/// What an intra frame says of the face, until the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Face {
    pub(super) quantizer: u8,
    /// Parameters that are coded; index 0 is FAP 1.
    pub(super) mask: [bool; FAP_COUNT],
}

impl Plane {
    pub(super) fn read(f: &mut Fields<'_>, most_skipped: u32) -> Result<Self, StreamError> {
        let is_intra = f.flag("is_intra")?;
        let mask = f.take("fba_object_mask", 2)?;
        if mask != FACE {
            return Err(match mask {
                0 => f.bad("fba_object_mask", "neither a face nor a body"),
                _ => f.unsupported(
                    "fba_object_mask",
                    "body data (mask bit 2)",
                    "write the stream with the face alone",
                ),
            });
        }
        let (mut rate, mut time_code) = (None, None);
        if is_intra {
            if f.flag("is_frame_rate")? {
                let place = f.place("frame_rate");
                let bad = |_| StreamError::malformed(place, "a rate of 0, or an unexpected end");
                rate = Some(FrameRate::read(&mut f.reader).map_err(bad)?);
            }
            if f.flag("is_time_code")? {
                time_code = Some(read_time_code(f)?);
            }
        }
        let mut skipped = 0;
        if f.flag("skip_frames")? {
            loop {
                let part = f.take("number_of_frames_to_skip", 4)? as u32;
                skipped += part;
                if skipped > most_skipped {
                    return Err(f.bad("number_of_frames_to_skip", "too many frames"));
                }
                if part < 15 {
                    break;
                }
            }
        }
        Ok(Self {
            is_intra,
            rate,
            time_code,
            skipped,
        })
    }

    pub(super) fn write(&self, out: &mut BitWriter) {
        out.push(1, u64::from(self.is_intra));
        out.push(2, FACE);
        if self.is_intra {
            out.push(1, u64::from(self.rate.is_some()));
            if let Some(rate) = self.rate {
                rate.write(out);
            }
            out.push(1, u64::from(self.time_code.is_some()));
            if let Some(time) = self.time_code {
                out.push(5, u64::from(time.hours));
                out.push(6, u64::from(time.minutes));
                out.push(1, 1);
                out.push(6, u64::from(time.seconds));
            }
        }
        out.push(1, u64::from(self.skipped > 0));
        if self.skipped > 0 {
            (0..self.skipped / 15).for_each(|_| out.push(4, 15));
            out.push(4, u64::from(self.skipped % 15));
        }
    }
}

fn read_time_code(f: &mut Fields<'_>) -> Result<TimeCode, StreamError> {
    let hours = f.take("time_code hours", 5)? as u8;
    let minutes = f.take("time_code minutes", 6)? as u8;
    f.marker("time_code marker")?;
    let seconds = f.take("time_code seconds", 6)? as u8;
    let time = TimeCode {
        hours,
        minutes,
        seconds,
    };
    if time.is_valid() {
        return Ok(time);
    }
    Err(f.bad("time_code", format!("{hours}:{minutes}:{seconds}")))
}

impl Face {
    /// Reads the head after one with some ranges, or the first; returns also the ranges from now on.
    pub(super) fn read(
        f: &mut Fields<'_>,
        ranges: Option<Ranges>,
    ) -> Result<(Self, Ranges), StreamError> {
        let quantizer = f.take("fap_quant", 5)? as u8;
        let mut ranges = ranges.unwrap_or_else(|| Ranges::new(&ranges::of_table(), quantizer));
        let mut mask = [false; FAP_COUNT];
        let mut first = 0;
        for (_, count) in GROUPS {
            f.marker("fap_mask_type marker")?;
            let kind = f.take("fap_mask_type", 2)?;
            for coded in &mut mask[first..first + count] {
                *coded = match kind {
                    0 => false,
                    3 => true,
                    _ => f.flag("fap_group_mask")?,
                };
            }
            first += count;
        }
        f.flag("suggested_gender")?;
        if f.flag("coding_type")? {
            return Err(f.unsupported(
                "coding_type",
                "a face stream coded by the transform (DCT)",
                "write it in predictive mode",
            ));
        }
        let mut are_new = [false; 4];
        for (is_new, field) in are_new.iter_mut().zip(RANGE_FIELDS) {
            *is_new = f.flag(field)?;
        }
        let lists = are_new
            .into_iter()
            .zip(RANGE_FIELDS)
            .zip(&mut ranges.levels);
        for ((is_new, field), levels) in lists {
            if !is_new {
                continue;
            }
            for index in 0..LOW_FAP_COUNT {
                if ranges::has_marker(index) {
                    f.marker(field)?;
                }
                if mask[index + 2] {
                    levels[index] = ranges::reach(f.take(field, 5)? as u8, quantizer);
                }
            }
        }
        if quantizer > 0 {
            ranges.high = ranges::high(quantizer);
        }
        Ok((Self { quantizer, mask }, ranges))
    }

    /// Writes the head, with new ranges if there are.
    pub(super) fn write(&self, bounds: Option<&Bounds>, out: &mut BitWriter) {
        out.push(5, u64::from(self.quantizer));
        let mut first = 0;
        for (_, count) in GROUPS {
            let mask = &self.mask[first..first + count];
            first += count;
            out.push(1, 1);
            if mask.iter().all(|coded| *coded) {
                out.push(2, 3);
            } else if mask.contains(&true) {
                out.push(2, 1);
                mask.iter().for_each(|coded| out.push(1, u64::from(*coded)));
            } else {
                out.push(2, 0);
            }
        }
        // No gender is known; predictive.
        out.push(2, 0);
        out.push(4, if bounds.is_some() { 0b1111 } else { 0 });
        for bounds in bounds.into_iter().flatten() {
            for (index, bound) in bounds.iter().enumerate() {
                if ranges::has_marker(index) {
                    out.push(1, 1);
                }
                if self.mask[index + 2] {
                    out.push(5, u64::from(*bound));
                }
            }
        }
    }
}
