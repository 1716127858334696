//! One component of a track over the frames of an access unit, as a block of bits of its own.
//!
//! Form: `docs/formats/abp1.md`, part 5. There is no state beyond a block, so that blocks can be
//! removed.

use crate::bits::{BitReader, BitWriter};
use crate::dct::{self, POINTS};
use crate::error::StreamError;
use crate::golomb::{self, MOST};

/// Maximum number of values of a block.
pub(crate) const FRAMES: usize = POINTS;
/// Number of values after the first.
const REST: usize = FRAMES - 1;
/// Parameter of a block whose values are all equal.
const CONSTANT: u32 = 15;

/// Form of the values of an access unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CodingType {
    /// The first value, then differences.
    Predictive,
    /// Coefficients of the discrete cosine transform.
    Dct,
}

impl CodingType {
    /// The bit that stands for it.
    pub(crate) fn bit(self) -> u64 {
        u64::from(self == Self::Dct)
    }

    /// The coding type of a bit.
    pub(crate) fn of(bit: bool) -> Self {
        if bit { Self::Dct } else { Self::Predictive }
    }
}

/// The whole numbers of a block: the first level and the differences after it, or the coefficients.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Block {
    coding: CodingType,
    parameter: u32,
    first: i64,
    rest: [i64; REST],
    /// Number of values in `rest` that are written.
    count: usize,
}

impl Block {
    /// Quantises 1 to 16 values; the transform needs 16. Returns `None` if a level is too great, or
    /// a value is not finite.
    pub(crate) fn of(values: &[f64], step: f64, coding: CodingType) -> Option<Self> {
        let mut levels = [0; FRAMES];
        for (level, value) in levels.iter_mut().zip(values) {
            *level = level_of(*value, step)?;
        }
        let levels = &levels[..values.len()];
        let mut block = Self {
            coding,
            parameter: CONSTANT,
            first: levels[0],
            rest: [0; REST],
            count: 0,
        };
        let constant = levels.iter().all(|l| *l == levels[0]).then_some(block);
        match coding {
            CodingType::Predictive => {
                block.count = levels.len() - 1;
                for (rest, pair) in block.rest.iter_mut().zip(levels.windows(2)) {
                    *rest = pair[1] - pair[0];
                }
            }
            CodingType::Dct => {
                let coefficients = dct::forward(values.first_chunk()?);
                block.first = level_of(coefficients[0], step)?;
                for (rest, coefficient) in block.rest.iter_mut().zip(&coefficients[1..]) {
                    *rest = level_of(*coefficient, step)?;
                }
                let last = block.rest.iter().rposition(|level| *level != 0);
                block.count = last.map_or(0, |last| last + 1);
            }
        }
        let codes = (0..CONSTANT).map(|parameter| block.with(parameter));
        codes.chain(constant).min_by_key(Self::bits)
    }

    fn with(mut self, parameter: u32) -> Self {
        self.parameter = parameter;
        self
    }

    /// Number of bits after the parameter.
    fn bits(&self) -> u64 {
        let last = match (self.coding, self.parameter) {
            (CodingType::Dct, 0..CONSTANT) => 4,
            _ => 0,
        };
        let rest = self.rest[..self.count].iter();
        let rest = rest.map(|level| golomb::rice_bits(self.parameter, *level));
        golomb::exp_golomb_bits(self.first) + last + rest.sum::<u64>()
    }

    /// Writes the block.
    pub(crate) fn write(&self, out: &mut BitWriter) {
        out.push(4, u64::from(self.parameter));
        golomb::write_exp_golomb(out, self.first);
        if self.parameter == CONSTANT {
            return;
        }
        if self.coding == CodingType::Dct {
            out.push(4, self.count as u64);
        }
        for level in &self.rest[..self.count] {
            golomb::write_rice(out, self.parameter, *level);
        }
    }

    /// Reads a block of 1 to 16 values; with the transform it always has 16.
    pub(crate) fn read(
        reader: &mut BitReader<'_>,
        coding: CodingType,
        frames: usize,
    ) -> Result<Self, StreamError> {
        let parameter = reader.take(4)? as u32;
        let mut block = Self {
            coding,
            parameter,
            first: golomb::read_exp_golomb(reader)?,
            rest: [0; REST],
            count: 0,
        };
        if parameter == CONSTANT {
            return Ok(block);
        }
        block.count = match coding {
            CodingType::Predictive => frames - 1,
            CodingType::Dct => reader.take(4)? as usize,
        };
        for level in &mut block.rest[..block.count] {
            *level = golomb::read_rice(reader, parameter)?;
        }
        Ok(block)
    }

    /// Returns the values; those from the number of frames on have no meaning.
    pub(crate) fn values(&self, step: f64) -> [f64; FRAMES] {
        let first = self.first as f64 * step;
        match self.coding {
            _ if self.parameter == CONSTANT => [first; FRAMES],
            CodingType::Predictive => {
                let mut level = self.first;
                std::array::from_fn(|i| {
                    level += i.checked_sub(1).map_or(0, |i| self.rest[i]);
                    level as f64 * step
                })
            }
            CodingType::Dct => dct::inverse(&std::array::from_fn(|u| {
                u.checked_sub(1).map_or(self.first, |u| self.rest[u]) as f64 * step
            })),
        }
    }
}

/// The nearest level of a value, if it can be written.
pub(crate) fn level_of(value: f64, step: f64) -> Option<i64> {
    let level = (value / step).round();
    // False for NaN.
    (level.abs() < MOST as f64).then_some(level as i64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn written(block: &Block) -> BitWriter {
        let mut out = BitWriter::default();
        block.write(&mut out);
        out
    }

    #[test]
    fn a_still_component_is_4_bits_and_a_number() {
        for coding in [CodingType::Predictive, CodingType::Dct] {
            let block = Block::of(&[0.3; 16], 0.1, coding).unwrap();
            let out = written(&block);
            // 1111, then 6 + 256 in nine bits.
            assert_eq!((out.bits, out.bytes[0]), (13, 0b1111_1000), "{coding:?}");
            assert_eq!(out.bytes[1], 0b0011_0000);
            assert_eq!(block.values(0.1)[15], 3.0 * 0.1);
        }
    }

    #[test]
    fn differences_by_hand() {
        let values = [0.0, 1.0, 1.0, 0.0];
        let out = written(&Block::of(&values, 1.0, CodingType::Predictive).unwrap());
        // k = 0: 0000 | 100000000 | 110 | 0 | 10
        assert_eq!(out.bits, 19);
        assert_eq!(out.bytes, [0b0000_1000, 0b0000_0110, 0b0100_0000]);
    }

    #[test]
    fn values_that_cannot_be_written() {
        let of = |value| Block::of(&[value; 16], 1.0, CodingType::Dct);
        assert_eq!((of(f64::NAN), of(1e9)), (None, None));
        assert_eq!(of(f64::INFINITY), None);
        assert!(of(1e6).is_some());
    }

    proptest! {
        #[test]
        fn values_come_back_within_their_bound(
            values in prop::collection::vec(-3.0..3.0, 16),
            frames in 1usize..=16,
            step in 0.0001..0.1,
        ) {
            let values = &values[..frames];
            for coding in [CodingType::Predictive, CodingType::Dct] {
                let Some(block) = Block::of(values, step, coding) else {
                    prop_assert!(coding == CodingType::Dct && frames < 16);
                    continue;
                };
                let out = written(&block);
                prop_assert_eq!(out.bits, 4 + block.bits());
                let mut reader = BitReader::new(&out.bytes, 0..out.bytes.len());
                let read = Block::read(&mut reader, coding, frames).unwrap();
                prop_assert_eq!(reader.at(), out.bits);
                let error = |(a, b): (&f64, f64)| (a - b).abs() / step;
                let errors: Vec<f64> = values.iter().zip(read.values(step)).map(error).collect();
                let squares: f64 = errors.iter().map(|e| e * e).sum();
                // Each of n numbers is off by half a step, and the transform keeps lengths.
                prop_assert!(squares <= frames as f64 / 4.0 + 1e-6);
                if coding == CodingType::Predictive {
                    prop_assert!(errors.iter().all(|e| *e <= 0.5 + 1e-6));
                }
            }
        }
    }
}
