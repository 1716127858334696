//! How a unit lies in the head or in an access unit: its number, its length, its body and a checksum.
//!
//! Form: `docs/formats/abp2.md`, part 2.

use articula_core::{ByteReader, MalformedBytes, push_varint};
use crc::{CRC_8_AUTOSAR, Crc};
use std::ops::Range;

/// The version that is written.
pub(super) const VERSION: u8 = 2;
/// The version before, which has no checksums; it is read.
pub(super) const VERSION_WITHOUT_CHECKSUMS: u8 = 1;
/// Greatest number of bytes of a variable-length number.
const VARINT: usize = 5;

/// Checksum of a unit.
static CHECKSUM: Crc<u8> = Crc::<u8>::new(&CRC_8_AUTOSAR);

/// The form of the units of the head, or of an access unit.
#[derive(Debug, Clone, Copy)]
pub(super) struct UnitForm {
    pub(super) version: u8,
    /// Their numbers are below this.
    pub(super) count: usize,
    /// 0 in the head, one more than its number in an access unit.
    pub(super) place: u32,
}

/// A unit that was found; bytes are counted from the start of the reader.
#[derive(Debug)]
pub(super) struct UnitBytes {
    pub(super) number: usize,
    /// All its bytes.
    pub(super) bytes: Range<usize>,
    pub(super) body: Range<usize>,
}

/// Why a unit cannot be read.
#[derive(Debug)]
pub(super) enum UnitFault {
    /// The bytes end within it.
    Early(MalformedBytes),
    /// It is not what was written.
    Damaged(MalformedBytes),
}

impl UnitFault {
    /// The fault where no more bytes can follow.
    pub(super) fn of_whole(self) -> MalformedBytes {
        match self {
            Self::Early(fault) | Self::Damaged(fault) => fault,
        }
    }
}

impl UnitForm {
    /// Reads the next unit.
    pub(super) fn read(self, reader: &mut ByteReader<'_>) -> Result<UnitBytes, UnitFault> {
        let whole = reader.clone();
        let start = reader.at();
        let (number, length) = self.header(reader)?;
        let body = reader.at();
        let checksum = if self.version == VERSION { 1 } else { 0 };
        let Ok(after) = reader.slice(length.saturating_add(checksum)) else {
            let what = format!(
                "unit {number} of {length} bytes, {} are left",
                reader.left()
            );
            return Err(UnitFault::Early(at(start, what)));
        };
        let end = body + length;
        if let Some(found) = after.get(length) {
            let expected = self.checksum(whole, end - start);
            if *found != expected {
                let what = format!(
                    "the checksum of unit {number} is {found:#04x}, expected {expected:#04x}"
                );
                return Err(UnitFault::Damaged(at(start, what)));
            }
        }
        if number >= self.count {
            let what = format!("unit {number}, expected less than {}", self.count);
            return Err(UnitFault::Damaged(at(start, what)));
        }
        Ok(UnitBytes {
            number,
            bytes: start..reader.at(),
            body: body..end,
        })
    }

    /// Number and length of the next unit.
    fn header(self, reader: &mut ByteReader<'_>) -> Result<(usize, usize), UnitFault> {
        let mut varint = || {
            let is_too_long = reader.left() >= VARINT;
            reader.varint().map_err(|fault| match is_too_long {
                true => UnitFault::Damaged(fault),
                false => UnitFault::Early(fault),
            })
        };
        let first = varint()? as usize;
        if self.version == VERSION_WITHOUT_CHECKSUMS {
            return Ok((first, varint()? as usize));
        }
        Ok((first % self.count, first / self.count))
    }

    /// The checksum of the next bytes as a unit without one.
    fn checksum(self, mut reader: ByteReader<'_>, bytes: usize) -> u8 {
        let mut digest = CHECKSUM.digest();
        digest.update(&self.place.to_be_bytes());
        digest.update(reader.slice(bytes).unwrap_or_default());
        digest.finalize()
    }

    /// Appends a unit in the form of [`VERSION`].
    pub(super) fn write(self, out: &mut Vec<u8>, number: usize, body: &[u8]) {
        let start = out.len();
        push_varint(out, (body.len() * self.count + number) as u64);
        out.extend(body);
        let checksum = self.checksum(ByteReader::new(&out[start..]), out.len() - start);
        out.push(checksum);
    }
}

fn at(at: usize, what: String) -> MalformedBytes {
    MalformedBytes { at, what }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_checksum_is_the_one_of_the_catalogue() {
        // The check values of the CRC catalogue (reveng) are those of these nine characters.
        assert_eq!(CHECKSUM.checksum(b"123456789"), 0xdf);
    }

    fn units(form: UnitForm, bodies: &[Vec<u8>]) -> Vec<u8> {
        let mut out = Vec::new();
        for (number, body) in bodies.iter().enumerate() {
            form.write(&mut out, number, body);
        }
        out
    }

    fn read(form: UnitForm, bytes: &[u8]) -> Result<Vec<(usize, Vec<u8>)>, UnitFault> {
        let mut reader = ByteReader::new(bytes);
        let mut found = Vec::new();
        while reader.left() > 0 {
            let unit = form.read(&mut reader)?;
            found.push((unit.number, bytes[unit.body].to_vec()));
        }
        Ok(found)
    }

    proptest! {
        #[test]
        fn units_come_back_and_a_changed_byte_never_reads_as_before(
            bodies in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..40), 1..6),
            place in any::<u32>(),
            at in any::<prop::sample::Index>(),
            change in 1..=255_u8,
        ) {
            let form = UnitForm { version: VERSION, count: bodies.len(), place };
            let bytes = units(form, &bodies);
            let expected: Vec<_> = bodies.into_iter().enumerate().collect();
            prop_assert_eq!(read(form, &bytes).unwrap(), expected.clone());
            // Where a number or a length is another one, other bytes are taken for the checksum, which
            // fits by chance in one of 256 cases; such bytes still do not read as what they were.
            let mut other = bytes.clone();
            other[at.index(bytes.len())] ^= change;
            prop_assert!(read(form, &other).map_or(true, |found| found != expected));
            let elsewhere = UnitForm { place: place ^ u32::from(change), ..form };
            prop_assert!(read(elsewhere, &bytes).is_err());
        }
    }

    #[test]
    fn every_changed_byte_of_a_body_is_found() {
        let form = UnitForm {
            version: VERSION,
            count: 30,
            place: 3,
        };
        let mut unit = Vec::new();
        form.write(&mut unit, 7, &[0x5a; 200]);
        assert_eq!(unit.len(), 2 + 200 + 1);
        for at in 2..unit.len() {
            for change in 1..=255 {
                let mut other = unit.clone();
                other[at] ^= change;
                let read = form.read(&mut ByteReader::new(&other));
                assert!(matches!(read, Err(UnitFault::Damaged(_))));
            }
        }
    }
}
