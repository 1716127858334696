//! Little-endian numbers: the encoding of this project's binary tables and streams.
//!
//! It is part of the core because crates that do not depend on each other read and write it.
//! Readers convert [`MalformedBytes`] to the error of their own crate.

use std::fmt;

/// Appends a variable-length integer: 7 bits per byte, lowest first, bit 7 set in all bytes but the
/// last.
pub fn push_varint(out: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        out.push((value & 0x7f) as u8 | 0x80);
        value >>= 7;
    }
    out.push((value & 0x7f) as u8);
}

/// The error for bytes that do not match the expected encoding, with their offset.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MalformedBytes {
    /// Offset at which the error was found.
    pub at: usize,
    /// What was found and what was expected.
    pub what: String,
}

impl fmt::Display for MalformedBytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "byte {}: {}", self.at, self.what)
    }
}

impl std::error::Error for MalformedBytes {}

/// A reader of a byte slice from start to end.
///
/// ```
/// use articula_core::{ByteReader, push_varint};
///
/// let mut written = 7u32.to_le_bytes().to_vec();
/// push_varint(&mut written, 300);
/// let mut bytes = ByteReader::new(&written);
/// assert_eq!(bytes.u32()?, 7);
/// assert_eq!(bytes.varint()?, 300);
/// bytes.end()?;
/// # Ok::<(), articula_core::MalformedBytes>(())
/// ```
#[derive(Debug, Clone)]
pub struct ByteReader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> ByteReader<'a> {
    /// Creates a reader at the first byte.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// Returns the offset of the next byte.
    pub fn at(&self) -> usize {
        self.at
    }

    /// Returns the number of remaining bytes.
    pub fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// Returns an error at the next byte.
    pub fn bad(&self, what: impl Into<String>) -> MalformedBytes {
        MalformedBytes {
            at: self.at,
            what: what.into(),
        }
    }

    /// Reads `N` bytes.
    ///
    /// # Errors
    /// If fewer than `N` bytes remain.
    pub fn take<const N: usize>(&mut self) -> Result<[u8; N], MalformedBytes> {
        let found = self.bytes[self.at..].first_chunk::<N>();
        let found =
            *found.ok_or_else(|| self.bad(format!("unexpected end, expected {N} more bytes")))?;
        self.at += N;
        Ok(found)
    }

    /// Reads `count` bytes.
    ///
    /// # Errors
    /// If fewer than `count` bytes remain.
    pub fn slice(&mut self, count: usize) -> Result<&'a [u8], MalformedBytes> {
        let found = self.bytes[self.at..].get(..count);
        let found = found
            .ok_or_else(|| self.bad(format!("unexpected end, expected {count} more bytes")))?;
        self.at += count;
        Ok(found)
    }

    /// Reads a 32-bit number.
    ///
    /// # Errors
    /// If fewer than 4 bytes remain.
    pub fn u32(&mut self) -> Result<u32, MalformedBytes> {
        self.take().map(u32::from_le_bytes)
    }

    /// Reads a 64-bit number.
    ///
    /// # Errors
    /// If fewer than 8 bytes remain.
    pub fn u64(&mut self) -> Result<u64, MalformedBytes> {
        self.take().map(u64::from_le_bytes)
    }

    /// Reads an `f32` that is finite and above 0; `what` is its name in the error.
    ///
    /// # Errors
    /// If the number is not finite or not above 0, or fewer than 4 bytes remain.
    pub fn positive(&mut self, what: &str) -> Result<f32, MalformedBytes> {
        let value = f32::from_le_bytes(self.take()?);
        if value.is_finite() && value > 0.0 {
            return Ok(value);
        }
        Err(self.bad(format!("found {value}, expected {what} above 0")))
    }

    /// Reads an integer written by [`push_varint`], of at most 35 bits.
    ///
    /// # Errors
    /// If it has more than 35 bits, or the bytes end within it.
    pub fn varint(&mut self) -> Result<u64, MalformedBytes> {
        let mut value = 0u64;
        for shift in (0..35).step_by(7) {
            let [byte] = self.take::<1>()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Ok(value);
            }
        }
        Err(self.bad("a variable-length integer exceeds 35 bits"))
    }

    /// Checks that no bytes remain.
    ///
    /// # Errors
    /// If bytes remain.
    pub fn end(&self) -> Result<(), MalformedBytes> {
        if self.left() == 0 {
            return Ok(());
        }
        Err(self.bad(format!("{} unexpected bytes at the end", self.left())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_cut_off_too_long_or_out_of_range_names_its_place() {
        let mut long = ByteReader::new(&[0x80; 6]);
        assert_eq!(long.varint().unwrap_err().at, 5);
        assert_eq!(ByteReader::new(&[0x80]).varint().unwrap_err().at, 1);
        let mut short = ByteReader::new(&[1, 2, 3]);
        assert_eq!(short.take::<2>(), Ok([1, 2]));
        assert_eq!(short.u32().unwrap_err().at, 2);
        assert_eq!(
            short.end().unwrap_err().to_string(),
            "byte 2: 1 unexpected bytes at the end"
        );
        for value in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(ByteReader::new(&value.to_le_bytes()).positive("a").is_err());
        }
    }

    #[test]
    fn numbers_come_back() {
        for value in [0, 1, 127, 128, 16_383, 16_384, (1 << 35) - 1] {
            let mut out = Vec::new();
            push_varint(&mut out, value);
            let mut bytes = ByteReader::new(&out);
            assert_eq!((bytes.varint(), bytes.left()), (Ok(value), 0));
        }
    }
}
