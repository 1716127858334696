//! Half floats (IEEE 754 binary16), for palettes of half the size.

/// Returns the nearest half float as bits, ties to even; too large values become infinite, and NaN
/// stays NaN (quiet).
pub fn half_from_f32(value: f32) -> u16 {
    let bits = value.to_bits();
    let sign = (bits >> 16) as u16 & 0x8000;
    let rest = bits & 0x7fff_ffff;
    if rest >= 0x4780_0000 {
        let nan = rest > 0x7f80_0000;
        let payload = if nan {
            0x0200 | (rest >> 13) as u16 & 0x01ff
        } else {
            0
        };
        return sign | 0x7c00 | payload;
    }
    if rest < 0x3880_0000 {
        // Below the smallest normal half: adding 0.5 aligns the significand, and the addition
        // rounds it.
        let shifted = f32::from_bits(rest) + 0.5;
        return sign | (shifted.to_bits() - 0x3f00_0000) as u16;
    }
    let odd = rest >> 13 & 1;
    sign | ((rest - 0x3800_0000 + 0x0fff + odd) >> 13) as u16
}

/// Returns the value of a half float, given as bits.
pub fn f32_from_half(half: u16) -> f32 {
    let sign = u32::from(half & 0x8000) << 16;
    let rest = u32::from(half & 0x7fff);
    let bits = match rest >> 10 {
        0 => (rest as f32 * f32::from_bits(0x3380_0000)).to_bits(),
        31 => rest << 13 | 0x7f80_0000,
        _ => (rest << 13) + 0x3800_0000,
    };
    f32::from_bits(sign | bits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_hand() {
        let cases = [
            (0.0, 0x0000),
            (-0.0, 0x8000),
            (1.0, 0x3c00),
            (-2.0, 0xc000),
            (65504.0, 0x7bff),
            (65520.0, 0x7c00),
            (f32::INFINITY, 0x7c00),
            // Half way between 1 and the next half: to even, so down; the next tie goes up.
            (1.0 + 1.0 / 2048.0, 0x3c00),
            (1.0 + 3.0 / 2048.0, 0x3c02),
            (5.960_464_5e-8, 0x0001),
            (2.980_232_2e-8, 0x0000),
        ];
        for (value, half) in cases {
            assert_eq!(half_from_f32(value), half, "{value}");
        }
        assert!(f32_from_half(half_from_f32(f32::NAN)).is_nan());
    }

    #[test]
    fn every_half_leads_back() {
        for half in 0..=u16::MAX {
            let value = f32_from_half(half);
            if !value.is_nan() {
                assert_eq!(half_from_f32(value), half, "{value}");
            }
        }
    }
}
