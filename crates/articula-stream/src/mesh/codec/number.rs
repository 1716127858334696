//! Whole numbers as binary decisions: adaptive Exp-Golomb codes.
//!
//! Source: `docs/methods/clustered-mesh.md` part 8.1 (g); Teuhola 1978 for the code. The length in
//! bits is a unary code with models, the first bits below the highest one have models too, the rest
//! is raw.

use crate::range_coder::{Bit, Coder};

/// Number of bits below the highest one that have models.
const MODELLED: u32 = 2;

/// Model of a number from 0 to 2^32 - 2.
#[derive(Debug, Clone)]
pub(super) struct Natural {
    length: [Bit; 32],
    below: [[Bit; 1 << MODELLED]; 33],
}

impl Default for Natural {
    fn default() -> Self {
        Self {
            length: [Bit::default(); 32],
            below: [[Bit::default(); 1 << MODELLED]; 33],
        }
    }
}

impl Natural {
    /// Codes a number; a decoder returns the decoded value.
    pub(super) fn code(&mut self, coder: &mut impl Coder, value: u32) -> u32 {
        let given = value.saturating_add(1);
        let bits = 31 - given.leading_zeros();
        let mut length = 0;
        while length < 31 && coder.bit(&mut self.length[length as usize], length < bits) {
            length += 1;
        }
        let mut out = 1u32;
        for i in (0..length).rev() {
            let bit = given >> i & 1 == 1;
            let below = length - 1 - i;
            if below >= MODELLED {
                let rest = coder.raw(i + 1, given & (u32::MAX >> (31 - i)));
                out = out << (i + 1) | rest;
                break;
            }
            let context = &mut self.below[length as usize][(out & 3) as usize];
            out = out << 1 | u32::from(coder.bit(context, bit));
        }
        out - 1
    }
}

/// Model of a number from -2^30 to 2^30.
#[derive(Debug, Clone, Default)]
pub(super) struct Integer {
    is_zero: Bit,
    is_negative: Bit,
    magnitude: Natural,
}

impl Integer {
    /// Codes a number; a decoder returns the decoded value.
    pub(super) fn code(&mut self, coder: &mut impl Coder, value: i32) -> i32 {
        if coder.bit(&mut self.is_zero, value == 0) {
            return 0;
        }
        let is_negative = coder.bit(&mut self.is_negative, value < 0);
        let given = value.unsigned_abs().max(1) - 1;
        let magnitude = self.magnitude.code(coder, given).min(1 << 30) as i32 + 1;
        if is_negative { -magnitude } else { magnitude }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::range_coder::{Decoder, Encoder};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn numbers_come_back(
            naturals in prop::collection::vec(prop_oneof![0u32..20, 0..=u32::MAX - 1], 0..300),
            integers in prop::collection::vec(prop_oneof![-9i32..9, -(1i32 << 30)..=1 << 30], 0..300),
        ) {
            let (mut natural, mut integer) = (Natural::default(), Integer::default());
            let mut encoder = Encoder::new();
            for &n in &naturals {
                natural.code(&mut encoder, n);
            }
            for &i in &integers {
                integer.code(&mut encoder, i);
            }
            let bytes = encoder.finish();
            let (mut natural, mut integer) = (Natural::default(), Integer::default());
            let mut decoder = Decoder::new(&bytes);
            for &n in &naturals {
                prop_assert_eq!(natural.code(&mut decoder, 0), n);
            }
            for &i in &integers {
                prop_assert_eq!(integer.code(&mut decoder, 0), i);
            }
        }
    }
}
