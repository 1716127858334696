//! The map of a stream as bytes: fixed-size records, so that a cut needs neither codec nor parser.
//!
//! The form is described in `docs/formats/stream-index.md`.

use crate::coding::Coding;
use crate::error::StreamError;
use crate::unit::{Field, Marker, Meaning, Unit};
use articula_core::ByteReader;
use std::borrow::Cow;
use std::collections::BTreeMap;

pub(crate) const MAGIC: [u8; 4] = *b"AUIX";
pub(crate) const VERSION: u32 = 1;
pub(crate) const UNIT: usize = 32;
pub(crate) const MARKER: usize = 8;
pub(crate) const FIELD: usize = 32;
/// Greatest depth of a map that is read.
const DEPTH: usize = 32;
pub(crate) const PADDING: u32 = 1;
/// Names of the units and markers of our codecs that are frequent: each takes no memory of its own.
const FREQUENT: &[&str] = &[
    "unit",
    "access_unit",
    "frames",
    "au_bytes",
    "BoneMask",
    "BoneValue",
    "FapMask",
    "FapValue",
    "chunk",
    "length",
    "loa",
    "region",
    "joint",
    "tier",
    "parameter",
    "face_loa",
    "face_region",
    "level",
    "object",
    "mesh",
];

/// Writes a map as an index.
///
/// # Panics
/// If the map has more than 65,535 different names or a depth above 65,535; no stream of this crate
/// has.
pub fn write_index(map: &Unit) -> Vec<u8> {
    let mut tables = Tables::default();
    tables.unit(map, 0);
    let records = [&tables.units, &tables.markers, &tables.fields];
    let mut out = head(tables.names.len(), records.map(Vec::len)).to_vec();
    out.extend(records.map(Vec::as_slice).concat());
    names_bytes(&tables.names, &mut out);
    out
}

/// Bytes of the head.
pub(crate) const HEAD: usize = 24;

/// The head of an index with so many names, and bytes of units, markers and fields.
pub(crate) fn head(names: usize, [units, markers, fields]: [usize; 3]) -> [u8; HEAD] {
    let counts = [names, units / UNIT, markers / MARKER, fields / FIELD];
    let mut head = [0; HEAD];
    head[..4].copy_from_slice(&MAGIC);
    head[4..8].copy_from_slice(&VERSION.to_le_bytes());
    for (place, count) in head[8..].as_chunks_mut().0.iter_mut().zip(counts) {
        *place = (count as u32).to_le_bytes();
    }
    head
}

/// Appends the names of an index.
pub(crate) fn names_bytes(names: &[&str], out: &mut Vec<u8>) {
    for name in names {
        out.extend((name.len() as u16).to_le_bytes());
        out.extend(name.as_bytes());
    }
}

/// A name: a frequent one takes no memory.
pub(crate) fn known_name(text: &str) -> Cow<'static, str> {
    let known = FREQUENT.iter().find(|name| **name == text);
    known.map_or_else(|| Cow::Owned(text.to_owned()), |name| Cow::Borrowed(*name))
}

#[derive(Default)]
struct Tables<'a> {
    numbers: BTreeMap<&'a str, u16>,
    names: Vec<&'a str>,
    units: Vec<u8>,
    markers: Vec<u8>,
    fields: Vec<u8>,
}

impl<'a> Tables<'a> {
    fn name(&mut self, name: &'a str) -> [u8; 2] {
        // Names are read back whole or not at all: no stream of this crate has a longer one.
        let name = name.get(..usize::from(u16::MAX)).unwrap_or(name);
        let names = &mut self.names;
        let number = *self.numbers.entry(name).or_insert_with(|| {
            names.push(name);
            u16::try_from(names.len() - 1).expect("at most 65,535 names")
        });
        number.to_le_bytes()
    }

    fn unit(&mut self, unit: &'a Unit, depth: u16) {
        let label = self.name(&unit.label);
        self.units.extend(unit.bits.start.to_le_bytes());
        self.units.extend(unit.bits.end.to_le_bytes());
        let counts = [unit.markers.len(), unit.fields.len()];
        self.units
            .extend(counts.map(|n| (n as u32).to_le_bytes()).concat());
        self.units.extend(label);
        self.units.extend(depth.to_le_bytes());
        let flags = if unit.padding { PADDING } else { 0 };
        self.units.extend(flags.to_le_bytes());
        for marker in &unit.markers {
            let scheme = self.name(&marker.scheme);
            self.markers.extend(scheme);
            self.markers.extend([0; 2]);
            self.markers.extend(marker.value.to_le_bytes());
        }
        for field in &unit.fields {
            self.field(field);
        }
        for child in &unit.children {
            self.unit(child, depth.checked_add(1).expect("depth below 65,536"));
        }
    }

    fn field(&mut self, field: &'a Field) {
        let name = self.name(&field.name);
        let coding = match field.coding {
            Coding::BigEndian => 0,
            Coding::LittleEndian => 1,
            Coding::Varint => 2,
        };
        let (meaning, label, number) = match &field.meaning {
            Meaning::BytesAfter => (0, [0; 2], 0),
            Meaning::BytesOf(number) => (1, [0; 2], *number),
            Meaning::CountOf(label) => (2, self.name(label), 0),
        };
        self.fields.extend(field.bits.start.to_le_bytes());
        self.fields.extend(field.value.to_le_bytes());
        let bits = (field.bits.end - field.bits.start) as u8;
        self.fields.extend([bits, coding, meaning, 0]);
        self.fields.extend(name);
        self.fields.extend(label);
        self.fields.extend(number.to_le_bytes());
        self.fields.extend([0; 4]);
    }
}

/// Reads an index.
///
/// Memory is at most a few times the bytes.
///
/// # Errors
/// A [`StreamError`] that names the byte, for another magic or version, a wrong length, an unknown
/// number or name, a depth that rises by more than 1 or above 32, or a map that contradicts itself
/// ([`Unit::check`]).
pub fn read_index(bytes: &[u8]) -> Result<Unit, StreamError> {
    let mut reader = ByteReader::new(bytes);
    if reader.take()? != MAGIC {
        return Err(StreamError::malformed("byte 0", "expected an index, AUIX"));
    }
    let version = reader.u32()?;
    if version != VERSION {
        return Err(StreamError::Unsupported {
            at: "byte 4".into(),
            what: format!("index version {version}"),
            mend: format!("expected version {VERSION}; write the index anew"),
        });
    }
    let mut counts = [0; 4];
    for count in &mut counts {
        *count = reader.u32()? as usize;
    }
    let [names, units, markers, fields] = counts;
    let units = records(&mut reader, units, UNIT)?;
    let markers = records(&mut reader, markers, MARKER)?;
    let fields = records(&mut reader, fields, FIELD)?;
    let names = (0..names).map(|_| {
        let length = u16::from_le_bytes(reader.take()?);
        let at = reader.at();
        let text = std::str::from_utf8(reader.slice(usize::from(length))?);
        let text =
            text.map_err(|_| StreamError::malformed(format!("byte {at}"), "expected UTF-8"))?;
        Ok(known_name(text))
    });
    let names = names.collect::<Result<Vec<_>, StreamError>>()?;
    reader.end()?;
    let mut reading = Reading {
        names: &names,
        markers,
        fields,
    };
    let map = reading.tree(units)?;
    map.check()?;
    Ok(map)
}

/// Takes `count` records of `size` bytes each.
fn records<'a>(
    reader: &mut ByteReader<'a>,
    count: usize,
    size: usize,
) -> Result<Records<'a>, StreamError> {
    let start = reader.at();
    // A count of more bytes than there are fails here, before anything is allocated.
    let bytes = reader.slice(count.saturating_mul(size).min(reader.left() + 1))?;
    let reader = ByteReader::new(bytes);
    Ok(Records { reader, start })
}

/// Records of one kind that have not been read yet.
struct Records<'a> {
    reader: ByteReader<'a>,
    start: usize,
}

impl Records<'_> {
    fn bad(&self, what: impl Into<String>) -> StreamError {
        StreamError::malformed(format!("byte {}", self.start + self.reader.at()), what)
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], StreamError> {
        self.reader
            .take()
            .map_err(|e| StreamError::malformed(format!("byte {}", self.start + e.at), e.what))
    }

    fn u16(&mut self) -> Result<u16, StreamError> {
        self.take().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Result<u32, StreamError> {
        self.take().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, StreamError> {
        self.take().map(u64::from_le_bytes)
    }
}

struct Reading<'a> {
    names: &'a [Cow<'static, str>],
    markers: Records<'a>,
    fields: Records<'a>,
}

/// The name of a number read from `records`.
fn name(
    names: &[Cow<'static, str>],
    records: &Records<'_>,
    number: u16,
) -> Result<Cow<'static, str>, StreamError> {
    let found = names.get(usize::from(number));
    let found = found
        .ok_or_else(|| records.bad(format!("name {number}, the index has {}", names.len())))?;
    Ok(found.clone())
}

impl Reading<'_> {
    fn tree(&mut self, mut units: Records<'_>) -> Result<Unit, StreamError> {
        // The units whose parts are still being read.
        let mut open: Vec<Unit> = Vec::new();
        while units.reader.left() > 0 {
            let (unit, depth) = self.unit(&mut units)?;
            if depth > open.len() || depth > DEPTH || (depth == 0) != open.is_empty() {
                return Err(units.bad(format!("a unit of depth {depth} cannot follow here")));
            }
            close(&mut open, depth);
            open.push(unit);
        }
        close(&mut open, 1);
        let whole = open.pop();
        let left = self.markers.reader.left() + self.fields.reader.left();
        if left > 0 {
            return Err(self.markers.bad("markers or fields that no unit has"));
        }
        whole.ok_or_else(|| units.bad("expected a unit"))
    }

    fn unit(&mut self, units: &mut Records<'_>) -> Result<(Unit, usize), StreamError> {
        let bits = units.u64()?..units.u64()?;
        let (markers, fields) = (units.u32()?, units.u32()?);
        let label = units.u16()?;
        let label = name(self.names, units, label)?;
        let depth = usize::from(units.u16()?);
        let flags = units.u32()?;
        if flags > PADDING {
            return Err(units.bad(format!("flags {flags}, expected 0 or {PADDING}")));
        }
        let markers = (0..markers)
            .map(|_| self.marker())
            .collect::<Result<_, _>>()?;
        let fields = (0..fields)
            .map(|_| self.field())
            .collect::<Result<_, _>>()?;
        let unit = Unit {
            label,
            bits,
            markers,
            fields,
            children: Vec::new(),
            padding: flags == PADDING,
        };
        Ok((unit, depth))
    }

    fn marker(&mut self) -> Result<Marker, StreamError> {
        let scheme = self.markers.u16()?;
        let scheme = name(self.names, &self.markers, scheme)?;
        self.markers.u16()?;
        let value = self.markers.u32()?;
        Ok(Marker { scheme, value })
    }

    fn field(&mut self) -> Result<Field, StreamError> {
        let start = self.fields.u64()?;
        let value = self.fields.u64()?;
        let [bits, coding, meaning, _] = self.fields.take()?;
        let (named, label) = (self.fields.u16()?, self.fields.u16()?);
        let number = self.fields.u32()?;
        self.fields.u32()?;
        let fields = &self.fields;
        let unknown =
            |which: &str, found: u8| fields.bad(format!("{which} {found}, expected 0 to 2"));
        let coding = match coding {
            0 => Coding::BigEndian,
            1 => Coding::LittleEndian,
            2 => Coding::Varint,
            other => return Err(unknown("coding", other)),
        };
        let meaning = match meaning {
            0 => Meaning::BytesAfter,
            1 => Meaning::BytesOf(number),
            2 => Meaning::CountOf(name(self.names, fields, label)?),
            other => return Err(unknown("meaning", other)),
        };
        let end = start.checked_add(u64::from(bits));
        let end = end.ok_or_else(|| fields.bad("bits beyond 2^64"))?;
        Ok(Field {
            name: name(self.names, fields, named)?,
            bits: start..end,
            value,
            coding,
            meaning,
        })
    }
}

/// Ends open units until `depth` are left, each becoming a part of the one before.
fn close(open: &mut Vec<Unit>, depth: usize) {
    while open.len() > depth.max(1) {
        if let Some(done) = open.pop()
            && let Some(parent) = open.last_mut()
        {
            parent.children.push(done);
        }
    }
}

#[cfg(test)]
mod tests;
