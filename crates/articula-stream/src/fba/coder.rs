//! The arithmetic coder: 16-bit registers, with a guard against 23 zero bits in a row, which only
//! start codes have.

use super::model::Model;
use crate::bits::{BitReader, BitWriter};

const QUARTER: u32 = 1 << 14;
const HALF: u32 = 2 * QUARTER;
/// Zero bits after which a 1 is inserted.
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
        self.out.push(1, u64::from(bit));
        self.zeros = if bit { 0 } else { self.zeros + 1 };
        if self.zeros == ZEROS {
            self.out.push(1, 1);
            self.zeros = 0;
        }
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
        };
        (0..16).for_each(|_| decoder.next());
        decoder
    }

    fn next(&mut self) {
        let bit = self.reader.flag();
        let is_there = bit.is_ok();
        let bit = bit.unwrap_or(false);
        self.code = 2 * self.code + u32::from(bit);
        self.zeros = if bit { 0 } else { self.zeros + 1 };
        let mut is_whole = is_there;
        if self.zeros == ZEROS {
            is_whole &= self.reader.flag().is_ok();
            self.zeros = 0;
        }
        let end = is_whole.then(|| self.reader.at());
        self.ends[self.read % 16] = end;
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
    /// decoder has read 16 more. `None` if the stream ends before.
    pub(super) fn finish(self) -> Option<u64> {
        self.ends[(self.read - 15) % 16]
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
        assert_eq!(decoder.finish(), Some(end));
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
