//! Encodings of numbers in a stream, so that a cut can rewrite them without the codec.

use articula_core::Mismatch;
use std::ops::Range;

/// Encoding of an unsigned number in the bits of a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Coding {
    /// 1 to 64 bits at any position, most significant bit first: MPEG's `uimsbf`.
    BigEndian,
    /// 1 to 8 whole bytes, least significant first.
    LittleEndian,
    /// 1 to 9 whole bytes of 7 bits, least significant first, bit 7 set if more follow. A number
    /// that replaces a longer one is padded to the same length, so that later bytes do not move.
    Varint,
}

impl Coding {
    /// Checks that a value fits the given bits in this encoding.
    pub(crate) fn check(self, bits: &Range<u64>, value: u64) -> Result<(), String> {
        let count = bits.end.saturating_sub(bits.start);
        let is_whole = bits.start.is_multiple_of(8) && count.is_multiple_of(8);
        let (fits, value_bits) = match self {
            Self::BigEndian => ((1..=64).contains(&count), count),
            Self::LittleEndian => (is_whole && (8..=64).contains(&count), count),
            Self::Varint => (is_whole && (8..=72).contains(&count), count / 8 * 7),
        };
        if !fits {
            return Err(format!("bits {bits:?} cannot hold a {self:?} number"));
        }
        if value_bits < 64 && value >> value_bits != 0 {
            return Err(format!("{value} does not fit in {value_bits} bits"));
        }
        Ok(())
    }

    /// Reads a number from bits of a stream.
    ///
    /// # Errors
    /// A [`Mismatch`] if the bits cannot hold a number of this encoding, or the stream ends before
    /// them.
    pub(crate) fn read(self, stream: &[u8], bits: &Range<u64>) -> Result<u64, Mismatch> {
        let wrong = |what: String| Mismatch::new(format!("bits {bits:?}"), what);
        self.check(bits, 0).map_err(wrong)?;
        let bytes = touched(bits, stream.len()).map_err(wrong)?;
        let bytes = &stream[bytes];
        match self {
            Self::BigEndian => Ok((bits.start..bits.end).fold(0, |value, bit| {
                let byte = stream[(bit / 8) as usize];
                value << 1 | u64::from(byte >> (7 - bit % 8) & 1)
            })),
            Self::LittleEndian => {
                let from_the_top = bytes.iter().rev();
                Ok(from_the_top.fold(0, |value, byte| value << 8 | u64::from(*byte)))
            }
            Self::Varint => {
                let last = bytes.len() - 1;
                if bytes.iter().position(|b| b & 0x80 == 0) != Some(last) {
                    return Err(wrong(
                        "the variable-length number does not end at the last byte".into(),
                    ));
                }
                let from_the_top = bytes.iter().rev();
                Ok(from_the_top.fold(0, |value, byte| value << 7 | u64::from(byte & 0x7f)))
            }
        }
    }

    /// Writes a number to bits of a stream; no other bit changes.
    ///
    /// # Errors
    /// A [`Mismatch`] if the value does not fit, or the stream ends before the bits. The stream is
    /// unchanged then.
    pub fn write(self, stream: &mut [u8], bits: &Range<u64>, value: u64) -> Result<(), Mismatch> {
        let wrong = |what: String| Mismatch::new(format!("bits {bits:?}"), what);
        self.check(bits, value).map_err(wrong)?;
        let bytes = touched(bits, stream.len()).map_err(wrong)?;
        match self {
            Self::BigEndian => {
                for (place, bit) in (bits.start..bits.end).rev().enumerate() {
                    let byte = &mut stream[(bit / 8) as usize];
                    let mask = 1 << (7 - bit % 8);
                    let is_set = value >> place & 1 == 1;
                    *byte = if is_set { *byte | mask } else { *byte & !mask };
                }
            }
            Self::LittleEndian => {
                for (place, byte) in stream[bytes].iter_mut().enumerate() {
                    *byte = (value >> (8 * place)) as u8;
                }
            }
            Self::Varint => {
                let last = bytes.len() - 1;
                for (place, byte) in stream[bytes].iter_mut().enumerate() {
                    let more = if place < last { 0x80 } else { 0 };
                    *byte = (value >> (7 * place)) as u8 & 0x7f | more;
                }
            }
        }
        Ok(())
    }
}

/// The bytes that contain the given bits.
fn touched(bits: &Range<u64>, length: usize) -> Result<Range<usize>, String> {
    if bits.end > 8 * length as u64 {
        return Err(format!("the stream ends at bit {}", 8 * length as u64));
    }
    Ok((bits.start / 8) as usize..bits.end.div_ceil(8) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn by_hand() {
        let mut bytes = [0xff, 0x2c, 0x01, 0xac, 0x02, 0xff];
        let read = |coding: Coding, bits| coding.read(&bytes, &bits).unwrap();
        assert_eq!(read(Coding::LittleEndian, 8..24), 300);
        assert_eq!(read(Coding::BigEndian, 8..24), 0x2c01);
        assert_eq!(read(Coding::BigEndian, 6..13), 0b11_00101);
        assert_eq!(read(Coding::Varint, 24..40), 300);
        Coding::Varint.write(&mut bytes, &(24..40), 5).unwrap();
        Coding::BigEndian.write(&mut bytes, &(7..9), 1).unwrap();
        assert_eq!(bytes, [0xfe, 0xac, 0x01, 0x85, 0x00, 0xff]);
        assert_eq!(Coding::Varint.read(&bytes, &(24..40)).unwrap(), 5);
    }

    #[test]
    fn what_cannot_stand_there() {
        let mut bytes = [0x80; 4];
        let refused = |coding: Coding, bits: Range<u64>| coding.read(&bytes, &bits).is_err();
        assert!(refused(Coding::LittleEndian, 4..12));
        assert!(refused(Coding::LittleEndian, 8..8));
        assert!(refused(Coding::LittleEndian, 24..40), "beyond the end");
        assert!(refused(Coding::BigEndian, 0..65));
        assert!(refused(Coding::Varint, 8..24), "more would follow");
        assert!(Coding::BigEndian.write(&mut bytes, &(0..3), 8).is_err());
        assert!(Coding::Varint.write(&mut bytes, &(0..8), 128).is_err());
        assert_eq!(bytes, [0x80; 4]);
    }

    proptest! {
        #[test]
        fn what_was_put_there_is_there_and_nothing_else_changed(
            before in prop::array::uniform12(any::<u8>()),
            start in 0u64..24,
            count in 1u64..64,
            value: u64,
        ) {
            for coding in [Coding::BigEndian, Coding::LittleEndian, Coding::Varint] {
                let bits = match coding {
                    Coding::BigEndian => start..start + count,
                    _ => start / 8 * 8..start / 8 * 8 + count.div_ceil(8) * 8,
                };
                let shown = if coding == Coding::Varint { bits.end - bits.start - (bits.end - bits.start) / 8 } else { bits.end - bits.start };
                let value = value & (u64::MAX >> (64 - shown));
                let mut bytes = before;
                coding.write(&mut bytes, &bits, value).unwrap();
                prop_assert_eq!(coding.read(&bytes, &bits), Ok(value));
                for bit in (0..96).filter(|b| !bits.contains(b)) {
                    let of = |bytes: &[u8]| bytes[(bit / 8) as usize] >> (7 - bit % 8) & 1;
                    prop_assert_eq!(of(&bytes), of(&before));
                }
            }
        }
    }
}
