//! The arithmetic coder: 16-bit registers, with a guard against 23 zero bits in a row, which only
//! start codes have.
//!
//! A run has two bits more than its interval was doubled, so two if it has no symbol.

use super::model::Model;
use crate::bits::{BitReader, BitWriter};

const QUARTER: u32 = 1 << 14;
const HALF: u32 = 2 * QUARTER;
/// Zero bits after which a 1 is inserted before a further bit of the run.
const ZEROS: u32 = 22;

/// The interval that both sides divide.
#[derive(Debug, Clone, Copy)]
struct Interval {
    low: u32,
    high: u32,
}

/// What became known when an interval was doubled.
enum Doubled {
    /// It was in the lower or upper half.
    Bit(bool),
    /// It was in the middle half.
    Middle,
}

impl Interval {
    const WHOLE: Self = Self {
        low: 0,
        high: 4 * QUARTER - 1,
    };

    fn narrow(&mut self, total: u32, (from, after): (u32, u32)) {
        // At most 2^16 times 16383.
        let range = self.high - self.low + 1;
        self.high = self.low + range * from / total - 1;
        self.low += range * after / total;
    }

    fn double(&mut self) -> Option<Doubled> {
        let (known, offset) = if self.high < HALF {
            (Doubled::Bit(false), 0)
        } else if self.low >= HALF {
            (Doubled::Bit(true), HALF)
        } else if self.low >= QUARTER && self.high < 3 * QUARTER {
            (Doubled::Middle, QUARTER)
        } else {
            return None;
        };
        self.low = 2 * (self.low - offset);
        self.high = 2 * (self.high - offset) + 1;
        Some(known)
    }
}

/// Writes symbols to bits.
#[derive(Debug)]
pub(super) struct Encoder<'a> {
    out: &'a mut BitWriter,
    interval: Interval,
    pending: u32,
    zeros: u32,
}

impl<'a> Encoder<'a> {
    pub(super) fn new(out: &'a mut BitWriter) -> Self {
        Self {
            out,
            interval: Interval::WHOLE,
            pending: 0,
            zeros: 0,
        }
    }

    pub(super) fn encode(&mut self, model: &mut Model<'_>, symbol: u32) {
        self.interval.narrow(model.total(), model.share(symbol));
        model.count(symbol);
        while let Some(known) = self.interval.double() {
            match known {
                Doubled::Bit(bit) => self.known(bit),
                Doubled::Middle => self.pending += 1,
            }
        }
    }

    /// Writes the bits that tell the interval from others.
    pub(super) fn finish(mut self) {
        self.pending += 1;
        self.known(self.interval.low >= QUARTER);
    }

    fn known(&mut self, bit: bool) {
        self.push(bit);
        for _ in 0..std::mem::take(&mut self.pending) {
            self.push(!bit);
        }
    }

    fn push(&mut self, bit: bool) {
        if self.zeros == ZEROS {
            self.out.push(1, 1);
            self.zeros = 0;
        }
        self.out.push(1, u64::from(bit));
        self.zeros = if bit { 0 } else { self.zeros + 1 };
    }
}

/// Reads symbols from bits.
#[derive(Debug)]
pub(super) struct Decoder<'a> {
    reader: BitReader<'a>,
    interval: Interval,
    code: u32,
    zeros: u32,
    /// Number of data bits read, those past the end included, which are zeros.
    read: usize,
    /// Where the last data bits end; past the end of the stream `None`.
    ends: [Option<u64>; 16],
    /// Number of the first data bit before which the inserted 1 is missing. Bits after the run may
    /// be such.
    bare: Option<usize>,
}

impl<'a> Decoder<'a> {
    /// Starts at the next bit of a reader.
    pub(super) fn new(reader: &BitReader<'a>) -> Self {
        let mut decoder = Self {
            reader: reader.clone(),
            interval: Interval::WHOLE,
            code: 0,
            zeros: 0,
            read: 0,
            ends: [None; 16],
            bare: None,
        };
        (0..16).for_each(|_| decoder.next());
        decoder
    }

    fn next(&mut self) {
        if self.zeros == ZEROS {
            if let Ok(false) = self.reader.flag() {
                self.bare.get_or_insert(self.read);
            }
            self.zeros = 0;
        }
        let bit = self.reader.flag();
        self.ends[self.read % 16] = bit.is_ok().then(|| self.reader.at());
        let bit = bit.unwrap_or(false);
        self.code = 2 * self.code + u32::from(bit);
        self.zeros = if bit { 0 } else { self.zeros + 1 };
        self.read += 1;
    }

    pub(super) fn decode(&mut self, model: &mut Model<'_>) -> u32 {
        let Interval { low, high } = self.interval;
        let number = ((self.code - low + 1) * model.total() - 1) / (high - low + 1);
        let symbol = model.find(number);
        self.interval.narrow(model.total(), model.share(symbol));
        model.count(symbol);
        while let Some(known) = self.interval.double() {
            self.code -= match known {
                Doubled::Bit(false) => 0,
                Doubled::Bit(true) => HALF,
                Doubled::Middle => QUARTER,
            };
            self.next();
        }
        symbol
    }

    /// Returns the bit after the run: the encoder has written two bits more than it doubled, the
    /// decoder has read 16 more. The error is what is wrong with the bits.
    pub(super) fn finish(self) -> Result<u64, &'static str> {
        let last = self.read - 15;
        if self.bare.is_some_and(|bare| bare <= last) {
            return Err("22 zeros without a 1 after them");
        }
        self.ends[last % 16].ok_or("unexpected end")
    }
}

#[cfg(test)]
mod tests {
    use super::super::model::Adaptive;
    use super::*;
    use articula_mutate::Dice;

    /// Symbols, then raw bits that must not disturb them.
    fn round_trip(seed: u64, symbols: u32, count: usize, skew: bool) -> u64 {
        let mut dice = Dice::new(seed);
        let mut one = |n: u32| dice.roll(n as usize) as u32;
        let list: Vec<u32> = (0..count)
            .map(|_| {
                if skew && one(50) > 0 {
                    symbols - 1
                } else {
                    one(symbols)
                }
            })
            .collect();
        let tail = u64::from(one(1 << 16)) & u64::from(one(1 << 16));
        let mut out = BitWriter::default();
        let mut model = Adaptive::new(symbols);
        let mut encoder = Encoder::new(&mut out);
        for symbol in &list {
            encoder.encode(&mut Model::Adaptive(&mut model), *symbol);
        }
        encoder.finish();
        let end = out.bits;
        out.push(16, tail);
        let mut model = Adaptive::new(symbols);
        let mut decoder = Decoder::new(&BitReader::new(&out.bytes, 0..out.bytes.len()));
        for symbol in &list {
            assert_eq!(decoder.decode(&mut Model::Adaptive(&mut model)), *symbol);
        }
        assert_eq!(decoder.finish(), Ok(end));
        // No 23 zeros in the run.
        let bit = |at: u64| out.bytes[(at / 8) as usize] >> (7 - at % 8) & 1;
        let mut zeros = 0;
        for at in 0..end {
            zeros = if bit(at) == 0 { zeros + 1 } else { 0 };
            assert!(zeros < 23);
        }
        end
    }

    #[test]
    fn symbols_come_back_and_the_end_is_found() {
        for seed in 0..400 {
            let symbols = [1, 2, 15, 121, 3721][seed as usize % 5];
            round_trip(seed, symbols, seed as usize % 90, seed % 2 == 0);
        }
    }

    /// 21 bits are pending when the upper half becomes known: a 1 and 21 zeros, and one more if the
    /// run ends.
    #[test]
    fn a_1_is_inserted_only_before_a_further_bit() {
        let run = |further: bool| {
            let mut out = BitWriter::default();
            let mut encoder = Encoder::new(&mut out);
            (0..21).for_each(|_| encoder.pending += 1);
            encoder.interval.low = QUARTER;
            if further {
                encoder.known(true);
                encoder.pending = 0;
                encoder.interval.low = 0;
            }
            encoder.finish();
            (out.bits, out.bytes)
        };
        // 1, 22 zeros, and a byte that is not full.
        assert_eq!(run(false), (23, vec![0x80, 0, 0]));
        // 1, 21 zeros, then 0 and 1 of the end: a 1 is inserted between these.
        assert_eq!(run(true), (25, vec![0x80, 0, 0x01, 0x80]));
    }

    #[test]
    fn a_missing_1_is_an_error_within_the_run_only() {
        // Symbols of one bit each: 23 zeros are 23 times the lower half, symbol 1 of 2.
        let decode = |symbols: u32| {
            let mut decoder = Decoder::new(&BitReader::new(&[0; 8], 0..8));
            (0..symbols).for_each(|_| {
                assert_eq!(decoder.decode(&mut Model::Uniform(2)), 1);
            });
            decoder.finish()
        };
        assert_eq!(decode(20), Ok(22));
        assert_eq!(decode(21), Err("22 zeros without a 1 after them"));
        assert_eq!(decode(60), Err("22 zeros without a 1 after them"));
    }

    #[test]
    fn a_run_without_symbols_has_two_bits() {
        let mut out = BitWriter::default();
        Encoder::new(&mut out).finish();
        assert_eq!((out.bits, out.bytes), (2, vec![0b0100_0000]));
        let decoder = Decoder::new(&BitReader::new(&[0; 2], 0..2));
        assert_eq!(decoder.finish(), Ok(2));
    }

    #[test]
    fn the_length_is_near_the_entropy() {
        // 4000 even symbols of 64 need 6 bits each; adaptation and 16-bit registers add some.
        let bits = round_trip(1, 64, 4000, false) as f64 / 4000.0;
        assert!((5.9..6.1).contains(&bits), "{bits}");
        // 98 % one of 64: 0.02 * (6 + log2 50) + 0.98 * log2(1 / 0.98) = 0.26.
        let bits = round_trip(2, 64, 4000, true) as f64 / 4000.0;
        assert!((0.2..0.4).contains(&bits), "{bits}");
    }
}
