//! Binary range coding, and models that learn by counting.
//!
//! Source: G. N. N. Martin, "Range encoding", 1979, with the carry handling of LZMA. Integer
//! arithmetic, so that all platforms produce the same bytes.

/// Model of one binary decision, whose probabilities are learnt by counting, at a rate that falls to
/// 1/96 (`docs/methods/clustered-mesh.md` part 8.1 (g)).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bit {
    /// Probability of a 0, in 1/[`ONE`].
    zero: u32,
    /// Number of decisions seen, up to [`SLOWEST`].
    seen: u8,
}

/// Number of decisions after which the learning rate stays constant.
const SLOWEST: u8 = 95;
/// The probability 1, fine enough that the smallest update is not rounded away.
const ONE: i32 = 1 << 24;
/// Minimum probability of either outcome, in 1/[`ONE`].
const LEAST: i32 = 24 << 8;

impl Default for Bit {
    fn default() -> Self {
        Self {
            zero: ONE as u32 / 2,
            seen: 0,
        }
    }
}

impl Bit {
    /// Returns the probability of a 0, in 1/2^24.
    pub(crate) fn zero(self) -> u32 {
        self.zero
    }

    /// Returns the number of decisions seen, up to a limit.
    pub(crate) fn seen(self) -> u8 {
        self.seen
    }

    pub(crate) fn learn(&mut self, bit: bool) {
        let goal = if bit { LEAST } else { ONE - LEAST };
        // 1 / (seen + 1.5), so that the first decision has the weight two thirds.
        let step = (goal - self.zero as i32) * 2 / (2 * i32::from(self.seen) + 3);
        self.zero = (self.zero as i32 + step).clamp(LEAST, ONE - LEAST) as u32;
        self.seen = (self.seen + 1).min(SLOWEST);
    }
}

/// Encoder or decoder. An encoder writes its arguments and returns them; a decoder ignores them and
/// returns what was encoded, so that one implementation of a walk serves both.
pub(crate) trait Coder {
    /// Whether this is a decoder, which ignores the given values.
    const READS: bool;

    /// Returns the current range, at least 2^24.
    fn range(&self) -> u32;

    /// Codes a decision whose outcome 0 has the lower `zero` of the range, neither 0 nor all of it.
    fn split(&mut self, zero: u32, bit: bool) -> bool;

    /// Codes a decision whose outcome 0 has the probability `zero` / 2^24, neither 0 nor 1.
    fn decide(&mut self, zero: u32, bit: bool) -> bool {
        let part = (u64::from(self.range()) * u64::from(zero)) >> 24;
        self.split(part as u32, bit)
    }

    /// Codes a decision with a model and updates it.
    fn bit(&mut self, model: &mut Bit, bit: bool) -> bool {
        let bit = self.decide(model.zero, bit);
        model.learn(bit);
        bit
    }

    /// Codes the lowest `count` (at most 32) bits of a value with equal probabilities.
    fn raw(&mut self, count: u32, value: u32) -> u32;

    /// Returns whether the input is used up; values decoded from then on are meaningless.
    fn is_exhausted(&self) -> bool;
}

const TOP: u32 = 1 << 24;

/// Encoder of decisions.
#[derive(Debug)]
pub(crate) struct Encoder {
    low: u64,
    range: u32,
    /// The last byte that a carry may still change, and the number of 255 bytes after it.
    pending: Option<u8>,
    pending_full: u64,
    bytes: Vec<u8>,
}

impl Encoder {
    pub(crate) fn new() -> Self {
        Self {
            low: 0,
            range: u32::MAX,
            pending: None,
            pending_full: 0,
            bytes: Vec::new(),
        }
    }

    fn shift(&mut self) {
        let carry = (self.low >> 32) as u8;
        let byte = (self.low >> 24) as u8;
        if carry == 1 || byte != 0xff {
            if let Some(pending) = self.pending {
                self.bytes.push(pending.wrapping_add(carry));
            }
            for _ in 0..self.pending_full {
                self.bytes.push(0xffu8.wrapping_add(carry));
            }
            self.pending_full = 0;
            self.pending = Some(byte);
        } else {
            self.pending_full += 1;
        }
        self.low = (self.low & 0x00ff_ffff) << 8;
    }

    fn settle(&mut self) {
        while self.range < TOP {
            self.range <<= 8;
            self.shift();
        }
    }

    /// Returns the bytes of all decisions; trailing zeros are left out, since a decoder reads zeros
    /// past the end.
    pub(crate) fn finish(mut self) -> Vec<u8> {
        // Any value in [low, low + range) is valid: takes the one with the most trailing zeros.
        let end = self.low + u64::from(self.range) - 1;
        for bits in (0..32).rev() {
            let round = (end >> bits) << bits;
            if round >= self.low {
                self.low = round;
                break;
            }
        }
        for _ in 0..5 {
            self.shift();
        }
        while self.bytes.last() == Some(&0) {
            self.bytes.pop();
        }
        self.bytes
    }
}

impl Coder for Encoder {
    const READS: bool = false;

    fn range(&self) -> u32 {
        self.range
    }

    fn split(&mut self, zero: u32, bit: bool) -> bool {
        if bit {
            self.low += u64::from(zero);
            self.range -= zero;
        } else {
            self.range = zero;
        }
        self.settle();
        bit
    }

    fn raw(&mut self, count: u32, value: u32) -> u32 {
        for i in (0..count).rev() {
            let half = self.range >> 1;
            if value >> i & 1 == 1 {
                self.low += u64::from(half);
                self.range -= half;
            } else {
                self.range = half;
            }
            self.settle();
        }
        value
    }

    fn is_exhausted(&self) -> bool {
        false
    }
}

/// Number of zeros that a decoder may read past the end before it counts as exhausted: those
/// omitted by [`Encoder::finish`], plus the four bytes that are read ahead.
const SPARE_BYTES: usize = 16;

/// Decoder of decisions.
///
/// Decisions of a stream are as likely to go either way as the model cannot foretell them, so that
/// a branch on one is mispredicted often: the state is updated without.
#[derive(Debug)]
pub(crate) struct Decoder<'a> {
    bytes: &'a [u8],
    /// Bytes taken into the window, zeros past the end among them.
    at: usize,
    /// The code in the upper 32 bits, then what follows it.
    window: u64,
    /// Bits of the window after the code, whole bytes.
    ahead: u32,
    range: u32,
}

impl<'a> Decoder<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        let mut decoder = Self {
            bytes,
            at: 0,
            window: 0,
            ahead: 0,
            range: u32::MAX,
        };
        let first = decoder.take();
        let second = decoder.take();
        decoder.window = u64::from(first) << 32 | u64::from(second);
        decoder.ahead = 32;
        decoder
    }

    /// Returns whether all bytes were read.
    pub(crate) fn is_spent(&self) -> bool {
        self.read() >= self.bytes.len()
    }

    /// Number of bytes up to the end of the code.
    fn read(&self) -> usize {
        self.at - self.ahead as usize / 8
    }

    /// The next four bytes.
    #[inline]
    fn take(&mut self) -> u32 {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        self.at += 4;
        match rest.first_chunk() {
            Some(whole) => u32::from_be_bytes(*whole),
            None => {
                let mut padded = [0; 4];
                padded[..rest.len()].copy_from_slice(rest);
                u32::from_be_bytes(padded)
            }
        }
    }

    /// Takes the upper part of the range if `bit`, else the lower one of `zero`.
    #[inline(always)]
    fn narrow(&mut self, zero: u32, bit: bool) {
        let mask = u32::from(bit).wrapping_neg();
        self.window -= u64::from(zero & mask) << 32;
        let upper = self.range - zero;
        self.range = zero ^ ((zero ^ upper) & mask);
        let shift = self.range.leading_zeros() & !7;
        self.range <<= shift;
        self.window <<= shift;
        // At most three bytes are shifted out at a time.
        if self.ahead < shift {
            self.refill(shift);
        } else {
            self.ahead -= shift;
        }
    }

    /// Goes on by `shift` bits, of which the window lacked some.
    #[inline]
    fn refill(&mut self, shift: u32) {
        self.ahead += 32 - shift;
        self.window |= u64::from(self.take()) << (32 - self.ahead);
    }
}

impl Coder for Decoder<'_> {
    const READS: bool = true;

    #[inline]
    fn range(&self) -> u32 {
        self.range
    }

    #[inline(always)]
    fn split(&mut self, zero: u32, _: bool) -> bool {
        let bit = self.window >= u64::from(zero) << 32;
        self.narrow(zero, bit);
        bit
    }

    #[inline]
    fn raw(&mut self, count: u32, _: u32) -> u32 {
        let mut value = 0;
        for _ in 0..count {
            let bit = self.split(self.range >> 1, false);
            value = value << 1 | u32::from(bit);
        }
        value
    }

    fn is_exhausted(&self) -> bool {
        self.read() > self.bytes.len() + SPARE_BYTES
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn written(decisions: &[(u8, bool)]) -> Vec<u8> {
        let mut models = [Bit::default(); 256];
        let mut encoder = Encoder::new();
        for &(model, bit) in decisions {
            encoder.bit(&mut models[usize::from(model)], bit);
        }
        encoder.finish()
    }

    #[test]
    fn likely_decisions_cost_little() {
        let all_alike = vec![(0, true); 80_000];
        // 80,000 decisions at -log2(1 - 24/65536) = 0.00053 bits are 5.3 bytes.
        assert!(written(&all_alike).len() <= 12);
    }

    #[test]
    fn a_model_counts_what_it_saw() {
        let share = |model: Bit| f64::from(model.zero()) / f64::from(1 << 24);
        let mut model = Bit::default();
        assert_eq!((share(model), model.seen()), (0.5, 0));
        let (mut zeros, mut seen) = (0, 0);
        for bit in [true, false, true, true, false, false, true, true, true] {
            model.learn(bit);
            seen += 1;
            zeros += u8::from(!bit);
            // Half an outcome of either kind was assumed: a quarter of a 0 in all.
            let expected = (0.25 + f64::from(zeros)) / (0.5 + f64::from(seen));
            assert!((share(model) - expected).abs() < 1e-3, "{seen} decisions");
            assert_eq!(model.seen(), seen);
        }
        // Nothing is ever certain.
        (0..5000).for_each(|_| model.learn(true));
        assert!((share(model) - 24.0 / 65536.0).abs() < 1e-5);
        assert_eq!(model.seen(), 95);
        // From there on a decision has the weight 1 / 96.5.
        model.learn(false);
        assert!((share(model) - 24.0 / 65536.0 - 1.0 / 96.5).abs() < 1e-4);
        (0..5000).for_each(|_| model.learn(false));
        assert!((1.0 - share(model) - 24.0 / 65536.0).abs() < 1e-5);
    }

    #[test]
    fn decisions_cost_their_entropy() {
        let mut state = 1_u32;
        let mut encoder = Encoder::new();
        let mut bits = 0.0;
        for _ in 0..40_000 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            // One in eight is a 0, as is stated.
            let bit = state >> 29 != 0;
            encoder.decide(1 << 21, bit);
            bits -= if bit { 0.875_f64 } else { 0.125 }.log2();
        }
        encoder.raw(13, 5);
        let bytes = encoder.finish().len() as f64;
        let expected = (bits + 13.0) / 8.0;
        assert!((bytes - expected).abs() < 4.0, "{bytes} bytes, {expected}");
    }

    #[test]
    fn ends_are_cut_and_read_as_zeros() {
        assert!(Encoder::new().finish().len() <= 1);
        for value in [1, 0x100, 0x1234_0000, u32::MAX] {
            let mut encoder = Encoder::new();
            encoder.raw(32, value);
            let bytes = encoder.finish();
            assert_ne!(bytes.last(), Some(&0), "{value:x}");
            let mut decoder = Decoder::new(&bytes);
            assert_eq!(decoder.raw(32, 0), value);
            assert!(decoder.is_spent() && !decoder.is_exhausted());
        }
        // Four bytes are read ahead, then one for each eight bits.
        let mut decoder = Decoder::new(&[0; 6]);
        assert!(!decoder.is_spent());
        decoder.raw(8, 0);
        assert!(!decoder.is_spent());
        decoder.raw(8, 0);
        assert!(decoder.is_spent());
        for zeros in 1..=20 {
            decoder.raw(8, 0);
            assert_eq!(decoder.is_exhausted(), zeros > 16, "{zeros} zeros");
        }
    }

    #[test]
    fn a_carry_runs_through_full_bytes() {
        let mut encoder = Encoder::new();
        let values = [u32::MAX, u32::MAX, 0, u32::MAX, 1, 0x8000_0000];
        for value in values {
            encoder.raw(32, value);
        }
        let bytes = encoder.finish();
        let mut decoder = Decoder::new(&bytes);
        assert_eq!(values.map(|_| decoder.raw(32, 0)), values);
        assert!(!decoder.is_exhausted());
    }

    proptest! {
        #[test]
        fn decisions_come_back(
            decisions in prop::collection::vec((0u8..5, prop::bool::weighted(0.9)), 0..3000),
            raw in prop::collection::vec((0u32..=32, any::<u32>()), 0..40),
        ) {
            let mut models = [Bit::default(); 5];
            let mut encoder = Encoder::new();
            for &(model, bit) in &decisions {
                encoder.bit(&mut models[usize::from(model)], bit);
            }
            let low = |count: u32, value: u32| (u64::from(value) & ((1 << count) - 1)) as u32;
            for &(count, value) in &raw {
                encoder.raw(count, low(count, value));
            }
            let bytes = encoder.finish();
            let mut models = [Bit::default(); 5];
            let mut decoder = Decoder::new(&bytes);
            for &(model, bit) in &decisions {
                prop_assert_eq!(decoder.bit(&mut models[usize::from(model)], false), bit);
            }
            for &(count, value) in &raw {
                prop_assert_eq!(decoder.raw(count, 0), low(count, value));
            }
            prop_assert!(!decoder.is_exhausted());
        }
    }
}
