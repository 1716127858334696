//! Access units: some frames of a motion, in units of one group and tier each.
//!
//! Form: `docs/formats/abp2.md`, part 2.

use super::head::MotionHead;
use super::unit_form::{UnitFault, VERSION_WITHOUT_CHECKSUMS};
use crate::error::StreamError;
use articula_core::{ByteReader, MalformedBytes};
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
        let Some(length) = stream.get(start..start + PREFIX) else {
            return Ok(None);
        };
        let length = u32::from_be_bytes([length[0], length[1], length[2], length[3]]) as usize;
        let at = start + PREFIX;
        let end = at + length;
        let is_whole = end <= stream.len();
        let bad = |fault: MalformedBytes| {
            let place = format!("byte {} (access unit {number})", at + fault.at);
            StreamError::malformed(place, fault.what)
        };
        let mut reader = ByteReader::new(&stream[at..end.min(stream.len())]);
        let frames = head.frames_of(number);
        if head.version == VERSION_WITHOUT_CHECKSUMS {
            match check_frames(&mut reader, frames.len()) {
                Err(UnitFault::Early(_)) if !is_whole => return Ok(None),
                checked => checked.map_err(|fault| bad(fault.of_whole()))?,
            }
        }
        let mut access_unit = Self {
            units: Vec::new(),
            frames,
            bytes: start..end,
            header: PREFIX + reader.at(),
            is_whole,
        };
        let form = head.unit_form(number);
        let mut finest = vec![head.tiers; head.group_count()];
        while reader.left() > 0 {
            let unit = match form.read(&mut reader) {
                Err(UnitFault::Early(_)) if !is_whole => break,
                read => read.map_err(|fault| bad(fault.of_whole()))?,
            };
            let (group, tier) = head.group_and_tier(unit.number);
            if tier >= finest[group] {
                let what = format!("tier {tier} of group {group} after tier {}", finest[group]);
                return Err(bad(MalformedBytes {
                    at: unit.bytes.start,
                    what,
                }));
            }
            finest[group] = tier;
            access_unit.units.push(UnitPlace {
                group,
                tier,
                bytes: at + unit.bytes.start..at + unit.bytes.end,
                body: at + unit.body.start..at + unit.body.end,
            });
        }
        Ok(Some(access_unit))
    }
}

/// Reads the number of frames that version 1 repeats in each access unit.
fn check_frames(reader: &mut ByteReader<'_>, expected: usize) -> Result<(), UnitFault> {
    let at = reader.at();
    let frames = reader.varint().map_err(UnitFault::Early)?;
    if frames == expected as u64 {
        return Ok(());
    }
    let what = format!("{frames} frames, expected {expected}");
    Err(UnitFault::Damaged(MalformedBytes { at, what }))
}

/// Appends access unit `number` with the given units: group, tier and body.
pub(super) fn write(
    out: &mut Vec<u8>,
    number: usize,
    head: &MotionHead,
    units: &[(usize, usize, Vec<u8>)],
) {
    let start = out.len();
    out.extend([0; PREFIX]);
    let form = head.unit_form(number);
    for (group, tier, body) in units {
        form.write(out, head.unit_number(*group, *tier), body);
    }
    let length = (out.len() - start - PREFIX) as u32;
    out[start..start + PREFIX].copy_from_slice(&length.to_be_bytes());
}

#[cfg(test)]
mod tests {
    use super::super::grouping::{Group, Grouping};
    use super::super::unit_form::VERSION;
    use super::*;
    use crate::cut::{CutRule, cut};
    use crate::limits::StreamLimits;

    /// The example of the page: one joint and five tiers.
    fn head() -> MotionHead {
        let group = Group {
            loa: 0,
            region: 0,
            joint: None,
        };
        MotionHead {
            version: VERSION,
            name: String::new(),
            grouping: Grouping::Loa,
            updates: true,
            tiers: 5,
            tolerance_micrometres: 100,
            rate_hz: 30.0,
            frames: 5,
            joints: 1,
            access_units: 1,
            rig_hash: 0,
            scales: false,
            groups: vec![group],
            morph_groups: Vec::new(),
            morphs: Vec::new(),
            face: None,
        }
    }

    #[test]
    fn one_joint_by_hand() {
        let head = head();
        let bodies = [
            (0, 4, vec![0x7b, 0x2e, 0x60]),
            (0, 1, vec![0xb3]),
            (0, 0, vec![0xe0, 0x80]),
        ];
        let mut stream = head.write(&[], None);
        let start = stream.len();
        write(&mut stream, 0, &head, &bodies);
        // A length times five and the number; the checksums are those of a program in Python.
        let units = [
            &[0x0f, 0x7b, 0x2e, 0x60, 0x23][..],
            &[0x08, 0xb3, 0x5b],
            &[0x0e, 0xe0, 0x80, 0xb1],
        ];
        assert_eq!(
            stream[start..],
            [&[0, 0, 0, 12], &units.concat()[..]].concat()
        );
        let map = super::super::motion_map(&stream, &StreamLimits::default()).unwrap();
        let rule = CutRule::default().at_least("tier", 1);
        let coarse = cut(&stream, &map, |unit| rule.keeps(unit)).unwrap();
        let expected = [&[0, 0, 0, 8], units[0], units[1]].concat();
        assert_eq!(coarse.bytes[start..], expected);
    }

    #[test]
    fn damage_is_told_with_its_byte_also_where_the_end_is_missing() {
        let head = head();
        let mut stream = head.write(&[], None);
        let start = stream.len();
        write(
            &mut stream,
            0,
            &head,
            &[(0, 4, vec![1, 2]), (0, 3, vec![3; 30])],
        );
        let read = |stream: &[u8]| AccessUnit::read(stream, start, 0, &head);
        let first = start + PREFIX..start + PREFIX + 4;
        stream[first.start + 1] ^= 4;
        for length in first.end..=stream.len() {
            let why = read(&stream[..length]).unwrap_err().to_string();
            let place = format!(
                "byte {} (access unit 0): the checksum of unit 0",
                first.start
            );
            assert!(why.starts_with(&place), "{why}");
        }
        for length in start + PREFIX..first.end {
            let part = read(&stream[..length]).unwrap().unwrap();
            assert!(part.units.is_empty() && !part.is_whole);
        }
    }
}
