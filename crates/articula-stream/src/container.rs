//! The file of an ABP-1 or AFP-1 stream: four letters, a JSON head and access units, each after its
//! length.
//!
//! Form: `docs/formats/abp1.md`, part 2. Numbers are big endian.

use crate::coding::Coding;
use crate::error::StreamError;
use crate::limits::StreamLimits;
use crate::unit::{Field, Meaning, Unit};
use articula_core::ByteReader;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::ops::Range;

/// Bytes of a length.
const LENGTH: usize = 4;
/// The only version of both heads.
pub(crate) const VERSION: u32 = 1;

/// A file split in its parts.
#[derive(Debug)]
pub(crate) struct Container<H> {
    pub(crate) head: H,
    /// Bytes before the first access unit.
    head_bytes: usize,
    /// Bytes of the access units, without their lengths.
    pub(crate) access_units: Vec<Range<usize>>,
}

impl<H: DeserializeOwned> Container<H> {
    /// Splits a file.
    pub(crate) fn read(
        bytes: &[u8],
        magic: [u8; 4],
        limits: &StreamLimits,
    ) -> Result<Self, StreamError> {
        StreamLimits::check("byte 0", "bytes", bytes.len() as u64, limits.bytes)?;
        let mut reader = ByteReader::new(bytes);
        if reader.take()? != magic {
            let what = format!("expected \"{}\"", magic.escape_ascii());
            return Err(StreamError::malformed("byte 0", what));
        }
        let length = u32::from_be_bytes(reader.take()?) as usize;
        let json = reader.slice(length)?;
        let head = serde_json::from_slice(json)
            .map_err(|e| StreamError::malformed("head", e.to_string()))?;
        let head_bytes = reader.at();
        let mut access_units = Vec::new();
        while reader.left() > 0 {
            let length = u32::from_be_bytes(reader.take()?) as usize;
            let start = reader.at();
            reader.slice(length)?;
            access_units.push(start..reader.at());
        }
        Ok(Self {
            head,
            head_bytes,
            access_units,
        })
    }
}

impl<H> Container<H> {
    /// Returns the map of the file from those of its access units, whose fields and parts are
    /// `inner`.
    pub(crate) fn map(
        &self,
        label: &'static str,
        inner: impl IntoIterator<Item = (Vec<Field>, Vec<Unit>)>,
    ) -> Unit {
        let mut children = vec![Unit::of_bytes("Head", 0..self.head_bytes)];
        let mut end = self.head_bytes;
        for (i, (bytes, (fields, parts))) in self.access_units.iter().zip(inner).enumerate() {
            let length = Field {
                name: "length".into(),
                bits: 8 * (bytes.start - LENGTH) as u64..8 * bytes.start as u64,
                value: bytes.len() as u64,
                coding: Coding::BigEndian,
                meaning: Meaning::BytesAfter,
            };
            let unit = Unit::of_bytes("AccessUnit", bytes.start - LENGTH..bytes.end);
            children.push(Unit {
                fields: [vec![length], fields].concat(),
                children: parts,
                ..unit.marked("access_unit", i as u32)
            });
            end = bytes.end;
        }
        Unit {
            children,
            ..Unit::of_bytes(label, 0..end)
        }
    }
}

/// Writes a file.
pub(crate) fn write(magic: [u8; 4], head: &impl Serialize, access_units: &[Vec<u8>]) -> Vec<u8> {
    let mut out = magic.to_vec();
    // Heads are structures of text and finite numbers, which cannot fail.
    let json = serde_json::to_vec(head).unwrap_or_default();
    for part in std::iter::once(&json).chain(access_units) {
        out.extend((part.len() as u32).to_be_bytes());
        out.extend(part);
    }
    out
}

/// Checks the version of a head.
pub(crate) fn check_version(version: u32) -> Result<(), StreamError> {
    if version == VERSION {
        return Ok(());
    }
    Err(StreamError::Unsupported {
        at: "head".into(),
        what: format!("version {version}"),
        mend: format!("expected version {VERSION}"),
    })
}
