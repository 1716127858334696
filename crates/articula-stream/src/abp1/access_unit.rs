//! One access unit: plane header, main header, masks, values, end.
//!
//! Form: `docs/formats/abp1.md`, parts 3 and 4. Units, order and lengths are those of the annex of
//! the thesis.

use super::clip::TrackKind;
use crate::bits::{BitReader, BitWriter};
use crate::component::{Block, CodingType, FRAMES};
use crate::error::StreamError;
use crate::frame_rate::FrameRate;
use std::ops::Range;

const START: u64 = 0x4142_5031;
const END: u64 = 0x4142_5045;
/// Form of rotations: rotation vectors.
const VECTOR: u64 = 2;

/// The numbers at the start of an access unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Plane {
    pub(super) rate: FrameRate,
    /// Number of frames that the reader inserts between two coded ones.
    pub(super) interpolated: u8,
    pub(super) quantizer: u8,
    pub(super) power: u8,
    pub(super) coding: CodingType,
}

impl Plane {
    /// Factor on the base steps.
    pub(super) fn scale(&self) -> f64 {
        f64::from(u32::from(self.quantizer) << self.power)
    }
}

/// A bone of an access unit, with its blocks of numbers.
#[derive(Debug)]
pub(super) struct CodedBone {
    pub(super) id: u16,
    /// For each kind that it has, which axes are coded.
    pub(super) kinds: [Option<[bool; 3]>; TrackKind::ALL.len()],
    /// Blocks of the coded axes, kind by kind.
    pub(super) blocks: Vec<Block>,
}

/// Where the parts of an access unit are, in bits of the stream.
#[derive(Debug)]
pub(super) struct Places {
    pub(super) plane: Range<u64>,
    pub(super) main: Range<u64>,
    pub(super) bone_count: Range<u64>,
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
    pub(super) bones: Vec<CodedBone>,
    /// Whether all rotations are rotation vectors.
    pub(super) has_vectors_only: bool,
    pub(super) places: Places,
}

/// Writes an access unit.
pub(super) fn write(plane: &Plane, bones: &[CodedBone]) -> Vec<u8> {
    let mut out = BitWriter::default();
    out.push(32, START);
    // Intra, with a rate.
    out.push(2, 0b11);
    plane.rate.write(&mut out);
    // No time code, no skipped frames.
    out.push(2, 0);
    out.push(5, u64::from(plane.interpolated));
    out.push(5, u64::from(plane.quantizer));
    out.push(3, u64::from(plane.power));
    out.push(10, bones.len() as u64);
    // No muscles.
    out.push(10, 0);
    for bone in bones {
        write_mask(&mut out, bone);
    }
    out.push(1, plane.coding.bit());
    for block in bones.iter().flat_map(|bone| &bone.blocks) {
        block.write(&mut out);
    }
    out.pad();
    out.push(32, END);
    out.bytes
}

fn write_mask(out: &mut BitWriter, bone: &CodedBone) {
    out.push(10, u64::from(bone.id));
    for (kind, axes) in TrackKind::ALL.into_iter().zip(bone.kinds) {
        out.push(1, u64::from(axes.is_some()));
        let Some(axes) = axes else { continue };
        if kind == TrackKind::Rotation {
            out.push(2, VECTOR);
            out.push(5, 0);
        }
        if kind != TrackKind::ScaleOrientation {
            axes.iter().for_each(|axis| out.push(1, u64::from(*axis)));
        }
    }
}

/// Parses the access unit in some bytes of a stream, whose bone table has `bones` rows.
pub(super) fn read(
    stream: &[u8],
    bytes: Range<usize>,
    bones: usize,
) -> Result<AccessUnit, StreamError> {
    let mut reader = BitReader::new(stream, bytes);
    let r = &mut reader;
    let start = r.at();
    r.expect(32, START, "the start code ABP1")?;
    r.expect(2, 0b11, "an intra access unit with a rate")?;
    let rate = FrameRate::read(r)?;
    r.expect(2, 0, "neither time code nor skipped frames")?;
    let plane = start..r.at();
    let interpolated = r.take(5)? as u8;
    let quantizer = r.take(5)? as u8;
    let power = r.take(3)? as u8;
    if quantizer == 0 {
        return Err(r.bad("a quantiser of 0, expected 1 to 31"));
    }
    let count_start = r.at();
    let count = r.take(10)? as usize;
    let bone_count = count_start..r.at();
    r.expect(10, 0, "no muscles")?;
    let main = plane.end..r.at();
    let mut seen = vec![false; bones];
    let (mut coded, mut masks) = (Vec::new(), Vec::new());
    let mut has_vectors_only = true;
    for _ in 0..count {
        let start = r.at();
        let (bone, is_vector) = read_mask(r)?;
        has_vectors_only &= is_vector;
        match seen.get_mut(usize::from(bone.id)) {
            Some(seen) if !*seen => *seen = true,
            Some(_) => return Err(r.bad(format!("a second mask of bone {}", bone.id))),
            None => return Err(r.bad(format!("bone {}, the table has {bones}", bone.id))),
        }
        masks.push(start..r.at());
        coded.push(bone);
    }
    let start = r.at();
    let coding_type = CodingType::of(r.flag()?);
    let coding = start..r.at();
    let mut values = Vec::with_capacity(coded.len());
    for bone in &mut coded {
        let start = r.at();
        let axes = bone.kinds.iter().flatten().flatten();
        let count = axes.filter(|is_coded| **is_coded).count();
        bone.blocks.reserve_exact(count);
        for _ in 0..count {
            bone.blocks.push(Block::read(r, coding_type, FRAMES)?);
        }
        values.push(start..r.at());
    }
    let padding = r.padding()?;
    r.expect(32, END, "the end code ABPE")?;
    r.end()?;
    Ok(AccessUnit {
        plane: Plane {
            rate,
            interpolated,
            quantizer,
            power,
            coding: coding_type,
        },
        bones: coded,
        has_vectors_only,
        places: Places {
            plane,
            main,
            bone_count,
            masks,
            coding,
            values,
            end: padding.end..r.at(),
            padding,
        },
    })
}

/// Reads a mask, and whether its rotation is a rotation vector if it has one.
fn read_mask(r: &mut BitReader<'_>) -> Result<(CodedBone, bool), StreamError> {
    let mut bone = CodedBone {
        id: r.take(10)? as u16,
        kinds: [None; TrackKind::ALL.len()],
        blocks: Vec::new(),
    };
    let mut is_vector = true;
    for (kind, coded) in TrackKind::ALL.into_iter().zip(&mut bone.kinds) {
        if !r.flag()? {
            continue;
        }
        if kind == TrackKind::Rotation {
            is_vector = r.take(2)? == VECTOR;
            r.take(5)?;
        }
        *coded = Some(match kind {
            TrackKind::ScaleOrientation => [true; 3],
            _ => [r.flag()?, r.flag()?, r.flag()?],
        });
    }
    Ok((bone, is_vector))
}
