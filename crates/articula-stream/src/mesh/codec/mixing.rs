//! Mixing of several models for one decision, weighted by their past performance.
//!
//! Source: M. Mahoney, "Adaptive weighing of context models for lossless data compression", 2005
//! (logistic mixing). Integer arithmetic; logarithm and logistic function are tables; a model that
//! has seen few decisions has less weight.

use super::contexts::Contexts;
use crate::range_coder::{Bit, Coder};

/// Weights of `N` models.
#[derive(Debug, Clone, Copy)]
pub(super) struct Weights<const N: usize> {
    weights: [i32; N],
    seen: u8,
}

/// The weight 1.
const UNIT: i32 = 1 << 16;
/// Maximum weight, either way.
const MOST: i32 = UNIT << 3;
/// The log-odds 1.
const ODDS: i32 = 256;
/// Maximum log-odds, either way.
const EDGE: i32 = 12 * ODDS - 1;
/// The probability 1.
const ONE: i32 = 1 << 24;
/// Minimum probability of either outcome.
const LEAST: i32 = 1 << 10;

impl<const N: usize> Default for Weights<N> {
    fn default() -> Self {
        // More than a mean: models that agree are more certain together than each alone.
        let each = if N == 1 {
            UNIT
        } else {
            UNIT * 7 / (5 * N as i32)
        };
        Self {
            weights: [each; N],
            seen: 0,
        }
    }
}

/// 2^24 / (1 + e^-x) for x = 0, 1/8, 2/8 .. 12.
const LOGISTIC: [i32; 97] = [
    8388608, 8912214, 9431757, 9943296, 10443135, 10927921, 11394728, 11841108, 12265128, 12665372,
    13040928, 13391352, 13716624, 14017088, 14293396, 14546446, 14777323, 14987245, 15177517,
    15349491, 15504527, 15643971, 15769129, 15881257, 15981542, 16071101, 16150975, 16222125,
    16285438, 16341724, 16391720, 16436096, 16475457, 16510351, 16541267, 16568648, 16592886,
    16614335, 16633310, 16650091, 16664929, 16678045, 16689637, 16699880, 16708930, 16716925,
    16723987, 16730224, 16735732, 16740596, 16744891, 16748683, 16752030, 16754986, 16757595,
    16759898, 16761931, 16763726, 16765310, 16766708, 16767942, 16769031, 16769992, 16770841,
    16771590, 16772251, 16772834, 16773349, 16773803, 16774204, 16774558, 16774870, 16775146,
    16775389, 16775604, 16775793, 16775960, 16776108, 16776238, 16776353, 16776454, 16776544,
    16776623, 16776693, 16776754, 16776808, 16776856, 16776898, 16776936, 16776969, 16776998,
    16777023, 16777046, 16777066, 16777084, 16777099, 16777113,
];

/// [`ODDS`] * ln(1 + i / 256) for i = 0 .. 255.
const LOGARITHM: [i32; 256] = logarithms();

const fn logarithms() -> [i32; 256] {
    let mut table = [0; 256];
    let mut i = 0;
    while i < 256 {
        // 16 binary digits of log2 by repeated squaring.
        let mut x = (256 + i as u64) << 22;
        let mut log2 = 0u64;
        let mut place = 0;
        while place < 16 {
            x = (x * x) >> 30;
            log2 <<= 1;
            if x >= 2 << 30 {
                x >>= 1;
                log2 |= 1;
            }
            place += 1;
        }
        table[i] = ((log2 * LN_2 as u64 + (1 << 23)) >> 24) as i32;
        i += 1;
    }
    table
}

/// [`ODDS`] * ln 2, in 1/256.
const LN_2: i32 = 45_426;

/// [`ODDS`] * ln of a positive number.
fn logarithm(x: u32) -> i32 {
    let places = 31 - x.leading_zeros() as i32;
    let below = (u64::from(x) << 8 >> places) as usize & 255;
    places * LN_2 / 256 + LOGARITHM[below]
}

/// Log-odds of a probability of `zero` / 2^24.
fn stretch(zero: u32) -> i32 {
    logarithm(zero) - logarithm(ONE as u32 - zero)
}

/// Probability of log-odds, in 1/2^24.
fn squash(odds: i32) -> i32 {
    let at = odds.clamp(-EDGE, EDGE);
    let (i, part) = (at.unsigned_abs() as usize / 32, at.abs() % 32);
    let above = LOGISTIC[i] + (LOGISTIC[i + 1] - LOGISTIC[i]) * part / 32;
    let zero = if at < 0 { ONE - above } else { above };
    zero.clamp(LEAST, ONE - LEAST)
}

/// Confidence in a model by the number of decisions that it has seen, in 1/16.
const TRUST: [i32; 8] = [0, 6, 9, 11, 12, 13, 14, 15];

/// Codes one decision with several models and updates all of them.
pub(super) fn decide<const N: usize>(
    coder: &mut impl Coder,
    mut models: [&mut Bit; N],
    weights: &mut Weights<N>,
    bit: bool,
) -> bool {
    let odds = std::array::from_fn::<i32, N, _>(|i| {
        let trust = TRUST.get(usize::from(models[i].seen())).unwrap_or(&16);
        stretch(models[i].zero()) * trust / 16
    });
    let sum: i64 = (odds.iter().zip(&weights.weights))
        .map(|(&odds, &weight)| i64::from(odds) * i64::from(weight))
        .sum();
    let edge = i64::from(EDGE);
    let zero = squash((sum / i64::from(UNIT)).clamp(-edge, edge) as i32);
    let bit = coder.decide(zero as u32, bit);
    let error = (if bit { -zero } else { ONE - zero }) / 256;
    let rate = RATE + FIRST_RATE / (1 + i64::from(weights.seen));
    weights.seen = weights.seen.saturating_add(1);
    for (weight, odds) in weights.weights.iter_mut().zip(odds) {
        let step = (i64::from(odds) * i64::from(error) * rate) >> 20;
        *weight = (*weight + step as i32).clamp(-MOST, MOST);
    }
    for model in &mut models {
        model.learn(bit);
    }
    bit
}

/// Final learning rate of the weights, and its initial factor.
const RATE: i64 = 32;
const FIRST_RATE: i64 = 64;

/// Model of a number from 0 to 2^32 - 2 in `N` contexts at once.
#[derive(Debug, Clone)]
pub(super) struct MixedNatural<const N: usize> {
    /// A kilobyte for each context that occurs.
    contexts: [Contexts<Nodes, 1>; N],
    weights: [Weights<N>; NODES],
}

/// Models of the decisions of a number in one context.
#[derive(Debug, Clone, Copy)]
struct Nodes([Bit; NODES]);

impl Default for Nodes {
    fn default() -> Self {
        Self([Bit::default(); NODES])
    }
}

/// Number of modelled decisions: 32 for the length, then the two bits below the highest one for
/// each length.
const NODES: usize = 32 + 32 * 3;

impl<const N: usize> MixedNatural<N> {
    /// Creates models; `contexts` is the number of contexts of each kind.
    pub(super) fn new(contexts: [usize; N]) -> Self {
        Self {
            contexts: contexts.map(Contexts::new),
            weights: [Weights::default(); NODES],
        }
    }

    /// Codes a number in one context of each kind.
    pub(super) fn code(&mut self, coder: &mut impl Coder, at: [usize; N], value: u32) -> u32 {
        let mut i = 0;
        let mut models = self.contexts.each_mut().map(|kind| {
            i += 1;
            &mut kind.model(at[i - 1]).0
        });
        let weights = &mut self.weights;
        let mut decide_node = |coder: &mut _, node: usize, bit| {
            let models = models.each_mut().map(|nodes| &mut nodes[node]);
            decide(coder, models, &mut weights[node], bit)
        };
        let given = value.saturating_add(1);
        let bits = 31 - given.leading_zeros();
        let mut length = 0;
        while length < 31 && decide_node(coder, length as usize, length < bits) {
            length += 1;
        }
        let mut out = 1u32;
        for i in (0..length).rev() {
            let below = (length - 1 - i) as usize;
            if below >= 2 {
                let rest = coder.raw(i + 1, given & (u32::MAX >> (31 - i)));
                out = out << (i + 1) | rest;
                break;
            }
            let node = 32
                + length as usize * 3
                + if below == 0 {
                    0
                } else {
                    1 + (out & 1) as usize
                };
            out = out << 1 | u32::from(decide_node(coder, node, given >> i & 1 == 1));
        }
        out - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::range_coder::{Decoder, Encoder};
    use proptest::prelude::*;

    #[test]
    fn tables_are_the_functions() {
        for i in 1..(1 << 12) {
            let p = f64::from(i) / 4096.0;
            let odds = (p / (1.0 - p)).ln() * f64::from(ODDS);
            assert!((f64::from(stretch(i << 12)) - odds).abs() < 4.0, "{p}");
        }
        for odds in -EDGE..=EDGE {
            let p = 1.0 / (1.0 + (-f64::from(odds) / f64::from(ODDS)).exp());
            let found = f64::from(squash(odds)) / f64::from(ONE);
            assert!((found - p).abs() < 0.0005, "{odds}");
        }
    }

    proptest! {
        #[test]
        fn mixed_numbers_come_back(
            values in prop::collection::vec((0usize..3, prop_oneof![0u32..20, 0..=u32::MAX - 1]), 0..300),
        ) {
            let mut model = MixedNatural::new([3, 1]);
            let mut encoder = Encoder::new();
            for &(context, value) in &values {
                model.code(&mut encoder, [context, 0], value);
            }
            let bytes = encoder.finish();
            let mut model = MixedNatural::new([3, 1]);
            let mut decoder = Decoder::new(&bytes);
            for &(context, value) in &values {
                prop_assert_eq!(model.code(&mut decoder, [context, 0], 0), value);
            }
            prop_assert!(decoder.is_spent() && !decoder.is_exhausted());
        }
    }
}
