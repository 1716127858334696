//! The encoder: streams of the crate `meshoptimizer-rs`, and filters whose precision is an error.

use super::{Mode, ViewLayout};
use meshoptimizer_rs::Workspace;
use meshoptimizer_rs::codec::{
    IndexEncoding, VertexEncoding, encode_filter_oct, encode_filter_quat, encode_index_buffer,
    encode_index_sequence, encode_vertex_buffer,
};

/// Version of the vertex bitstream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Bitstream {
    /// Version 0, of EXT_meshopt_compression.
    V0,
    /// Version 1, of KHR_meshopt_compression.
    V1,
}

/// Encodes the elements of a view, to which its filter was applied before; indices are 32-bit.
/// `None` if the layout is not one of the format.
pub(crate) fn encode(bytes: &[u8], layout: &ViewLayout, version: Bitstream) -> Option<Vec<u8>> {
    let mut workspace = Workspace::default();
    let count = usize::try_from(layout.count).ok()?;
    let stride = usize::try_from(layout.stride).ok()?;
    let indices = || -> Vec<u32> {
        let numbers = bytes.as_chunks::<4>().0.iter();
        numbers.map(|b| u32::from_le_bytes(*b)).collect()
    };
    let index = IndexEncoding::DEFAULT;
    let encoded = match layout.mode {
        Mode::Attributes => {
            let number = u8::from(version == Bitstream::V1);
            let encoding = VertexEncoding::new(number, 3).ok()?;
            encode_vertex_buffer(bytes, count, stride, encoding, &mut workspace)
        }
        Mode::Triangles => encode_index_buffer(&indices(), index, &mut workspace),
        Mode::Indices => encode_index_sequence(&indices(), index, &mut workspace),
    };
    encoded.ok()
}

/// Unit vectors of four floats, the fourth free, as elements of the octahedral filter: 4 bytes for up
/// to 8 bits, 8 bytes above.
pub(crate) fn octahedral(vectors: &[[f32; 4]], bits: u32) -> Option<Vec<u8>> {
    let stride = if bits <= 8 { 4 } else { 8 };
    let mut workspace = Workspace::default();
    let floats = vectors.as_flattened();
    encode_filter_oct(vectors.len(), stride, bits, floats, &mut workspace).ok()
}

/// Unit quaternions as 8-byte elements of the quaternion filter, with 4 to 16 bits a component.
pub(crate) fn quaternions(turns: &[[f32; 4]], bits: u32) -> Option<Vec<u8>> {
    let mut workspace = Workspace::default();
    encode_filter_quat(turns.len(), 8, bits, turns.as_flattened(), &mut workspace).ok()
}

/// Floats as 4-byte elements of the exponential filter, as multiples of one power of two that is at
/// most `step`, so that each is within half of it. A larger power is used where the numbers would need
/// more than 24 bits.
///
/// Numbers of few bits fill the upper bytes of the mantissa, with an exponent that is less by 8 or 16: the
/// bytes below are all 0, where else those above would change with every sign. Bytes are compressed by
/// themselves, so those cost next to nothing. Numbers of 16 bits without a sign stay in the lower two, which
/// bitstream v1 compresses together.
pub(crate) fn exponential(numbers: &[f32], step: f32) -> Vec<u8> {
    multiples(numbers, &[exponent(numbers, step)])
}

/// Points as elements of the exponential filter, as [`exponential`] does it, that are within the length of half a
/// step along each axis: that length may leave room for twice the unit along one axis or two.
pub(crate) fn exponential_points(points: &[f32], step: f32) -> Vec<u8> {
    multiples(points, &axis_exponents(points, step))
}

/// The powers of two along each axis of which [`exponential_points`] stores multiples.
pub(crate) fn units(points: &[f32], step: f32) -> [f64; 3] {
    axis_exponents(points, step).map(power_of_two)
}

fn axis_exponents(points: &[f32], step: f32) -> [i32; 3] {
    let least = exponent(points, step);
    let squared = |length: f64| length * length;
    let more = 3.0 * squared(power_of_two(least));
    let mut left = 3.0 * squared(f64::from(step)) - more;
    [(); 3].map(|()| match more <= left {
        true => {
            left -= more;
            least + 1
        }
        false => least,
    })
}

/// Numbers as multiples of powers of two, which take turns.
fn multiples(numbers: &[f32], exponents: &[i32]) -> Vec<u8> {
    let width = exponents.len();
    let mantissa = |x: f32, exponent: i32| (f64::from(x) / power_of_two(exponent)).round() as i32;
    let mut stored = vec![0; 4 * numbers.len()];
    for (i, exponent) in exponents.iter().enumerate() {
        let own = || numbers.iter().skip(i).step_by(width);
        let all = own().map(|x| mantissa(*x, *exponent));
        let (least, most) = all.fold((0, 0), |(least, most), m| (m.min(least), m.max(most)));
        let shift = match most.max(-least) {
            0..0x80 => 16,
            0x80..0x8000 if least < 0 => 8,
            _ => 0,
        };
        let places = stored.as_chunks_mut().0.iter_mut().skip(i).step_by(width);
        for (place, x) in places.zip(own()) {
            let element = ((mantissa(*x, *exponent) << shift) as u32 & 0x00ff_ffff)
                | (((exponent - shift) as u32) << 24);
            *place = element.to_le_bytes();
        }
    }
    stored
}

/// Exponent of the largest power of two that is at most `step` and fits the numbers into 24 bits.
fn exponent(numbers: &[f32], step: f32) -> i32 {
    let most = numbers.iter().fold(0.0f32, |most, x| most.max(x.abs()));
    // The mantissa is a signed number of 24 bits; what rounds up to the next power of two needs one more.
    let floor = match most {
        0.0 => -100,
        most if most.to_bits() & 0x7f_ffff == 0x7f_ffff => exponent_of(most) + 2 - 23,
        most => exponent_of(most) + 1 - 23,
    };
    exponent_of(step.max(f32::MIN_POSITIVE))
        .max(floor)
        .clamp(-100, 100)
}

fn exponent_of(positive: f32) -> i32 {
    (positive.to_bits() >> 23) as i32 - 127
}

fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((1023 + i64::from(exponent)) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::super::{Filter, decode};
    use super::*;
    use crate::Limits;
    use proptest::prelude::*;

    fn decoded(bytes: &[u8], filter: Filter, stride: u64, version: Bitstream) -> Vec<u8> {
        let layout = ViewLayout {
            mode: Mode::Attributes,
            filter,
            count: bytes.len() as u64 / stride,
            stride,
        };
        let encoded = encode(bytes, &layout, version).unwrap();
        decode(&encoded, &layout, &Limits::default()).unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn points_come_back_within_half_a_step_of_each_axis(
            numbers in prop::collection::vec(-1.0f32..1.0, 1..60),
            step in 0.000_1f32..0.5,
        ) {
            let points = &numbers[..numbers.len() / 3 * 3];
            let back = decoded(&exponential_points(points, step), Filter::Exponential, 12, Bitstream::V1);
            let floats: Vec<f32> = back.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
            for (p, q) in points.as_chunks::<3>().0.iter().zip(floats.as_chunks::<3>().0) {
                let squared: f32 = p.iter().zip(q).map(|(a, b)| (a - b) * (a - b)).sum();
                prop_assert!(squared <= 0.7501 * step * step, "{p:?} {q:?}");
            }
        }

        #[test]
        fn exponential_floats_come_back_within_half_a_step(
            numbers in prop::collection::vec(-2000.0f32..2000.0, 1..200),
            step in 0.000_1f32..0.5,
        ) {
            let bytes = exponential(&numbers, step);
            for version in [Bitstream::V0, Bitstream::V1] {
                let back = decoded(&bytes, Filter::Exponential, 4, version);
                let floats = back.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b));
                // Beyond 24 bits the step is that of the largest number.
                let step = step.max(2000.0 / (1 << 22) as f32);
                for (x, y) in numbers.iter().zip(floats) {
                    prop_assert!((x - y).abs() <= 0.5 * step, "{x} {y}");
                }
            }
        }

        #[test]
        fn quaternions_come_back_within_their_bits(
            parts in prop::collection::vec(prop::array::uniform4(-1.0f32..1.0), 1..100),
            bits in 6u32..=16,
        ) {
            let unit = |q: &[f32; 4]| glam::Quat::from_array(*q).normalize();
            let turns: Vec<_> = parts.iter().filter(|q| glam::Vec4::from_array(**q).length() > 0.1).map(unit).collect();
            let arrays: Vec<[f32; 4]> = turns.iter().map(|q| q.to_array()).collect();
            let back = decoded(&quaternions(&arrays, bits).unwrap(), Filter::Quaternion, 8, Bitstream::V0);
            for (q, b) in turns.iter().zip(back.as_chunks::<8>().0) {
                let c = |i: usize| f32::from(i16::from_le_bytes([b[2 * i], b[2 * i + 1]])) / 32767.0;
                let shown = glam::Quat::from_xyzw(c(0), c(1), c(2), c(3)).normalize();
                let radians = 2.0 * q.dot(shown).abs().min(1.0).acos();
                // Half a step in each of three components, and the rounding of 16 bits and of acos.
                let step = std::f32::consts::FRAC_1_SQRT_2 / ((1u32 << (bits - 1)) - 1) as f32;
                prop_assert!(radians <= 3.5 * step + 1e-3, "{radians} {step}");
            }
        }

        #[test]
        fn triangles_keep_their_corners_in_order(
            corners in prop::collection::vec(0u32..500, 3..300),
        ) {
            let corners = &corners[..corners.len() / 3 * 3];
            let bytes: Vec<u8> = corners.iter().flat_map(|c| c.to_le_bytes()).collect();
            let layout = ViewLayout {
                mode: Mode::Triangles,
                filter: Filter::None,
                count: corners.len() as u64,
                stride: 4,
            };
            let encoded = encode(&bytes, &layout, Bitstream::V0).unwrap();
            let back = decode(&encoded, &layout, &Limits::default()).unwrap();
            let back: Vec<u32> = back.as_chunks::<4>().0.iter().map(|b| u32::from_le_bytes(*b)).collect();
            for (a, b) in corners.as_chunks::<3>().0.iter().zip(back.as_chunks::<3>().0) {
                // The encoder may turn a triangle, and never mirrors it.
                let turned = [[a[0], a[1], a[2]], [a[1], a[2], a[0]], [a[2], a[0], a[1]]];
                prop_assert!(turned.contains(b), "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn numbers_of_zero_and_of_any_size_are_stored() {
        let below_one = f32::from_bits(0x3f7f_ffff);
        for numbers in [
            vec![0.0],
            vec![1e30, -1e30, 0.0],
            vec![1e-30, 0.0],
            vec![below_one, -below_one],
        ] {
            let back = decoded(
                &exponential(&numbers, 0.0),
                Filter::Exponential,
                4,
                Bitstream::V0,
            );
            for (x, b) in numbers.iter().zip(back.as_chunks::<4>().0) {
                let y = f32::from_le_bytes(*b);
                assert!((x - y).abs() <= (x.abs() * 1e-6).max(1e-29), "{x} {y}");
            }
        }
    }
}
