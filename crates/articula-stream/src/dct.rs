//! The orthonormal discrete cosine transform of 16 values (DCT-II) and its inverse.
//!
//! Source: N. Ahmed, T. Natarajan, K. Rao, "Discrete cosine transform", 1974. The cosines are
//! constants, so that all platforms give the same bits.

/// Number of values of a transform.
pub(crate) const POINTS: usize = 16;

/// `cos(k pi / 32)` for `k` from 0 to 16.
const COSINES: [f64; POINTS + 1] = [
    1.0,
    0.9951847266721969,
    0.9807852804032304,
    0.9569403357322088,
    0.9238795325112867,
    0.881921264348355,
    0.8314696123025452,
    0.773010453362737,
    std::f64::consts::FRAC_1_SQRT_2,
    0.6343932841636455,
    0.5555702330196023,
    0.4713967368259978,
    0.3826834323650898,
    0.2902846772544624,
    0.1950903220161283,
    0.0980171403295606,
    0.0,
];

/// `cos((2 i + 1) u pi / 32)`, times the factor that makes the transform orthonormal.
fn basis(i: usize, u: usize) -> f64 {
    if u == 0 {
        return 0.25;
    }
    // The cosine has the period 64, is even, and changes its sign around 16.
    let angle = (2 * i + 1) * u % 64;
    let angle = angle.min(64 - angle);
    let cosine = if angle > 16 {
        -COSINES[32 - angle]
    } else {
        COSINES[angle]
    };
    cosine * COSINES[8] / 2.0
}

/// Returns the coefficients of values, the mean times 4 first.
pub(crate) fn forward(values: &[f64; POINTS]) -> [f64; POINTS] {
    std::array::from_fn(|u| (0..POINTS).map(|i| values[i] * basis(i, u)).sum())
}

/// Returns the values of coefficients.
pub(crate) fn inverse(coefficients: &[f64; POINTS]) -> [f64; POINTS] {
    std::array::from_fn(|i| (0..POINTS).map(|u| coefficients[u] * basis(i, u)).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn the_basis_is_orthonormal_and_made_of_cosines() {
        for u in 0..POINTS {
            let factor = if u == 0 { 1.0 / 16.0_f64 } else { 2.0 / 16.0 }.sqrt();
            for i in 0..POINTS {
                let expected = factor * ((2 * i + 1) as f64 * u as f64 * PI / 32.0).cos();
                assert!((basis(i, u) - expected).abs() < 1e-14, "{i} {u}");
            }
            for v in 0..POINTS {
                let product: f64 = (0..POINTS).map(|i| basis(i, u) * basis(i, v)).sum();
                let expected = f64::from(u8::from(u == v));
                assert!((product - expected).abs() < 1e-14, "{u} {v}");
            }
        }
    }

    #[test]
    fn a_constant_has_one_coefficient_and_all_come_back() {
        let found = forward(&[3.0; POINTS]);
        assert!((found[0] - 12.0).abs() < 1e-12);
        assert!(found[1..].iter().all(|c| c.abs() < 1e-12));
        let values = std::array::from_fn(|i| (i * i) as f64 - 7.5 * i as f64);
        let back = inverse(&forward(&values));
        for (a, b) in values.iter().zip(back) {
            assert!((a - b).abs() < 1e-12);
        }
    }
}
