//! Filters: transformation of decoded attributes, element by element.
//!
//! Source: KHR_meshopt_compression, appendix B. The specification allows an error of one unit in
//! the last place, except for the exponential filter, which is exact. Values that it leaves
//! undefined result in some number, never in an error.

use super::Filter;

/// Applies a filter in place; elements have `stride` bytes.
pub(crate) fn undo(filter: Filter, stride: usize, bytes: &mut [u8]) {
    match (filter, stride) {
        (Filter::None, _) => {}
        (Filter::Octahedral, 4) => signed_bytes(bytes, |e| octahedral(e, 127.0)),
        (Filter::Octahedral, _) => signed_shorts(bytes, |e| octahedral(e, 32767.0)),
        (Filter::Quaternion, _) => signed_shorts(bytes, quaternion),
        (Filter::Exponential, _) => {
            for word in bytes.as_chunks_mut::<4>().0 {
                *word = exponential(i32::from_le_bytes(*word)).to_le_bytes();
            }
        }
        (Filter::Color, 4) => {
            for element in bytes.as_chunks_mut::<4>().0 {
                let [y, co, cg, alpha] = *element;
                let chroma = [co, cg].map(|c| i32::from(c as i8));
                *element = color(y.into(), chroma, alpha.into(), 255.0).map(|x| x as u8);
            }
        }
        (Filter::Color, _) => {
            for element in bytes.as_chunks_mut::<8>().0 {
                let [y, co, cg, alpha] = shorts(*element);
                let chroma = [co, cg].map(i32::from);
                let (y, alpha) = (y as u16, alpha as u16);
                let color = color(y.into(), chroma, alpha.into(), 65535.0);
                *element = short_bytes(color.map(|x| x as u16 as i16));
            }
        }
    }
}

fn signed_bytes(bytes: &mut [u8], decode: impl Fn([i32; 4]) -> [f32; 4]) {
    for element in bytes.as_chunks_mut::<4>().0 {
        let decoded = decode(element.map(|b| i32::from(b as i8)));
        *element = decoded.map(|x| x as i8 as u8);
    }
}

fn signed_shorts(bytes: &mut [u8], decode: impl Fn([i32; 4]) -> [f32; 4]) {
    for element in bytes.as_chunks_mut::<8>().0 {
        let decoded = decode(shorts(*element).map(i32::from));
        *element = short_bytes(decoded.map(|x| x as i16));
    }
}

fn shorts([a, b, c, d, e, f, g, h]: [u8; 8]) -> [i16; 4] {
    [[a, b], [c, d], [e, f], [g, h]].map(i16::from_le_bytes)
}

fn short_bytes(shorts: [i16; 4]) -> [u8; 8] {
    let [[a, b], [c, d], [e, f], [g, h]] = shorts.map(i16::to_le_bytes);
    [a, b, c, d, e, f, g, h]
}

/// Decodes a unit vector from two coordinates on an octahedron; the third number is the encoding of
/// 1.
fn octahedral([x, y, one, kept]: [i32; 4], largest: f32) -> [f32; 4] {
    let x = x as f32 / one as f32;
    let y = y as f32 / one as f32;
    let z = 1.0 - x.abs() - y.abs();
    // The lower half is folded outwards over the edges of the upper.
    let fold = z.min(0.0);
    let x = x - fold.copysign(x);
    let y = y - fold.copysign(y);
    let scale = largest / (x * x + y * y + z * z).sqrt();
    let [x, y, z] = [x, y, z].map(|part| (part * scale).round());
    [x, y, z, kept as f32]
}

/// Decodes a unit quaternion from three components; the fourth number is the encoding of 1 and, in
/// its lowest two bits, the index of the omitted component.
fn quaternion([x, y, z, one]: [i32; 4]) -> [f32; 4] {
    let scale = std::f32::consts::FRAC_1_SQRT_2 / (one | 3) as f32;
    let [x, y, z] = [x, y, z].map(|part| part as f32 * scale);
    let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let mut out = [w, x, y, z].map(|part| (part * 32767.0).round());
    out.rotate_right((one & 3) as usize);
    out
}

/// Decodes `2^e * m` with eight bits of exponent and twenty-four of mantissa, both signed.
fn exponential(code: i32) -> f32 {
    let mantissa = f64::from(code << 8 >> 8);
    // The power of two is assembled from bits: identical on every machine.
    let power = f64::from_bits((((code >> 24) + 1023) as u64) << 52);
    (mantissa * power) as f32
}

/// Decodes red, green, blue and alpha; the highest set bit of the stored alpha gives the encoding
/// of 1.
fn color(y: i32, [co, cg]: [i32; 2], alpha: u32, largest: f32) -> [f32; 4] {
    let bits = 32 - alpha.leading_zeros();
    let one = (1u32 << bits) - 1;
    // Alpha has one bit less than the others; its lowest is doubled.
    let alpha = alpha & (one >> 1);
    let alpha = (alpha << 1 | alpha & 1) as i32;
    let scale = largest / one as f32;
    [y + co - cg, y + cg, y - co - cg, alpha].map(|part| (part as f32 * scale).round())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unit_vectors_by_hand() {
        // Along x, straight down (folded from a corner), and a face of the octahedron.
        assert_eq!(octahedral([7, 0, 7, -5], 127.0), [127.0, 0.0, 0.0, -5.0]);
        assert_eq!(octahedral([7, 7, 7, 0], 127.0), [0.0, 0.0, -127.0, 0.0]);
        let third = octahedral([100, 100, 300, 0], 127.0);
        // 127 / sqrt(3) = 73.3
        assert_eq!(third, [73.0, 73.0, 73.0, 0.0]);
        // Lower half: (0.75, 0.5) is folded to (0.5, 0.25, -0.25).
        let [x, y, z, _] = octahedral([3, 2, 4, 0], 32767.0);
        let [a, b, c] = [0.5f32, 0.25, -0.25].map(|v| v * 32767.0 / 0.375f32.sqrt());
        assert!((x - a).abs() <= 0.5 && (y - b).abs() <= 0.5 && (z - c).abs() <= 0.5);
    }

    #[test]
    fn quaternions_by_hand() {
        // 1 is 2047 and component 2 is omitted; a stored 1 is the square root of one half.
        let one = 2047 & !3 | 2;
        assert_eq!(quaternion([0, 0, 0, one]), [0.0, 0.0, 32767.0, 0.0]);
        assert_eq!(quaternion([2047, 0, 0, one]), [0.0, 0.0, 23170.0, 23170.0]);
        assert_eq!(quaternion([0, 2047, 0, one]), [23170.0, 0.0, 23170.0, 0.0]);
    }

    #[test]
    fn exponents_by_hand() {
        let code = |e: i32, m: i32| e << 24 | m & 0xff_ffff;
        assert_eq!(exponential(code(-1, 3)), 1.5);
        assert_eq!(exponential(code(2, -9)), -36.0);
        assert_eq!(exponential(code(100, 1)), 2f32.powi(100));
        assert_eq!(exponential(code(-100, -1)), -(2f32.powi(-100)));
        assert_eq!(exponential(code(127, 0x7f_ffff)), f32::INFINITY);
    }

    #[test]
    fn colours_by_hand() {
        // Seven bits each: luma 64 and no chroma is a grey of 64/127; alpha 1 is 0b111_1111.
        let grey = color(64, [0, 0], 0x7f, 255.0);
        assert_eq!(grey, [129.0, 129.0, 129.0, 255.0]);
        // Red: y + co - cg = 127, y + cg = 0, y - co - cg = 1 with y 32, co 63, cg -32.
        assert_eq!(color(32, [63, -32], 0x40, 255.0), [255.0, 0.0, 2.0, 0.0]);
        // All bits zero: the result is undefined, but not an error.
        assert!(color(1, [0, 0], 0, 255.0)[3].is_nan());
    }

    #[test]
    fn bytes_are_little_endian_and_in_place() {
        let mut bytes = [0x03, 0, 0, 0xff, 0xf7, 0xff, 0xff, 0x02];
        undo(Filter::Exponential, 8, &mut bytes);
        let [a, b, c, d, e, f, g, h] = bytes;
        assert_eq!(f32::from_le_bytes([a, b, c, d]), 1.5);
        assert_eq!(f32::from_le_bytes([e, f, g, h]), -36.0);
        let mut down = [127, 0x81, 127, 9];
        undo(Filter::Octahedral, 4, &mut down);
        assert_eq!(down, [0, 0, 0x81, 9]);
    }
}
