//! Codes of whole numbers without a model: Exp-Golomb and Rice.
//!
//! Sources: S. Golomb, "Run-length encodings", 1966; R. Rice, "Some practical universal noiseless
//! coding techniques", 1979; J. Teuhola, "A compression method for clustered bit-vectors", 1978
//! (Exp-Golomb). Form: `docs/formats/abp1.md`, part 5.

use crate::bits::{BitReader, BitWriter};
use crate::error::StreamError;

/// Order of the Exp-Golomb codes of this crate.
const ORDER: u32 = 8;
/// Greatest number of zeros before an Exp-Golomb code; numbers of 33 bits have as many.
const MOST_ZEROS: u32 = 32 - ORDER;
/// Number of ones of a Rice code after which the number follows in 32 bits.
const ESCAPE: u32 = 20;
/// Exclusive bound on the magnitude of a number whose differences can still be written.
pub(crate) const MOST: i64 = 1 << 30;

/// Signed numbers as unsigned ones: 0, -1, 1, -2, 2 become 0, 1, 2, 3, 4.
fn unsigned(value: i64) -> u64 {
    ((value << 1) ^ (value >> 63)) as u64
}

fn signed(value: u64) -> i64 {
    (value >> 1) as i64 ^ -((value & 1) as i64)
}

/// Number of bits of a signed Exp-Golomb code of order 8.
pub(crate) fn exp_golomb_bits(value: i64) -> u64 {
    let bits = (unsigned(value) + (1 << ORDER)).ilog2() + 1;
    u64::from(2 * bits - 1 - ORDER)
}

/// Writes a number below 2^32 in magnitude as a signed Exp-Golomb code of order 8.
pub(crate) fn write_exp_golomb(out: &mut BitWriter, value: i64) {
    let shifted = unsigned(value) + (1 << ORDER);
    let zeros = shifted.ilog2() - ORDER;
    out.push(zeros, 0);
    out.push(zeros + ORDER + 1, shifted);
}

/// Reads what [`write_exp_golomb`] wrote.
pub(crate) fn read_exp_golomb(reader: &mut BitReader<'_>) -> Result<i64, StreamError> {
    let zeros = reader.run(false, MOST_ZEROS + 1)?;
    if zeros > MOST_ZEROS {
        return Err(reader.bad("a number of more than 33 bits"));
    }
    let rest = reader.take(zeros + ORDER)?;
    Ok(signed((1 << (zeros + ORDER) | rest) - (1 << ORDER)))
}

/// Number of bits of a signed Rice code.
pub(crate) fn rice_bits(parameter: u32, value: i64) -> u64 {
    let quotient = unsigned(value) >> parameter;
    if quotient >= u64::from(ESCAPE) {
        u64::from(ESCAPE) + 32
    } else {
        quotient + 1 + u64::from(parameter)
    }
}

/// Writes a number that is at least -2^31 and below 2^31 as a signed Rice code.
pub(crate) fn write_rice(out: &mut BitWriter, parameter: u32, value: i64) {
    let value = unsigned(value);
    let quotient = value >> parameter;
    if quotient >= u64::from(ESCAPE) {
        out.push(ESCAPE, u64::MAX);
        out.push(32, value);
    } else {
        out.push(quotient as u32, u64::MAX);
        out.push(1, 0);
        out.push(parameter, value);
    }
}

/// Reads what [`write_rice`] wrote.
pub(crate) fn read_rice(reader: &mut BitReader<'_>, parameter: u32) -> Result<i64, StreamError> {
    let quotient = reader.run(true, ESCAPE)?;
    if quotient == ESCAPE {
        return Ok(signed(reader.take(32)?));
    }
    let low = reader.take(parameter)?;
    Ok(signed(u64::from(quotient) << parameter | low))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn bits(write: impl Fn(&mut BitWriter)) -> String {
        let mut out = BitWriter::default();
        write(&mut out);
        let bit = |i: u64| out.bytes[(i / 8) as usize] >> (7 - i % 8) & 1;
        (0..out.bits).map(|i| char::from(b'0' + bit(i))).collect()
    }

    #[test]
    fn codes_by_hand() {
        let golomb = |value| bits(|out| write_exp_golomb(out, value));
        assert_eq!(golomb(0), "100000000");
        assert_eq!(golomb(-1), "100000001");
        assert_eq!(golomb(127), "111111110");
        // 256 + 256 = 512 has ten bits, one more than nine.
        assert_eq!(golomb(128), "01000000000");
        let rice = |k, value| bits(|out| write_rice(out, k, value));
        assert_eq!(rice(0, 0), "0");
        assert_eq!(rice(0, -1), "10");
        assert_eq!(rice(2, 3), "1010");
        assert_eq!(rice(0, 9), "1".repeat(18) + "0");
        // 2 * 10 = 20 is the first that is written in 32 bits.
        assert_eq!(rice(0, 10), "1".repeat(20) + &format!("{:032b}", 20));
    }

    #[test]
    fn a_number_that_is_too_long_is_refused() {
        let bytes = [0; 16];
        let mut reader = BitReader::new(&bytes, 0..16);
        assert!(read_exp_golomb(&mut reader).is_err());
    }

    proptest! {
        #[test]
        fn numbers_come_back(
            values in prop::collection::vec((-MOST + 1..MOST, 0u32..31), 1..40),
            parameter in 0u32..15,
        ) {
            let mut out = BitWriter::default();
            let values: Vec<i64> = values.iter().map(|(value, shift)| value >> shift).collect();
            for value in &values {
                let before = out.bits;
                write_exp_golomb(&mut out, *value);
                prop_assert_eq!(out.bits - before, exp_golomb_bits(*value));
                let before = out.bits;
                // The greatest difference of two numbers.
                write_rice(&mut out, parameter, 2 * value);
                prop_assert_eq!(out.bits - before, rice_bits(parameter, 2 * value));
            }
            let mut reader = BitReader::new(&out.bytes, 0..out.bytes.len());
            for value in &values {
                prop_assert_eq!(read_exp_golomb(&mut reader), Ok(*value));
                prop_assert_eq!(read_rice(&mut reader, parameter), Ok(2 * value));
            }
        }
    }
}
