//! One access unit: header, parameter numbers, values, end.
//!
//! Form: `docs/formats/afp1.md`, part 3.

use crate::bits::{BitReader, BitWriter};
use crate::component::{Block, CodingType};
use crate::error::StreamError;
use crate::face::FaceFrame;
use crate::frame_rate::FrameRate;
use articula_core::fap_table::{FAP_COUNT, TABLE};
use std::ops::Range;

const START: u64 = 0x4146_5031;
const END: u64 = 0x4146_5045;

/// The numbers of an access unit before its parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Plane {
    pub(super) rate: FrameRate,
    /// 1 to 16.
    pub(super) frames: usize,
    pub(super) quantizer: u8,
    pub(super) coding: CodingType,
}

/// A parameter of an access unit, with a block for each of its fields.
#[derive(Debug)]
pub(super) struct CodedFap {
    /// Its number, 1 to 68.
    pub(super) fap: usize,
    pub(super) blocks: Vec<Block>,
}

/// Where the parts of an access unit are, in bits of the stream.
#[derive(Debug)]
pub(super) struct Places {
    pub(super) plane: Range<u64>,
    pub(super) main: Range<u64>,
    pub(super) fap_count: Range<u64>,
    pub(super) masks: Vec<Range<u64>>,
    pub(super) coding: Range<u64>,
    pub(super) values: Vec<Range<u64>>,
    pub(super) padding: Range<u64>,
    pub(super) end: Range<u64>,
}

/// A parsed access unit.
#[derive(Debug)]
pub(super) struct AccessUnit {
    pub(super) plane: Plane,
    pub(super) faps: Vec<CodedFap>,
    pub(super) places: Places,
}

/// Step of a parameter, by its number.
pub(super) fn step(fap: usize, quantizer: u8) -> f64 {
    match fap {
        1 | 2 => 1.0,
        _ => f64::from(TABLE[fap - 1].step) * f64::from(quantizer.max(1)),
    }
}

/// Form of the values of a parameter: numbers of visemes and expressions are never transformed.
pub(super) fn coding_of(fap: usize, coding: CodingType) -> CodingType {
    match fap {
        1 | 2 => CodingType::Predictive,
        _ => coding,
    }
}

/// Writes an access unit.
pub(super) fn write(plane: &Plane, faps: &[CodedFap]) -> Vec<u8> {
    let mut out = BitWriter::default();
    out.push(32, START);
    // With a rate.
    out.push(1, 1);
    plane.rate.write(&mut out);
    out.push(4, plane.frames as u64 - 1);
    out.push(5, u64::from(plane.quantizer));
    out.push(7, faps.len() as u64);
    faps.iter().for_each(|coded| out.push(7, coded.fap as u64));
    out.push(1, plane.coding.bit());
    for block in faps.iter().flat_map(|coded| &coded.blocks) {
        block.write(&mut out);
    }
    out.pad();
    out.push(32, END);
    out.bytes
}

/// Parses the access unit in some bytes of a stream.
pub(super) fn read(stream: &[u8], bytes: Range<usize>) -> Result<AccessUnit, StreamError> {
    let mut reader = BitReader::new(stream, bytes);
    let r = &mut reader;
    let start = r.at();
    r.expect(32, START, "the start code AFP1")?;
    r.expect(1, 1, "an access unit with a rate")?;
    let rate = FrameRate::read(r)?;
    let plane = start..r.at();
    let frames = r.take(4)? as usize + 1;
    let quantizer = r.take(5)? as u8;
    let start = r.at();
    let count = r.take(7)? as usize;
    let fap_count = start..r.at();
    let main = plane.end..r.at();
    let (mut faps, mut masks) = (Vec::<CodedFap>::new(), Vec::new());
    for _ in 0..count {
        let start = r.at();
        let fap = r.take(7)? as usize;
        let before = faps.last().map_or(0, |last| last.fap);
        if fap <= before || fap > FAP_COUNT {
            return Err(r.bad(format!(
                "parameter {fap} after {before}, expected rising numbers up to {FAP_COUNT}"
            )));
        }
        masks.push(start..r.at());
        let blocks = Vec::with_capacity(FaceFrame::field_count(fap));
        faps.push(CodedFap { fap, blocks });
    }
    let start = r.at();
    let coding_type = CodingType::of(r.flag()?);
    let coding = start..r.at();
    if coding_type == CodingType::Dct && frames != crate::component::FRAMES {
        return Err(r.bad(format!("a transform of {frames} frames, expected 16")));
    }
    let mut values = Vec::with_capacity(faps.len());
    for coded in &mut faps {
        let start = r.at();
        let form = coding_of(coded.fap, coding_type);
        for _ in 0..FaceFrame::field_count(coded.fap) {
            coded.blocks.push(Block::read(r, form, frames)?);
        }
        values.push(start..r.at());
    }
    let padding = r.padding()?;
    r.expect(32, END, "the end code AFPE")?;
    r.end()?;
    Ok(AccessUnit {
        plane: Plane {
            rate,
            frames,
            quantizer,
            coding: coding_type,
        },
        faps,
        places: Places {
            plane,
            main,
            fap_count,
            masks,
            coding,
            values,
            end: padding.end..r.at(),
            padding,
        },
    })
}
