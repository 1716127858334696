//! Contexts of binary decisions: their numbers, and how they learn.
//!
//! Form: `docs/formats/abp2.md`, parts 6 and 7.

use super::start_contexts::{COUNT, START};
use crate::range_coder::Coder;

/// Number of decisions after which the learning rate stays constant.
const SLOWEST: u8 = 60;
/// Goals of the probability of a 0, in 1/65536, after a 1 and after a 0.
const GOALS: [i64; 2] = [65440, 96];

/// `131072 / (2 n + 3)`: learning rates in 1/65536, by the number of decisions seen.
const RATES: [i64; SLOWEST as usize + 1] = {
    let mut rates = [0; SLOWEST as usize + 1];
    let mut n = 0;
    while n < rates.len() {
        rates[n] = 131_072 / (2 * n as i64 + 3);
        n += 1;
    }
    rates
};

/// State of one context.
#[derive(Debug, Clone, Copy)]
struct Context {
    /// Probability of a 0, in 1/65536.
    zero: u16,
    /// Number of decisions seen, up to [`SLOWEST`].
    seen: u8,
}

/// The contexts of a unit.
#[derive(Debug, Clone)]
pub(super) struct Contexts([Context; COUNT]);

/// Whether a value is in the scaling band (0) or a detail band (1) of the wavelet.
pub(super) type Class = usize;

/// The trained state.
static TRAINED: Contexts = {
    let mut contexts = [Context { zero: 0, seen: 0 }; COUNT];
    let mut at = 0;
    while at < COUNT {
        let (zero, seen) = START[at];
        contexts[at] = Context { zero, seen };
        at += 1;
    }
    Contexts(contexts)
};

impl Contexts {
    /// Returns the trained state in which the units of a motion start.
    pub(super) fn trained() -> Self {
        TRAINED.clone()
    }

    /// Returns the state in which pose units start, in which nothing is known.
    pub(super) fn untrained() -> Self {
        Self(
            [Context {
                zero: 1 << 15,
                seen: 0,
            }; COUNT],
        )
    }

    /// Codes one decision and learns from it.
    #[inline(always)]
    pub(super) fn bit(&mut self, coder: &mut impl Coder, context: usize, bit: bool) -> bool {
        let state = &mut self.0[context];
        let zero = (coder.range() >> 16) * u32::from(state.zero);
        let bit = coder.split(zero, bit);
        let goal = GOALS[usize::from(bit)];
        let step = ((goal - i64::from(state.zero)) * RATES[usize::from(state.seen)]) >> 16;
        state.zero = (i64::from(state.zero) + step) as u16;
        state.seen = (state.seen + 1).min(SLOWEST);
        bit
    }

    /// Codes a signed number of magnitude up to [`MOST`].
    #[inline]
    pub(super) fn value(
        &mut self,
        coder: &mut impl Coder,
        class: Class,
        bucket: usize,
        value: i32,
    ) -> i32 {
        let given = value.unsigned_abs() + 1;
        let given_bits = given.ilog2();
        let lengths = (class * 20 + bucket) * 20;
        let mut bits = 0;
        while bits < 19 && self.bit(coder, lengths + bits as usize, bits < given_bits) {
            bits += 1;
        }
        let mut prefix = 1_u32;
        for place in (0..bits).rev() {
            if bits - place > 2 {
                let rest = coder.raw(place + 1, given & ((1 << (place + 1)) - 1));
                prefix = prefix << (place + 1) | rest;
                break;
            }
            let context = 800 + (class * 20 + bits as usize) * 4 + (prefix & 3) as usize;
            let bit = self.bit(coder, context, given >> place & 1 == 1);
            prefix = prefix << 1 | u32::from(bit);
        }
        let magnitude = (prefix - 1) as i32;
        if magnitude != 0 && coder.raw(1, u32::from(value < 0)) == 1 {
            -magnitude
        } else {
            magnitude
        }
    }
}

/// Greatest magnitude of a number that [`Contexts::value`] codes.
pub(super) const MOST: i32 = (1 << 20) - 2;

/// Context of the digit of a level that was 0, at a tier and bucket: whether it is not 0.
pub(super) fn digit_of_zero(tier: usize, bucket: usize) -> usize {
    960 + tier.min(4) * 20 + bucket
}

/// Context of the digit of a level that was `magnitude` (1, 2, or 3 and more).
pub(super) fn digit(tier: usize, magnitude: usize, bucket: usize) -> usize {
    1060 + (tier.min(4) * 4 + magnitude) * 10 + bucket.min(9)
}

/// Context of the sign of a digit: whether it opposes the level.
pub(super) fn opposes(tier: usize, magnitude: usize) -> usize {
    1260 + tier.min(4) * 4 + magnitude
}

/// Context of a flag, 0 to 7.
pub(super) fn flag(number: usize) -> usize {
    1280 + number
}

/// Bucket of a magnitude of at least 16, in sixteenths: two buckets for each octave, with edges near
/// 2^(1/4) and 2^(3/4).
#[inline]
pub(super) fn bucket(x: u32) -> usize {
    let octave = x.ilog2();
    let within = u64::from(x) << 8;
    let half = usize::from(within >= 304 << octave) + usize::from(within >= 431 << octave);
    (2 * (octave as usize - 4) + half).min(19)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::range_coder::{Decoder, Encoder};
    use proptest::prelude::*;

    #[test]
    fn buckets_rise() {
        assert_eq!(bucket(16), 0);
        // 304/256 of 16 is 19: the second bucket begins there, the third at 431/256: 26.9.
        assert_eq!(
            [bucket(18), bucket(19), bucket(26), bucket(27)],
            [0, 1, 1, 2]
        );
        assert_eq!([bucket(31), bucket(32)], [2, 2]);
        assert_eq!(bucket(u32::MAX), 19);
        assert!((16..5000).all(|x| bucket(x) <= bucket(x + 1)));
    }

    #[test]
    fn a_context_learns() {
        let mut contexts = Contexts::untrained();
        let mut coder = Encoder::new();
        contexts.bit(&mut coder, 7, true);
        // 2/3 of the way from one half to the goal of 96.
        assert_eq!(contexts.0[7].zero, 32768 - 21782);
        for _ in 0..4000 {
            contexts.bit(&mut coder, 7, true);
        }
        assert!(contexts.0[7].zero < 160, "{}", contexts.0[7].zero);
        assert_eq!(contexts.0[7].seen, 60);
    }

    proptest! {
        #[test]
        fn numbers_come_back(values in prop::collection::vec(
            (0usize..2, 0usize..20, prop_oneof![-9..9, -MOST..=MOST]), 0..200)) {
            let mut coder = Encoder::new();
            let mut contexts = Contexts::trained();
            for &(class, bucket, value) in &values {
                contexts.value(&mut coder, class, bucket, value);
            }
            let bytes = coder.finish();
            let mut coder = Decoder::new(&bytes);
            let mut contexts = Contexts::trained();
            for &(class, bucket, value) in &values {
                prop_assert_eq!(contexts.value(&mut coder, class, bucket, 0), value);
            }
            prop_assert!(!coder.is_exhausted());
        }
    }
}
