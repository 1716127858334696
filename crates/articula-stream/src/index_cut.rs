//! The cut of a stream by its index, record by record: no tree of units is made.
//!
//! Units with the same label and markers are cut alike, and asked for once; those that stay side by side
//! are copied together. What is not of whole bytes, or has other numbers than lengths, is cut by its tree
//! ([`cut`](crate::cut())): the result is the same.

use crate::cut::cut;
use crate::error::StreamError;
use crate::index::{FIELD, HEAD, MARKER, UNIT, head, names_bytes, read_index, write_index};
use crate::records::{IndexRecords, LengthRecord, UnitRecord, length, unit};
use crate::unit::{Marker, Unit};
use std::collections::BTreeMap;
use std::ops::Range;

/// Greatest depth of a unit.
const DEPTH: usize = 32;
/// Answers that are remembered, a power of two.
const KNOWN: usize = 1024;

/// A stream that was cut, with its index.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct IndexedCut {
    /// The bytes.
    pub bytes: Vec<u8>,
    /// Index of the bytes.
    pub index: Vec<u8>,
}

/// Cuts a stream by its index: [`read_index`], [`Unit::check_values`], [`cut`](crate::cut()) and
/// [`write_index`] at once. `keeps` sees the label and the markers of a unit alone, and answers the same for
/// the same ones; it may be asked once for many.
///
/// Time is linear in the records of the index and in the bytes that stay; memory is that of the output, its
/// index and 24 bytes for each stretch that stays.
///
/// # Errors
/// As those four, which tell what is wrong of a stream or index that does not fit.
pub fn cut_by_index(
    stream: &[u8],
    index: &[u8],
    keeps: impl Fn(&Unit) -> bool,
) -> Result<IndexedCut, StreamError> {
    if let Some(made) = plain(stream, index, &keeps) {
        return Ok(made);
    }
    let map = read_index(index)?;
    map.check_values(stream)?;
    let made = cut(stream, &map, |unit| keeps(&bare(unit)))?;
    Ok(IndexedCut {
        index: write_index(&made.unit),
        bytes: made.bytes,
    })
}

/// Label and markers of a unit.
fn bare(unit: &Unit) -> Unit {
    Unit {
        label: unit.label.clone(),
        markers: unit.markers.clone(),
        ..Unit::of_bytes("", 0..0)
    }
}

/// The cut of a stream of whole bytes whose fields are lengths; `None` for another one, or a fault.
fn plain(stream: &[u8], index: &[u8], keeps: &dyn Fn(&Unit) -> bool) -> Option<IndexedCut> {
    let records = IndexRecords::of(index)?;
    let mut cutter = Cutter {
        stream,
        answers: Answers::new(&records, keeps),
        names: NewNames::new(records.names.len()),
        records: &records,
        open: Vec::with_capacity(DEPTH + 1),
        runs: Vec::new(),
        copied: 0,
        last: 0..0,
        lengths: Vec::new(),
        index: vec![0; HEAD],
        markers: Vec::new(),
        fields: Vec::new(),
    };
    let (mut markers, mut fields) = (records.markers, records.fields);
    let (units, rest) = records.units.as_chunks::<UNIT>();
    if units.is_empty() || !rest.is_empty() {
        return None;
    }
    for record in units {
        let unit = unit(record)?;
        let own_markers = markers.split_off(..unit.markers.checked_mul(MARKER)?)?;
        let own_fields = fields.split_off(..unit.fields.checked_mul(FIELD)?)?;
        cutter.unit(&unit, own_markers, own_fields)?;
    }
    if !markers.is_empty() || !fields.is_empty() {
        return None;
    }
    cutter.close(0)?;
    cutter.finish()
}

/// A unit whose parts are being read.
struct Open {
    /// The first byte that is in none of its parts so far, and its end.
    at: u64,
    end: u64,
    /// Where it lies in the output; `None` if it is left out.
    kept: Option<Kept>,
}

struct Kept {
    /// Its record.
    record: usize,
    /// The bit of the stream after its fields, which lie before its first part.
    fields_end: u64,
    /// Its first byte in the stream and in the output.
    start: [u64; 2],
    /// Its first field in those of the output, and how many there are.
    fields: Range<usize>,
}

struct Cutter<'a> {
    stream: &'a [u8],
    records: &'a IndexRecords<'a>,
    answers: Answers<'a>,
    names: NewNames<'a>,
    open: Vec<Open>,
    /// Bytes of the stream that stay, those side by side at once, but the last ones; and how many.
    runs: Vec<Range<usize>>,
    copied: usize,
    last: Range<usize>,
    /// Numbers that are written when the bytes are there, by the first byte of their record.
    lengths: Vec<usize>,
    /// The new index: room for its head, and the units.
    index: Vec<u8>,
    markers: Vec<u8>,
    fields: Vec<u8>,
}

impl<'a> Cutter<'a> {
    fn unit(&mut self, unit: &UnitRecord, markers: &'a [u8], fields: &'a [u8]) -> Option<()> {
        let depth = usize::from(unit.depth);
        if depth > self.open.len() || depth > DEPTH || (depth == 0) != self.open.is_empty() {
            return None;
        }
        self.close(depth)?;
        let is_kept = match self.open.last_mut() {
            None => unit.end <= self.stream.len() as u64,
            Some(parent) => {
                if unit.start < parent.at || unit.end > parent.end {
                    return None;
                }
                let before = parent.at..unit.start;
                parent.at = unit.end;
                let is_asked = match &parent.kept {
                    Some(kept) if kept.fields_end > 8 * unit.start => return None,
                    kept => kept.is_some(),
                };
                if is_asked {
                    self.copy(before)?;
                }
                self.answers.keeps(unit.label, markers)? && is_asked
            }
        };
        if unit.end < unit.start || (depth == 0 && !is_kept) {
            return None;
        }
        self.check(unit, fields)?;
        let kept = match is_kept {
            true => Some(self.keep(unit, markers, fields)?),
            false => None,
        };
        self.open.push(Open {
            at: unit.start,
            end: unit.end,
            kept,
        });
        Some(())
    }

    /// Checks fields of a unit by the stream.
    fn check(&self, unit: &UnitRecord, fields: &[u8]) -> Option<()> {
        for record in fields.as_chunks::<FIELD>().0 {
            let field = length(record)?;
            let [start, end] = field.bits;
            let is_within = start >= 8 * unit.start && end <= unit.end.checked_mul(8)?;
            self.records.names.get(usize::from(field.name))?;
            field.coding.check(&field.range(), field.value).ok()?;
            let found = field.coding.read(self.stream, &field.range()).ok()?;
            if !is_within || found != field.value {
                return None;
            }
        }
        Some(())
    }

    /// Writes the records of a unit that stays; its end and the values of its fields follow.
    fn keep(&mut self, unit: &UnitRecord, markers: &[u8], fields: &[u8]) -> Option<Kept> {
        let lengths = fields.as_chunks::<FIELD>().0.iter().map(length);
        let ends = lengths.map(|field| field.map(|field| field.bits[1]));
        let kept = Kept {
            record: self.index.len(),
            fields_end: ends.max().flatten().unwrap_or(0),
            start: [unit.start, self.at()],
            fields: self.fields.len()..self.fields.len() + fields.len(),
        };
        let mut record = [0; UNIT];
        record[..8].copy_from_slice(&(8 * kept.start[1]).to_le_bytes());
        record[16..20].copy_from_slice(&(unit.markers as u32).to_le_bytes());
        record[20..24].copy_from_slice(&(unit.fields as u32).to_le_bytes());
        // The form numbers names as they occur: label, markers, fields.
        let label = self.names.of(self.records, unit.label)?;
        record[24..26].copy_from_slice(&label.to_le_bytes());
        record[26..28].copy_from_slice(&unit.depth.to_le_bytes());
        self.index.extend_from_slice(&record);
        for marker in markers.as_chunks::<MARKER>().0 {
            let [a, b, _, _, value @ ..] = *marker;
            let [c, d] = self
                .names
                .of(self.records, u16::from_le_bytes([a, b]))?
                .to_le_bytes();
            let [v, w, x, y] = value;
            self.markers.extend_from_slice(&[c, d, 0, 0, v, w, x, y]);
        }
        for field in fields.as_chunks::<FIELD>().0 {
            let name = self.names.of(self.records, length(field)?.name)?;
            let mut record = [0; FIELD];
            record[..20].copy_from_slice(&field[..20]);
            record[19] = 0;
            record[20..22].copy_from_slice(&name.to_le_bytes());
            self.fields.extend_from_slice(&record);
        }
        Some(kept)
    }

    /// Ends units until `depth` are left.
    fn close(&mut self, depth: usize) -> Option<()> {
        while self.open.len() > depth
            && let Some(open) = self.open.pop()
        {
            let Some(kept) = open.kept else { continue };
            self.copy(open.at..open.end)?;
            let end = self.at();
            let record = &mut self.index[kept.record..kept.record + UNIT];
            record[8..16].copy_from_slice(&(8 * end).to_le_bytes());
            if !kept.fields.is_empty() {
                self.set_lengths(&kept, end)?;
            }
        }
        Some(())
    }

    /// Moves the fields of a unit that ends at a byte of the output, and sets their values.
    fn set_lengths(&mut self, kept: &Kept, end: u64) -> Option<()> {
        for at in kept.fields.clone().step_by(FIELD) {
            let (record, _) = self.fields[at..].split_first_chunk_mut::<FIELD>()?;
            let field = length(record)?;
            let [from, to] = field.bits.map(|bit| bit - 8 * kept.start[0]);
            let bits = 8 * kept.start[1] + from..8 * kept.start[1] + to;
            let value = (8 * end - bits.end) / 8;
            record[..8].copy_from_slice(&bits.start.to_le_bytes());
            record[8..16].copy_from_slice(&value.to_le_bytes());
            self.lengths.push(at);
        }
        Some(())
    }

    /// Keeps bytes of the stream.
    fn copy(&mut self, bytes: Range<u64>) -> Option<()> {
        let bytes = usize::try_from(bytes.start).ok()?..usize::try_from(bytes.end).ok()?;
        if self.last.end != bytes.start {
            self.end_run();
            self.last.start = bytes.start;
        }
        self.last.end = bytes.end;
        Some(())
    }

    fn end_run(&mut self) {
        if !self.last.is_empty() {
            self.copied += self.last.len();
            self.runs.push(self.last.clone());
        }
    }

    /// Number of bytes of the output so far.
    fn at(&self) -> u64 {
        (self.copied + self.last.len()) as u64
    }

    fn finish(mut self) -> Option<IndexedCut> {
        self.end_run();
        let mut bytes = Vec::with_capacity(self.copied);
        for run in &self.runs {
            bytes.extend_from_slice(self.stream.get(run.clone())?);
        }
        for at in &self.lengths {
            let (record, _) = self.fields[*at..].split_first_chunk::<FIELD>()?;
            let field: LengthRecord = length(record)?;
            let written = field.coding.write(&mut bytes, &field.range(), field.value);
            written.ok()?;
        }
        let records = [
            self.index.len() - HEAD,
            self.markers.len(),
            self.fields.len(),
        ];
        let head = head(self.names.new.len(), records);
        self.index[..HEAD].copy_from_slice(&head);
        self.index.extend_from_slice(&self.markers);
        self.index.extend_from_slice(&self.fields);
        names_bytes(&self.names.new, &mut self.index);
        Some(IndexedCut {
            bytes,
            index: self.index,
        })
    }
}

/// What was answered for labels and markers.
struct Answers<'a> {
    records: &'a IndexRecords<'a>,
    keeps: &'a dyn Fn(&Unit) -> bool,
    known: Vec<Option<(u16, &'a [u8], bool)>>,
}

impl<'a> Answers<'a> {
    fn new(records: &'a IndexRecords<'a>, keeps: &'a dyn Fn(&Unit) -> bool) -> Self {
        Self {
            records,
            keeps,
            known: vec![None; KNOWN],
        }
    }

    /// Whether units with a label and the bytes of their markers stay.
    fn keeps(&mut self, label: u16, markers: &'a [u8]) -> Option<bool> {
        let (words, _) = markers.as_chunks::<MARKER>();
        let mixed = words.iter().fold(u64::from(label), |mixed, word| {
            (mixed ^ u64::from_le_bytes(*word)).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        });
        let slot = (mixed >> 32) as usize % KNOWN;
        if let Some((of, known, answer)) = self.known[slot]
            && of == label
            && known == markers
        {
            return Some(answer);
        }
        let marker = |word: &[u8; MARKER]| {
            let [a, b, _, _, value @ ..] = *word;
            Some(Marker {
                scheme: self.records.name(u16::from_le_bytes([a, b]))?,
                value: u32::from_le_bytes(value),
            })
        };
        let unit = Unit {
            markers: words.iter().map(marker).collect::<Option<_>>()?,
            ..Unit::of_bytes(self.records.name(label)?, 0..0)
        };
        let answer = (self.keeps)(&unit);
        self.known[slot] = Some((label, markers, answer));
        Some(answer)
    }
}

/// The names that the output uses, in the order in which they occur.
struct NewNames<'a> {
    new: Vec<&'a str>,
    /// For each name of the index its new number.
    numbers: Vec<Option<u16>>,
    by_name: BTreeMap<&'a str, u16>,
}

impl<'a> NewNames<'a> {
    fn new(count: usize) -> Self {
        Self {
            new: Vec::new(),
            numbers: vec![None; count],
            by_name: BTreeMap::new(),
        }
    }

    fn of(&mut self, records: &IndexRecords<'a>, number: u16) -> Option<u16> {
        let known = self.numbers.get_mut(usize::from(number))?;
        if let Some(known) = known {
            return Some(*known);
        }
        let name = *records.names.get(usize::from(number))?;
        let next = u16::try_from(self.new.len()).ok()?;
        let new = *self.by_name.entry(name).or_insert(next);
        if new == next {
            self.new.push(name);
        }
        *known = Some(new);
        Some(new)
    }
}

#[cfg(test)]
mod tests;
