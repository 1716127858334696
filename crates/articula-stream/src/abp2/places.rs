//! Where in a stream some bytes are: the length of an access unit, or a unit.
//!
//! Form: `docs/formats/abp2.md`, part 2. Positions count from the start of the stream.

use super::access_unit::PREFIX;
use super::head::{MotionHead, ReadHead};
use super::unit_form::{UnitBytes, UnitFault, UnitForm, VERSION_WITHOUT_CHECKSUMS};
use crate::error::StreamError;
use articula_core::ByteReader;
use std::ops::Range;

/// A whole part of a stream.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Part {
    /// The length of an access unit.
    Length { access_unit: usize },
    /// A unit, of the head if of no access unit.
    Unit {
        access_unit: Option<usize>,
        number: usize,
        at: u64,
        /// In the bytes that were read.
        body: Range<usize>,
    },
}

impl Part {
    /// A unit that was read from byte `from` on of some bytes, which is byte `at` for errors.
    fn unit(access_unit: Option<usize>, (at, from): (u64, usize), unit: &UnitBytes) -> Self {
        Self::Unit {
            access_unit,
            number: unit.number,
            at,
            body: from + unit.body.start..from + unit.body.end,
        }
    }
}

/// What is known of where access units begin.
#[derive(Debug, Clone)]
pub(super) struct Places {
    /// Units of the head.
    head: Range<u64>,
    /// Starts of the access units from the first on, as far as lengths are known.
    starts: Vec<u64>,
}

/// Where a byte is.
enum Place {
    /// In the fields of the head, which end here.
    Fields(u64),
    /// In a unit of the head, or of an access unit; the units end here.
    Units(Option<usize>, u64),
    /// At the length of an access unit.
    Length(usize),
    /// At the number of frames that version 1 repeats, in an access unit that ends here.
    Frames(usize, u64),
    /// Behind the last access unit.
    End,
    /// In an access unit whose length is not known.
    Unknown,
}

impl Places {
    pub(super) fn new(read: &ReadHead) -> Self {
        Self {
            head: read.fields as u64..read.bytes as u64,
            starts: vec![read.bytes as u64],
        }
    }

    /// Number of access units whose length is known.
    pub(super) fn known(&self) -> usize {
        self.starts.len() - 1
    }

    /// Forgets the lengths of access units from `known` on.
    pub(super) fn forget(&mut self, known: usize) {
        self.starts.truncate(known + 1);
    }

    /// The access unit that a position is in, unless it is at its start.
    pub(super) fn within(&self, at: u64) -> Option<usize> {
        let after = self.starts.partition_point(|start| *start < at);
        let is_within = self.starts.get(after).is_some_and(|end| *end > at);
        after.checked_sub(1).filter(|_| is_within)
    }

    fn place(&self, at: u64, head: &MotionHead) -> Place {
        if at < self.head.start {
            return Place::Fields(self.head.start);
        }
        if at < self.head.end {
            return Place::Units(None, self.head.end);
        }
        let access_unit = self.starts.partition_point(|start| *start <= at) - 1;
        let within = at - self.starts[access_unit];
        match self.starts.get(access_unit + 1) {
            None if within > 0 && access_unit < head.access_units => Place::Unknown,
            None if access_unit == head.access_units => Place::End,
            _ if within == 0 => Place::Length(access_unit),
            Some(end) if within == PREFIX as u64 && head.version == VERSION_WITHOUT_CHECKSUMS => {
                Place::Frames(access_unit, *end)
            }
            Some(end) => Place::Units(Some(access_unit), *end),
            None => Place::Unknown,
        }
    }

    /// Splits bytes from `start` on, which must begin with a part or within the fields of the head, into
    /// parts; learns lengths. Returns the parts and the number of bytes that were read: what is left
    /// ends too early, or is where a length is not known.
    ///
    /// # Errors
    /// A [`StreamError`] that names the byte.
    pub(super) fn read(
        &mut self,
        start: u64,
        bytes: &[u8],
        head: &MotionHead,
    ) -> Result<(Vec<Part>, usize), StreamError> {
        let mut parts = Vec::new();
        let mut at = 0;
        while at < bytes.len() {
            let here = start + at as u64;
            let rest = &bytes[at..];
            match self.place(here, head) {
                Place::Fields(end) => at += rest.len().min((end - here) as usize),
                Place::Units(of, end) => {
                    let form = of.map_or_else(|| head.form(), |number| head.unit_form(number));
                    let Some(unit) = unit(form, of, (here, end), rest)? else {
                        break;
                    };
                    parts.push(Part::unit(of, (here, at), &unit));
                    at += unit.bytes.end;
                }
                Place::Length(access_unit) => {
                    let Some(length) = rest.first_chunk::<PREFIX>() else {
                        break;
                    };
                    self.learn(access_unit, u32::from_be_bytes(*length), head.version)?;
                    parts.push(Part::Length { access_unit });
                    at += PREFIX;
                }
                Place::Frames(access_unit, end) => {
                    let expected = head.frames_of(access_unit).len();
                    let Some(length) = frames((here, end), rest, expected)? else {
                        break;
                    };
                    at += length;
                }
                Place::End => {
                    let what = "bytes after the last access unit";
                    return Err(StreamError::malformed(format!("byte {here}"), what));
                }
                Place::Unknown => break,
            }
        }
        Ok((parts, at))
    }

    /// Takes the length of an access unit whose start is known.
    fn learn(&mut self, access_unit: usize, length: u32, version: u8) -> Result<(), StreamError> {
        let start = self.starts[access_unit];
        if length == 0 && version == VERSION_WITHOUT_CHECKSUMS {
            let what = format!("access unit {access_unit} ends before its frames");
            return Err(StreamError::malformed(format!("byte {start}"), what));
        }
        let end = start + PREFIX as u64 + u64::from(length);
        match self.starts.get(access_unit + 1) {
            None => self.starts.push(end),
            Some(known) if *known == end => {}
            Some(known) => {
                let before = known - start - PREFIX as u64;
                let what = format!("access unit {access_unit} has {length} bytes, {before} before");
                return Err(StreamError::malformed(format!("byte {start}"), what));
            }
        }
        Ok(())
    }
}

/// The unit at the start of some bytes; `None` if they end within it. Its access unit, or the head, goes from `here` to `end`.
fn unit(
    form: UnitForm,
    access_unit: Option<usize>,
    (here, end): (u64, u64),
    bytes: &[u8],
) -> Result<Option<UnitBytes>, StreamError> {
    let most = usize::try_from(end - here).unwrap_or(usize::MAX);
    let is_whole = bytes.len() >= most;
    let mut reader = ByteReader::new(&bytes[..bytes.len().min(most)]);
    match form.read(&mut reader) {
        Ok(unit) => Ok(Some(unit)),
        Err(UnitFault::Early(_)) if !is_whole => Ok(None),
        Err(fault) => {
            let fault = fault.of_whole();
            let at = here + fault.at as u64;
            let of = access_unit.map_or_else(String::new, |n| format!(" (access unit {n})"));
            Err(StreamError::malformed(format!("byte {at}{of}"), fault.what))
        }
    }
}

/// Bytes of the number of frames that version 1 repeats in each access unit, which goes from `here` to
/// `end`; `None` if they end within it.
fn frames(
    (here, end): (u64, u64),
    bytes: &[u8],
    expected: usize,
) -> Result<Option<usize>, StreamError> {
    let mut reader = ByteReader::new(bytes);
    let Ok(found) = reader.varint() else {
        return Ok(None);
    };
    if found == expected as u64 && here + reader.at() as u64 <= end {
        return Ok(Some(reader.at()));
    }
    let what = format!("{found} frames, expected {expected}");
    Err(StreamError::malformed(format!("byte {here}"), what))
}

/// Splits whole units of an access unit, of which nothing else is known, into parts.
///
/// # Errors
/// A [`StreamError`] that names the byte of those given.
pub(super) fn units_of(
    access_unit: usize,
    bytes: &[u8],
    head: &MotionHead,
) -> Result<Vec<Part>, StreamError> {
    let form = head.unit_form(access_unit);
    let mut parts = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let place = (at as u64, bytes.len() as u64);
        let Some(unit) = unit(form, Some(access_unit), place, &bytes[at..])? else {
            break;
        };
        parts.push(Part::unit(Some(access_unit), (at as u64, at), &unit));
        at += unit.bytes.end;
    }
    Ok(parts)
}
