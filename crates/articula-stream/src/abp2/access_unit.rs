//! Access units: some frames of a motion, in units of one group and tier each.
//!
//! Form: `docs/formats/abp2.md`, part 2.

use super::head::MotionHead;
use crate::error::StreamError;
use articula_core::{ByteReader, push_varint};
use std::ops::Range;

/// Bytes of the length of an access unit.
pub(super) const PREFIX: usize = 4;

/// A unit of an access unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct UnitPlace {
    pub(crate) group: usize,
    pub(crate) tier: usize,
    /// All its bytes.
    pub(crate) bytes: Range<usize>,
    pub(crate) body: Range<usize>,
}

/// An access unit, or the part of it that was received.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct AccessUnit {
    /// The whole units, in the order of the bytes.
    pub(crate) units: Vec<UnitPlace>,
    /// Its frames in the motion.
    pub(crate) frames: Range<usize>,
    /// All its bytes, also those that were not received.
    pub(crate) bytes: Range<usize>,
    /// Bytes before the first unit.
    pub(super) header: usize,
    /// Whether all bytes were received.
    pub(crate) is_whole: bool,
}

impl AccessUnit {
    /// Reads access unit `number` at `start` of a stream; `None` if the stream ends before its
    /// first unit. A unit that is cut off is left out.
    pub(crate) fn read(
        stream: &[u8],
        start: usize,
        number: usize,
        head: &MotionHead,
    ) -> Result<Option<Self>, StreamError> {
        let bad = |at: usize, what: String| {
            StreamError::malformed(format!("byte {at} (access unit {number})"), what)
        };
        let Some(length) = stream.get(start..start + PREFIX) else {
            return Ok(None);
        };
        let length = u32::from_be_bytes([length[0], length[1], length[2], length[3]]) as usize;
        let end = start + PREFIX + length;
        let is_whole = end <= stream.len();
        let received = end.min(stream.len());
        let at = start + PREFIX;
        let mut reader = ByteReader::new(&stream[at..received]);
        let frames = match reader.varint() {
            Ok(frames) => frames as usize,
            Err(_) if !is_whole => return Ok(None),
            Err(e) => return Err(bad(at + e.at, e.what)),
        };
        let of_head = head.frames_of(number);
        if frames != of_head.len() {
            let what = format!("{frames} frames, expected {}", of_head.len());
            return Err(bad(at, what));
        }
        let mut access_unit = Self {
            units: Vec::new(),
            frames: of_head,
            bytes: start..end,
            header: PREFIX + reader.at(),
            is_whole,
        };
        let mut finest = vec![head.tiers; head.group_count()];
        while reader.left() > 0 {
            let first = reader.at();
            let unit = unit_header(&mut reader);
            let (id, length) = match unit {
                Ok(unit) => unit,
                Err(_) if !is_whole => break,
                Err(e) => return Err(bad(at + e.at, e.what)),
            };
            let (group, tier) = (id / head.tiers, head.tiers - 1 - id % head.tiers);
            let body = reader.at();
            if group >= finest.len() {
                let what = format!("group {group}, the stream has {}", finest.len());
                return Err(bad(at + first, what));
            }
            if tier >= finest[group] {
                let what = format!("tier {tier} of group {group} after tier {}", finest[group]);
                return Err(bad(at + first, what));
            }
            if let Err(e) = reader.slice(length) {
                if is_whole {
                    return Err(bad(
                        at + e.at,
                        format!("a unit of {length} bytes exceeds its access unit"),
                    ));
                }
                break;
            }
            finest[group] = tier;
            access_unit.units.push(UnitPlace {
                group,
                tier,
                bytes: at + first..at + reader.at(),
                body: at + body..at + reader.at(),
            });
        }
        Ok(Some(access_unit))
    }
}

fn unit_header(
    reader: &mut ByteReader<'_>,
) -> Result<(usize, usize), articula_core::MalformedBytes> {
    Ok((reader.varint()? as usize, reader.varint()? as usize))
}

/// Appends an access unit with the given units: group, tier and body.
pub(super) fn write(
    out: &mut Vec<u8>,
    frames: usize,
    tiers: usize,
    units: &[(usize, usize, Vec<u8>)],
) {
    let start = out.len();
    out.extend([0; PREFIX]);
    push_varint(out, frames as u64);
    for (group, tier, body) in units {
        push_varint(out, (group * tiers + tiers - 1 - tier) as u64);
        push_varint(out, body.len() as u64);
        out.extend(body);
    }
    let length = (out.len() - start - PREFIX) as u32;
    out[start..start + PREFIX].copy_from_slice(&length.to_be_bytes());
}
