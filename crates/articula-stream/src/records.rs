//! The records of an index as they lie in its bytes, for a cut that makes no tree of them.
//!
//! Form: `docs/formats/stream-index.md`.

use crate::coding::Coding;
use crate::index::{FIELD, MAGIC, MARKER, PADDING, UNIT, VERSION, known_name};
use articula_core::ByteReader;
use std::borrow::Cow;
use std::ops::Range;

/// The parts of an index.
#[derive(Debug)]
pub(crate) struct IndexRecords<'a> {
    pub(crate) units: &'a [u8],
    pub(crate) markers: &'a [u8],
    pub(crate) fields: &'a [u8],
    pub(crate) names: Vec<&'a str>,
}

/// A unit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct UnitRecord {
    /// Its first byte, and the one after the last.
    pub(crate) start: u64,
    pub(crate) end: u64,
    pub(crate) markers: usize,
    pub(crate) fields: usize,
    pub(crate) label: u16,
    pub(crate) depth: u16,
}

/// A length that counts the bytes from its end to the end of its unit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LengthRecord {
    pub(crate) bits: [u64; 2],
    pub(crate) value: u64,
    pub(crate) coding: Coding,
    pub(crate) name: u16,
}

impl LengthRecord {
    pub(crate) fn range(&self) -> Range<u64> {
        self.bits[0]..self.bits[1]
    }
}

impl<'a> IndexRecords<'a> {
    /// The parts of an index; `None` if it is malformed, as [`read_index`](crate::read_index) tells.
    pub(crate) fn of(index: &'a [u8]) -> Option<Self> {
        let mut reader = ByteReader::new(index);
        if reader.take().ok()? != MAGIC || reader.u32().ok()? != VERSION {
            return None;
        }
        let mut counts = [0; 4];
        for count in &mut counts {
            *count = reader.u32().ok()? as usize;
        }
        let [names, units, markers, fields] = counts;
        let mut records = |count: usize, size: usize| reader.slice(count.checked_mul(size)?).ok();
        let units = records(units, UNIT)?;
        let markers = records(markers, MARKER)?;
        let fields = records(fields, FIELD)?;
        let mut name = || {
            let length = u16::from_le_bytes(reader.take().ok()?);
            std::str::from_utf8(reader.slice(usize::from(length)).ok()?).ok()
        };
        // Numbers of names are those of 16 bits.
        let names = (0..names.min(usize::from(u16::MAX) + 2)).map(|_| name());
        let names = names.collect::<Option<Vec<_>>>()?;
        reader.end().ok()?;
        Some(Self {
            units,
            markers,
            fields,
            names,
        })
    }

    /// The name of a number.
    pub(crate) fn name(&self, number: u16) -> Option<Cow<'static, str>> {
        self.names
            .get(usize::from(number))
            .map(|name| known_name(name))
    }
}

/// Reads a unit of whole bytes that is no padding; `None` for another one.
pub(crate) fn unit(record: &[u8; UNIT]) -> Option<UnitRecord> {
    let u64_at = |at: usize| word(record, at);
    let u32_at = |at: usize| word(record, at).map(u32::from_le_bytes);
    let u16_at = |at: usize| word(record, at).map(u16::from_le_bytes);
    let (start, end) = (u64_at(0)?, u64_at(8)?);
    let [start, end] = [start, end].map(u64::from_le_bytes);
    let flags = u32_at(28)?;
    let is_plain = flags & PADDING == 0 && flags == 0;
    (is_plain && start.is_multiple_of(8) && end.is_multiple_of(8)).then_some(UnitRecord {
        start: start / 8,
        end: end / 8,
        markers: u32_at(16)? as usize,
        fields: u32_at(20)? as usize,
        label: u16_at(24)?,
        depth: u16_at(26)?,
    })
}

/// Reads a length of bytes that follow; `None` for another field.
pub(crate) fn length(record: &[u8; FIELD]) -> Option<LengthRecord> {
    let start = u64::from_le_bytes(word(record, 0)?);
    let [bits, coding, meaning, _] = word(record, 16)?;
    let coding = match coding {
        0 => Coding::BigEndian,
        1 => Coding::LittleEndian,
        2 => Coding::Varint,
        _ => return None,
    };
    (meaning == 0).then_some(LengthRecord {
        bits: [start, start.checked_add(u64::from(bits))?],
        value: u64::from_le_bytes(word(record, 8)?),
        coding,
        name: u16::from_le_bytes(word(record, 20)?),
    })
}

fn word<const N: usize>(record: &[u8], at: usize) -> Option<[u8; N]> {
    record.get(at..at + N)?.try_into().ok()
}
