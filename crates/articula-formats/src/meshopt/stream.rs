//! Cursor over encoded bytes, up to the tail.

use crate::error::ReadError;

/// A cursor over the part of an encoded view between header and tail.
#[derive(Debug)]
pub(super) struct Stream<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Stream<'a> {
    /// Splits an encoded view into its header byte, the cursor, and its tail.
    pub(super) fn open(
        bytes: &'a [u8],
        tail: impl Fn(u8) -> usize,
    ) -> Result<(u8, Self, &'a [u8]), ReadError> {
        let header = *bytes
            .first()
            .ok_or_else(|| ReadError::malformed("byte 0", "the stream is empty"))?;
        let tail = tail(header);
        let end = bytes.len().checked_sub(tail).filter(|end| *end >= 1);
        let Some(end) = end else {
            let what = format!(
                "{} bytes are too short; header and tail take {}",
                bytes.len(),
                tail + 1
            );
            return Err(ReadError::malformed("byte 0", what));
        };
        let stream = Self {
            bytes: &bytes[..end],
            at: 1,
        };
        Ok((header, stream, &bytes[end..]))
    }

    /// Returns the next `count` bytes.
    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8], ReadError> {
        let rest = &self.bytes[self.at..];
        let Some(taken) = rest.get(..count) else {
            let what = format!(
                "unexpected end: {count} bytes are needed, {} are left",
                rest.len()
            );
            return Err(self.fault(what));
        };
        self.at += count;
        Ok(taken)
    }

    pub(super) fn byte(&mut self) -> Result<u8, ReadError> {
        Ok(self.take(1)?[0])
    }

    /// Reads a number in groups of seven bits, the lowest first (LEB128); at most five bytes.
    pub(super) fn varint(&mut self) -> Result<u32, ReadError> {
        let mut value = 0u32;
        for group in 0..5 {
            let byte = self.byte()?;
            // Only four bits of the fifth group fit; the others are ignored, as the specification
            // states.
            value |= u32::from(byte & 0x7f) << (group * 7);
            if byte < 0x80 {
                return Ok(value);
            }
        }
        Err(self.fault("a variable-length integer exceeds five bytes"))
    }

    /// Returns an error if bytes are left.
    pub(super) fn finish(&self) -> Result<(), ReadError> {
        match self.bytes.len() - self.at {
            0 => Ok(()),
            left => Err(self.fault(format!("{left} unexpected bytes at the end"))),
        }
    }

    /// Creates an error at the current position.
    pub(super) fn fault(&self, what: impl Into<String>) -> ReadError {
        ReadError::malformed(format!("byte {}", self.at), what)
    }
}

/// Decodes a zigzag code: 0, 1, 2, 3 … to 0, -1, 1, -2 …
pub(super) fn signed(code: u32) -> u32 {
    (code >> 1) ^ (code & 1).wrapping_neg()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(bytes: &[u8]) -> Result<u32, ReadError> {
        let file = [&[0], bytes].concat();
        let (_, mut stream, _) = Stream::open(&file, |_| 0)?;
        let number = stream.varint()?;
        stream.finish()?;
        Ok(number)
    }

    #[test]
    fn numbers_in_groups_of_seven_bits() {
        assert_eq!(number(&[0x7f]), Ok(0x7f));
        assert_eq!(number(&[0x81, 0x04]), Ok(0x201));
        // The specification's third example has the groups in reverse order; this was computed by
        // hand.
        assert_eq!(number(&[0xff, 0xa0, 0x05]), Ok(0x7f | 0x20 << 7 | 5 << 14));
        assert_eq!(number(&[0xff, 0xff, 0xff, 0xff, 0x7f]), Ok(u32::MAX));
        assert!(number(&[0xff, 0xff, 0xff, 0xff, 0xff, 0x00]).is_err());
        assert!(number(&[0x80]).is_err());
        let left = number(&[1, 2]).unwrap_err().to_string();
        assert_eq!(left, "byte 2: 1 unexpected bytes at the end");
    }

    #[test]
    fn zigzag() {
        let by_hand = [0, -1, 1, -2, 2i32];
        for (code, wanted) in (0..).zip(by_hand) {
            assert_eq!(signed(code) as i32, wanted);
        }
        assert_eq!(signed(u32::MAX) as i32, i32::MIN);
    }
}
