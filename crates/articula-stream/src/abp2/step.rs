//! Steps of quantisation, and coefficients from levels, in whole numbers.
//!
//! Form: `docs/formats/abp2.md`, part 4.

use super::contexts::Class;
use articula_core::Libm;

/// Bits after the point of decoded values: they count 2^-22 radians, metres, or units of scale or
/// weight.
pub(super) const POINT: u32 = 22;
/// Greatest code of a step: 2^-20 radians or metres.
pub(super) const MOST_CODE: i32 = 160;
/// Greatest magnitude of a coefficient.
const MOST_COEFFICIENT: i64 = 1 << 30;

/// `2^(30 - i/8)`, rounded.
const MANTISSAS: [i64; 8] = [
    1_073_741_824,
    984_625_594,
    902_905_651,
    827_968_132,
    759_250_125,
    696_235_434,
    638_450_708,
    585_461_881,
];
/// 65536 divided by the norm of the synthesis function of each detail band, by the binary logarithm
/// of its stride.
const DETAIL: [i64; 9] = [79866, 66336, 47821, 33866, 23949, 16935, 11975, 8518, 6023];
/// The same of the scaling band.
const SCALING: [i64; 9] = [65536, 51165, 36580, 25888, 18307, 12945, 9153, 6472, 4576];
/// 65536 times 0.9^b: without updates, bands differ by how far an error spreads alone.
const WITHOUT_UPDATES: [i64; 9] = [
    65536, 58982, 53084, 47776, 42998, 38698, 34829, 31346, 28211,
];

/// Returns the step of a code, `2^(-code / 8)` to 30 bits.
pub(super) fn step(code: i32) -> f64 {
    let mantissa = MANTISSAS[(code & 7) as usize] as f64 / (1_u64 << 30) as f64;
    mantissa / (1_u64 << (code >> 3)) as f64
}

/// Returns the code of the step that is nearest on a logarithmic scale, within the range of codes.
pub(super) fn code(step: f64) -> i32 {
    let code = (-8.0 * step.libm_log2()).round();
    code.clamp(0.0, f64::from(MOST_CODE)) as i32
}

/// Returns the size of a level in a band, in 2^-16 units of [`POINT`].
pub(super) fn level_size(code: i32, class: Class, band: u8, updates: bool) -> i64 {
    let of_band = match (updates, class) {
        (false, _) => WITHOUT_UPDATES,
        (true, 0) => SCALING,
        (true, _) => DETAIL,
    };
    let shift = 8 + (code >> 3);
    (MANTISSAS[(code & 7) as usize] * of_band[usize::from(band)] + (1 << (shift - 1))) >> shift
}

/// Returns the coefficient of a level with `dropped` planes missing; `None` beyond 2^30.
pub(super) fn coefficient(level: i32, dropped: u32, size: i64) -> Option<i64> {
    let whole = i64::from(level) * 3_i64.pow(dropped);
    let value = (whole.checked_mul(size)?.checked_add(1 << 15)?) >> 16;
    (value.abs() <= MOST_COEFFICIENT).then_some(value)
}

/// Returns the level of a coefficient.
pub(super) fn level(coefficient: i64, size: i64) -> f64 {
    ((coefficient << 16) as f64 / size as f64).round()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_by_hand() {
        // 2^-10 is 4096 in 2^-22, so its sizes are the table times 4096.
        assert_eq!(level_size(80, 0, 2, true), 36580 * 4096);
        assert_eq!(level_size(80, 1, 1, true), 66336 * 4096);
        assert_eq!(level_size(80, 1, 1, false), 58982 * 4096);
        let x = coefficient(10, 0, level_size(80, 0, 2, true));
        assert_eq!(x, Some(22863));
        assert_eq!(coefficient(1, 2, 9 << 16), Some(81));
        assert_eq!(coefficient(1 << 24, 12, level_size(0, 0, 0, true)), None);
    }

    #[test]
    fn codes_are_eighths_of_an_octave() {
        assert_eq!(code(1.0), 0);
        assert_eq!(code(0.5), 8);
        assert_eq!(code(2.0), 0);
        assert_eq!(code(0.0), MOST_CODE);
        for c in 0..=MOST_CODE {
            assert_eq!(code(step(c)), c);
            assert!((step(c).log2() * 8.0 + f64::from(c)).abs() < 1e-7);
            assert_eq!((code(step(c) * 0.99), code(step(c) * 1.01)), (c, c));
        }
    }
}
