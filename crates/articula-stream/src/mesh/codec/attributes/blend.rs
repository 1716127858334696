//! Prediction as a mixture of candidates with transmitted coefficients.
//!
//! Source: `docs/methods/clustered-mesh.md` part 8.1 (d, e): base + the sum of c (candidate -
//! base), with c in 1/64 for each class of surroundings, fitted by robust least squares. The
//! encoder fits in floating point; the prediction uses the transmitted whole numbers only.

use crate::range_coder::Coder;
use articula_core::Libm;

/// Fractional bits of a coefficient.
const UNIT_BITS: u32 = 6;
/// Bits of a transmitted coefficient.
const COEFFICIENT_BITS: u32 = 8;

/// Coefficients of each class, without that of the first candidate, which is the base.
#[derive(Debug)]
pub(super) struct Blend<const K: usize> {
    coefficients: Vec<[i32; K]>,
}

/// A sample for fitting: class, candidates, and the value that they predict.
pub(super) type Sample<const K: usize, const D: usize> = (usize, [[i32; D]; K], [i32; D]);

impl<const K: usize> Blend<K> {
    /// Fits and writes, or reads, the coefficients of each class.
    pub(super) fn code<C: Coder, const D: usize>(
        coder: &mut C,
        classes: usize,
        samples: &[Sample<K, D>],
    ) -> Self {
        let one_class = |class: usize| {
            let fitted = if C::READS {
                None
            } else {
                fit(&of_class(samples, class))
            };
            let is_fitted = coder.raw(1, u32::from(fitted.is_some())) == 1;
            let fitted = fitted.unwrap_or([0; K]);
            if !is_fitted {
                return default_coefficients();
            }
            let mut out = [0; K];
            for k in 1..K {
                if coder.raw(1, u32::from(fitted[k] != 0)) == 1 {
                    let given = (fitted[k] + 128) as u32;
                    out[k] = coder.raw(COEFFICIENT_BITS, given) as i32 - 128;
                }
            }
            out
        };
        Self {
            coefficients: (0..classes).map(one_class).collect(),
        }
    }

    /// Returns the prediction from candidates.
    pub(super) fn predict<const D: usize>(
        &self,
        class: usize,
        candidates: &[[i32; D]; K],
    ) -> [i32; D] {
        mixed(&self.coefficients[class], candidates)
    }
}

fn default_coefficients<const K: usize>() -> [i32; K] {
    let mut out = [0; K];
    if K > 2 {
        out[2] = 1 << (UNIT_BITS - 1);
    }
    out
}

fn mixed<const K: usize, const D: usize>(c: &[i32; K], candidates: &[[i32; D]; K]) -> [i32; D] {
    let base = candidates[0];
    std::array::from_fn(|d| {
        let steps =
            (1..K).map(|k| i64::from(c[k]) * (i64::from(candidates[k][d]) - i64::from(base[d])));
        let sum = i64::from(base[d]) + (steps.sum::<i64>() >> UNIT_BITS);
        sum.clamp(-(1 << 29), 1 << 29) as i32
    })
}

type Taken<'a, const K: usize, const D: usize> = Vec<&'a Sample<K, D>>;

/// Samples of one class; an even subset of very many.
fn of_class<const K: usize, const D: usize>(
    samples: &[Sample<K, D>],
    class: usize,
) -> Taken<'_, K, D> {
    let step = samples.len() / 40_000 + 1;
    let all = samples.iter().filter(|s| s.0 == class);
    all.step_by(step).collect()
}

fn cost<const K: usize, const D: usize>(samples: &Taken<'_, K, D>, c: &[i32; K]) -> f64 {
    let of_sample = |s: &&Sample<K, D>| {
        let predicted = mixed(c, &s.1);
        let off = |d: usize| f64::from(s.2[d].abs_diff(predicted[d])) / 16.0;
        (0..D).map(|d| (1.0 + off(d)).libm_log2()).sum::<f64>()
    };
    samples.iter().map(of_sample).sum()
}

/// Number of samples below which single candidates are tried too; with more, fitting all is worth
/// the bits.
const FEW: usize = 4000;

/// Returns coefficients that save more bits than they cost, or `None` if the default is better.
fn fit<const K: usize, const D: usize>(samples: &Taken<'_, K, D>) -> Option<[i32; K]> {
    if samples.is_empty() {
        return None;
    }
    let mut best = (cost(samples, &default_coefficients()), None);
    let mut consider = |c: [i32; K]| {
        let used = c.iter().filter(|x| **x != 0).count() as f64;
        let price = used * f64::from(COEFFICIENT_BITS) + (K - 1) as f64;
        let bits = cost(samples, &c) + price;
        if bits < best.0 {
            best = (bits, Some(c));
        }
    };
    if samples.len() < FEW {
        consider([0; K]);
        for k in 1..K {
            for c in [32, 64] {
                consider(std::array::from_fn(|i| if i == k { c } else { 0 }));
            }
        }
    }
    let mut c = [0f64; K];
    for round in 0..4 {
        let weight = |r: f64| {
            if round == 0 {
                1.0
            } else {
                1.0 / (r.abs() + 12.0)
            }
        };
        let Some(next) = solve(samples, &c, weight) else {
            break;
        };
        c = next;
        consider(c.map(|x| (x * 64.0).round().clamp(-128.0, 127.0) as i32));
    }
    best.1
}

/// One step of iteratively reweighted least squares for the coefficients 1 to K - 1.
fn solve<const K: usize, const D: usize>(
    samples: &Taken<'_, K, D>,
    c: &[f64; K],
    weight: impl Fn(f64) -> f64,
) -> Option<[f64; K]> {
    let (mut m, mut b) = ([[0f64; K]; K], [0f64; K]);
    for s in samples {
        for d in 0..D {
            let base = f64::from(s.1[0][d]);
            let x: [f64; K] = std::array::from_fn(|k| f64::from(s.1[k][d]) - base);
            let y = f64::from(s.2[d]) - base;
            let r = y - (1..K).map(|k| c[k] * x[k]).sum::<f64>();
            let w = weight(r);
            for i in 1..K {
                b[i] += w * x[i] * y;
                for j in 1..K {
                    m[i][j] += w * x[i] * x[j];
                }
            }
        }
    }
    let trace: f64 = (1..K).map(|i| m[i][i]).sum();
    for (i, row) in m.iter_mut().enumerate() {
        row[i] += trace * 1e-4 + 1e-6;
    }
    for i in 1..K {
        for r in i + 1..K {
            let share = m[r][i] / m[i][i];
            let above = m[i];
            for (x, y) in m[r].iter_mut().zip(above).skip(i) {
                *x -= share * y;
            }
            b[r] -= share * b[i];
        }
    }
    let mut out = [0f64; K];
    for i in (1..K).rev() {
        let rest: f64 = (i + 1..K).map(|j| m[i][j] * out[j]).sum();
        out[i] = (b[i] - rest) / m[i][i];
    }
    out.iter().all(|x| x.is_finite()).then_some(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::range_coder::{Decoder, Encoder};

    /// Candidates whose differences from the base are independent of each other.
    fn candidates(i: i32) -> [[i32; 2]; 4] {
        let at = |k: i32| [(i * 37 * k + i * i) % 211, (i * 53 - k * k * i) % 197].map(|x| x * 16);
        [at(1), at(2), at(3), at(5)]
    }

    #[test]
    fn a_mixture_by_hand() {
        // 100 + 1/2 (260 - 100) - 1/4 (20 - 100), and rounded down.
        let given = [[100], [260], [20]];
        assert_eq!(mixed(&[0, 32, -16], &given), [200]);
        assert_eq!(mixed(&[0, 0, 1], &[[0], [0], [-1]]), [-1]);
        assert_eq!(mixed(&[0, 64], &[[0], [i32::MAX]]), [1 << 29]);
        assert_eq!(default_coefficients::<4>(), [0, 0, 32, 0]);
        assert_eq!(default_coefficients::<2>(), [0, 0]);
    }

    #[test]
    fn a_cost_by_hand() {
        // Misses of 1 and 3 values, in sixteenths: log2 (1 + 1) + log2 (1 + 3).
        let sample = (0, [[0, 0], [64, 64]], [16, -48]);
        assert!((cost(&vec![&sample], &[0, 0]) - 3.0).abs() < 1e-9);
        // The second candidate misses by 3 and 7.
        assert!((cost(&vec![&sample], &[0, 64]) - 5.0).abs() < 1e-9);
    }

    #[test]
    fn the_coefficients_of_the_samples_are_found_and_read_back() {
        let mixture = [0, 40, -24, 50];
        let sample = |i: i32| {
            let found = candidates(i);
            let class = usize::from(i % 3 == 0);
            let truth = if class == 0 {
                mixed(&mixture, &found)
            } else {
                found[3]
            };
            (class, found, truth)
        };
        let samples: Vec<Sample<4, 2>> = (1..300).map(sample).collect();
        let exact = solve(&of_class(&samples, 0), &[0.0; 4], |_| 1.0).unwrap();
        for (found, wanted) in exact.iter().zip(mixture) {
            assert!((found * 64.0 - f64::from(wanted)).abs() < 0.5, "{exact:?}");
        }
        let mut encoder = Encoder::new();
        let written = Blend::code(&mut encoder, 3, &samples);
        let expected = [mixture, [0, 0, 0, 64], default_coefficients()];
        assert_eq!(written.coefficients, expected);
        // Three bits, of two classes three more, of four coefficients eight.
        let bytes = encoder.finish();
        assert!(bytes.len() * 8 < 3 + 6 + 32 + 16, "{} bytes", bytes.len());
        let none: &[Sample<4, 2>] = &[];
        let read = Blend::<4>::code(&mut Decoder::new(&bytes), 3, none);
        assert_eq!(read.coefficients, expected);
    }
}
