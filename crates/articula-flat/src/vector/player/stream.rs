//! Numbers of the player's clip as bytes.
//!
//! Source: variable-length quantities as in LEB128 (seven bits per byte, lowest first, the eighth
//! marks that more follow), signed ones as zigzag: 0, -1, 1, -2, … A real number is two of them,
//! `whole / 2^shift`, which a script reads in a few characters.

use super::error::PlayerError;

/// Maximum number of bits of an integer.
const MAX_BITS: u32 = 31;

/// Appends numbers to bytes.
#[derive(Debug, Default)]
pub(super) struct Writer(pub(super) Vec<u8>);

/// Reads numbers from bytes.
#[derive(Debug)]
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Writer {
    pub(super) fn unsigned(&mut self, value: u32) {
        let mut left = value;
        while left > 127 {
            self.0.push(left as u8 | 128);
            left >>= 7;
        }
        self.0.push(left as u8);
    }

    pub(super) fn signed(&mut self, value: i32) {
        self.unsigned((value << 1 ^ value >> 31) as u32);
    }

    /// Writes a positive number: exactly if it has at most 31 bits, which includes every `f32` in
    /// range and every number that was read; otherwise rounded.
    pub(super) fn real(&mut self, value: f64) {
        let mut shift = 0;
        let mut whole = value;
        while whole.fract() != 0.0 && whole < f64::from(1 << 30) && shift < 60 {
            whole *= 2.0;
            shift += 1;
        }
        self.unsigned(whole.round() as u32);
        self.unsigned(shift);
    }
}

impl<'a> Reader<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    pub(super) fn byte(&mut self) -> Result<u8, PlayerError> {
        let byte = self.bytes.get(self.at).ok_or(PlayerError::Truncated)?;
        self.at += 1;
        Ok(*byte)
    }

    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8], PlayerError> {
        let rest = &self.bytes[self.at..];
        let taken = rest.get(..count).ok_or(PlayerError::Truncated)?;
        self.at += count;
        Ok(taken)
    }

    pub(super) fn unsigned(&mut self) -> Result<u32, PlayerError> {
        let mut value = 0u64;
        for shift in (0..=28).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 127) << shift;
            if byte < 128 {
                return if value >> MAX_BITS == 0 {
                    Ok(value as u32)
                } else {
                    Err(PlayerError::Malformed(
                        "a variable-length integer exceeds 31 bits",
                    ))
                };
            }
        }
        Err(PlayerError::Malformed(
            "a variable-length integer exceeds 31 bits",
        ))
    }

    pub(super) fn signed(&mut self) -> Result<i32, PlayerError> {
        let folded = self.unsigned()?;
        Ok((folded >> 1) as i32 ^ -((folded & 1) as i32))
    }

    pub(super) fn real(&mut self) -> Result<f64, PlayerError> {
        let (whole, shift) = (self.unsigned()?, self.unsigned()?);
        if shift > 60 {
            return Err(PlayerError::Malformed("a shift exceeds 60"));
        }
        Ok(f64::from(whole) / f64::from(shift).exp2())
    }

    /// Reads a count or size from `least` to `most`.
    pub(super) fn count(
        &mut self,
        what: &'static str,
        least: usize,
        most: usize,
    ) -> Result<usize, PlayerError> {
        let found = self.unsigned()? as usize;
        if found > most {
            return Err(PlayerError::TooMany { what, found, most });
        }
        if found < least {
            return Err(PlayerError::Malformed("a count must not be 0"));
        }
        Ok(found)
    }

    pub(super) fn is_at_end(&self) -> bool {
        self.at == self.bytes.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_bytes_worked_out_by_hand() {
        let mut writer = Writer::default();
        writer.unsigned(300);
        writer.signed(-1);
        writer.signed(64);
        writer.real(25.0);
        writer.real(0.75);
        assert_eq!(writer.0, [0xac, 0x02, 1, 0x80, 0x01, 25, 0, 3, 2]);
        let mut reader = Reader::new(&writer.0);
        assert_eq!(reader.unsigned(), Ok(300));
        assert_eq!(reader.signed(), Ok(-1));
        assert_eq!(reader.signed(), Ok(64));
        assert_eq!(reader.real(), Ok(25.0));
        assert_eq!(reader.real(), Ok(0.75));
        assert!(reader.is_at_end());
        assert_eq!(reader.byte(), Err(PlayerError::Truncated));
    }

    #[test]
    fn numbers_come_back() {
        let wholes = [
            0,
            1,
            -1,
            63,
            -64,
            64,
            8191,
            -8192,
            (1 << 28) - 1,
            -(1 << 28),
        ];
        let reals = [29.97f32, 0.001, 60.0, 1.5e-7];
        let mut writer = Writer::default();
        wholes.iter().for_each(|v| writer.signed(*v));
        reals.iter().for_each(|v| writer.real(f64::from(*v)));
        let mut reader = Reader::new(&writer.0);
        for value in wholes {
            assert_eq!(reader.signed(), Ok(value));
        }
        for value in reals {
            assert_eq!(reader.real(), Ok(f64::from(value)));
        }
    }

    #[test]
    fn a_real_number_that_was_read_is_written_exactly() {
        let most = f64::from((1u32 << 31) - 1);
        for value in [
            most,
            most / 2.0,
            most / 60f64.exp2(),
            1.0 / 60f64.exp2(),
            0.0,
        ] {
            let mut writer = Writer::default();
            writer.real(value);
            assert_eq!(Reader::new(&writer.0).real(), Ok(value));
        }
    }

    #[test]
    fn long_numbers_are_refused() {
        for bytes in [&[0xff; 9][..], &[0xff, 0xff, 0xff, 0xff, 0x0f]] {
            let found = Reader::new(bytes).unsigned();
            assert!(matches!(found, Err(PlayerError::Malformed(_))), "{found:?}");
        }
        assert!(matches!(
            Reader::new(&[1, 61]).real(),
            Err(PlayerError::Malformed(_))
        ));
        assert!(Reader::new(&[9]).count("ears", 0, 8).is_err());
    }
}
