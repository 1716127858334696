//! Numbers in little-endian bytes: what our own binary tables and streams are written in.

use crate::{Limits, ReadError};

/// Appends a number, 7 bits a byte, the lowest first.
pub(crate) fn varint(out: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        out.push((value & 0x7f) as u8 | 0x80);
        value >>= 7;
    }
    out.push((value & 0x7f) as u8);
}

/// Bytes that are read from the start to the end.
pub(crate) struct Bytes<'a> {
    pub(crate) bytes: &'a [u8],
    pub(crate) at: usize,
}

impl<'a> Bytes<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    pub(crate) fn bad(&self, what: impl Into<String>) -> ReadError {
        ReadError::malformed(format!("byte {}", self.at), what)
    }

    pub(crate) fn take<const N: usize>(&mut self) -> Result<[u8; N], ReadError> {
        let found = self
            .bytes
            .get(self.at..)
            .and_then(|rest| rest.first_chunk::<N>());
        let found =
            *found.ok_or_else(|| self.bad(format!("the end, {N} more bytes are expected")))?;
        self.at += N;
        Ok(found)
    }

    pub(crate) fn u32(&mut self) -> Result<u32, ReadError> {
        self.take().map(u32::from_le_bytes)
    }

    pub(crate) fn u64(&mut self) -> Result<u64, ReadError> {
        self.take().map(u64::from_le_bytes)
    }

    pub(crate) fn positive(&mut self, what: &str) -> Result<f32, ReadError> {
        let value = f32::from_le_bytes(self.take()?);
        if value.is_finite() && value > 0.0 {
            return Ok(value);
        }
        Err(self.bad(format!("{value} where {what} above 0 is expected")))
    }

    pub(crate) fn varint(&mut self) -> Result<u64, ReadError> {
        let mut value = 0u64;
        for shift in (0..35).step_by(7) {
            let [byte] = self.take::<1>()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Ok(value);
            }
        }
        Err(self.bad("a number of more than 35 bits"))
    }

    pub(crate) fn count(&mut self, which: &'static str, limit: usize) -> Result<usize, ReadError> {
        let at = format!("byte {}", self.at);
        let count = self.varint()?;
        Limits::check(&at, which, count, limit as u64)?;
        Ok(count as usize)
    }

    pub(crate) fn end(&self) -> Result<(), ReadError> {
        if self.at == self.bytes.len() {
            return Ok(());
        }
        Err(self.bad(format!("{} bytes too many", self.bytes.len() - self.at)))
    }
}
