//! Index sequences: differences to one of two running values.
//!
//! Source: KHR_meshopt_compression, appendix A, mode 2.

use super::stream::{Stream, signed};
use crate::error::ReadError;

/// Unused bytes at the end.
const TAIL: usize = 4;

/// Decodes `count` indices.
pub(super) fn decode(bytes: &[u8], count: usize) -> Result<Vec<u32>, ReadError> {
    let (header, mut stream, _) = Stream::open(bytes, |_| TAIL)?;
    if header != 0xd1 {
        let what = format!("header {header:#04x}, expected 0xd1");
        return Err(ReadError::malformed("byte 0", what));
    }
    let mut last = [0u32; 2];
    let mut out = Vec::new();
    for _ in 0..count {
        let code = stream.varint()?;
        let last = &mut last[(code & 1) as usize];
        *last = last.wrapping_add(signed(code >> 1));
        out.push(*last);
    }
    stream.finish()?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_running_values_by_hand() {
        // +1 and +2 on the first, -1 on the second, +1 on the first.
        let bytes = [0xd1, 0b0100, 0b1000, 0b0011, 0b0100, 0, 0, 0, 0];
        assert_eq!(decode(&bytes, 4), Ok(vec![1, 3, u32::MAX, 4]));
        let said = |bytes: &[u8], count| decode(bytes, count).unwrap_err().to_string();
        assert!(said(&bytes, 3).contains("1 unexpected bytes"));
        assert!(said(&bytes, 5).starts_with("byte 5: unexpected end: 1 bytes are needed"));
        assert!(said(&[0xd2, 0, 0, 0, 0], 0).contains("expected 0xd1"));
        assert!(said(&bytes[..4], 0).contains("header and tail"));
    }
}
