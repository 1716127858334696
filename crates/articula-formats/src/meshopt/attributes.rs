//! Attributes: differences between neighbouring elements, one lane per byte of the element.
//!
//! Source: KHR_meshopt_compression, appendix A, mode 0.

use super::stream::{Stream, signed};
use crate::error::ReadError;

/// Number of elements that share the bit width of their differences.
const GROUP: usize = 16;
/// Maximum size of a block in bytes and in elements.
const BLOCK_BYTES: usize = 8192;
const BLOCK_ELEMENTS: usize = 256;
/// Maximum size of an element.
const MAX_BYTES: usize = 256;

const HEADER_V0: u8 = 0xa0;
const HEADER_V1: u8 = 0xa1;

/// Bits of a difference by the two header bits of its group: v0, then v1 with lane control 0 and 1.
const WIDTHS: [[u32; 4]; 3] = [[0, 2, 4, 8], [0, 1, 2, 4], [1, 2, 4, 8]];

/// Storage of the bytes of one lane.
#[derive(Debug, Clone, Copy)]
enum Lane {
    /// Groups with header bits, of these widths.
    Groups(&'static [u32; 4]),
    /// No data: all differences are 0.
    Still,
    /// Every difference as one byte.
    Plain,
}

/// Decoding of four neighbouring lanes into values.
#[derive(Debug, Clone, Copy)]
enum Channel {
    Bytes,
    Shorts,
    /// Exclusive or of 32 bits, rotated right by this number of bits.
    Xor(u32),
}

/// Decodes `count` elements of `stride` bytes.
pub(super) fn decode(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, ReadError> {
    // The end is padded before the tail.
    let used = |header| stride + if header == HEADER_V1 { stride / 4 } else { 0 };
    let padded = |header| used(header).max(if header == HEADER_V1 { 24 } else { 32 });
    let (header, mut stream, tail) = Stream::open(bytes, padded)?;
    if !matches!(header, HEADER_V0 | HEADER_V1) {
        let what = format!("header {header:#04x}, expected 0xa0 or 0xa1");
        return Err(ReadError::malformed("byte 0", what));
    }
    let tail = &tail[tail.len() - used(header)..];
    let channels = channels(tail, stride, bytes.len())?;
    let mut previous = [0; MAX_BYTES];
    previous[..stride].copy_from_slice(&tail[..stride]);
    let most = (BLOCK_BYTES / stride / GROUP * GROUP).min(BLOCK_ELEMENTS);
    let mut lanes = vec![0; most * stride];
    let mut out = Vec::new();
    while out.len() < count * stride {
        let elements = (count - out.len() / stride).min(most);
        let controls = match header {
            HEADER_V1 => stream.take(stride / 4)?,
            _ => &[],
        };
        for (i, lane) in lanes.chunks_exact_mut(most).enumerate() {
            read_lane(&mut stream, lane_kind(controls, i), elements, lane)?;
        }
        let start = out.len();
        out.resize(start + elements * stride, 0);
        for (e, element) in out[start..].chunks_exact_mut(stride).enumerate() {
            let difference = |byte: usize| lanes[byte * most + e];
            add(&channels, difference, &mut previous[..stride]);
            element.copy_from_slice(&previous[..stride]);
        }
    }
    stream.finish()?;
    Ok(out)
}

/// Returns the channel modes stored after the first element; v0 has none and uses byte differences.
fn channels(tail: &[u8], stride: usize, end: usize) -> Result<Vec<Channel>, ReadError> {
    let modes = &tail[stride..];
    if modes.is_empty() {
        return Ok(vec![Channel::Bytes; stride / 4]);
    }
    let channel = |(i, mode): (usize, &u8)| match (mode & 15, mode >> 4) {
        (0, 0) => Ok(Channel::Bytes),
        (1, 0) => Ok(Channel::Shorts),
        (2, turn) => Ok(Channel::Xor(u32::from(turn))),
        _ => {
            let at = format!("byte {}", end - modes.len() + i);
            let what = format!("unknown channel mode {mode:#04x}");
            Err(ReadError::malformed(at, what))
        }
    };
    modes.iter().enumerate().map(channel).collect()
}

fn lane_kind(controls: &[u8], lane: usize) -> Lane {
    let Some(control) = controls.get(lane / 4) else {
        return Lane::Groups(&WIDTHS[0]);
    };
    match control >> (lane % 4 * 2) & 3 {
        0 => Lane::Groups(&WIDTHS[1]),
        1 => Lane::Groups(&WIDTHS[2]),
        2 => Lane::Still,
        _ => Lane::Plain,
    }
}

/// Reads the differences of one byte of all elements of a block.
fn read_lane(
    stream: &mut Stream<'_>,
    kind: Lane,
    elements: usize,
    out: &mut [u8],
) -> Result<(), ReadError> {
    match kind {
        Lane::Still => out.fill(0),
        Lane::Plain => out[..elements].copy_from_slice(stream.take(elements)?),
        Lane::Groups(widths) => {
            let groups = elements.div_ceil(GROUP);
            let headers = stream.take(groups.div_ceil(4))?;
            for (g, group) in out.chunks_exact_mut(GROUP).take(groups).enumerate() {
                let bits = headers[g / 4] >> (g % 4 * 2) & 3;
                read_group(stream, widths[usize::from(bits)], group)?;
            }
        }
    }
    Ok(())
}

/// Reads sixteen differences of `width` bits; one with all bits set is followed by its byte.
fn read_group(stream: &mut Stream<'_>, width: u32, out: &mut [u8]) -> Result<(), ReadError> {
    if width == 0 {
        out.fill(0);
        return Ok(());
    }
    let packed = stream.take(GROUP * width as usize / 8)?;
    if width == 8 {
        out.copy_from_slice(packed);
        return Ok(());
    }
    let all_set = (1u8 << width) - 1;
    let per_byte = 8 / width;
    for (i, out) in (0u32..).zip(out) {
        let place = i % per_byte;
        // Single bits start at the lowest, wider ones at the highest.
        let shift = match width {
            1 => place,
            _ => 8 - width * (place + 1),
        };
        let code = packed[(i / per_byte) as usize] >> shift & all_set;
        *out = if code == all_set {
            stream.byte()?
        } else {
            code
        };
    }
    Ok(())
}

/// Adds the differences of one element to the previous element.
fn add(channels: &[Channel], difference: impl Fn(usize) -> u8, element: &mut [u8]) {
    let words = element.as_chunks_mut::<4>().0;
    for ((c, channel), word) in channels.iter().enumerate().zip(words) {
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| difference(c * 4 + i));
        match channel {
            Channel::Bytes => {
                for (byte, code) in word.iter_mut().zip([a, b, c, d]) {
                    *byte = byte.wrapping_add(signed(code.into()) as u8);
                }
            }
            Channel::Shorts => {
                let codes = [u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d])];
                for (short, code) in word.as_chunks_mut::<2>().0.iter_mut().zip(codes) {
                    let sum = u16::from_le_bytes(*short).wrapping_add(signed(code.into()) as u16);
                    *short = sum.to_le_bytes();
                }
            }
            Channel::Xor(turn) => {
                let code = u32::from_le_bytes([a, b, c, d]).rotate_right(*turn);
                *word = (u32::from_le_bytes(*word) ^ code).to_le_bytes();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_group_of_four_bits_by_hand() {
        // The example of the specification: -1 -4 -3 26 -91 0 -6 6 -4 -4 5 -5 1 -1 0 0.
        let codes = [
            0, 0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5,
        ];
        let (_, mut stream, _) = Stream::open(&codes, |_| 0).unwrap();
        let mut out = [0; 16];
        read_group(&mut stream, 4, &mut out).unwrap();
        stream.finish().unwrap();
        let found = out.map(|code| signed(code.into()) as i32);
        let wanted = [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0];
        assert_eq!(found, wanted);
    }

    #[test]
    fn single_bits_start_at_the_lowest() {
        let (_, mut stream, _) = Stream::open(&[0, 0b101, 0x80, 7, 8, 9], |_| 0).unwrap();
        let mut out = [0; 16];
        read_group(&mut stream, 1, &mut out).unwrap();
        let wanted = [7, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 9];
        assert_eq!(out, wanted);
    }

    #[test]
    fn three_kinds_of_channels() {
        let mut element = [250, 5, 0, 255, 0xff, 0xff, 1, 0, 1, 0, 0, 0];
        let channels = [Channel::Bytes, Channel::Shorts, Channel::Xor(4)];
        // +6 -1 0 +1 in bytes; +1 and -2 in shorts; bit 4 rotated to bit 0.
        let codes = [12, 1, 0, 2, 2, 0, 3, 0, 0x10, 0, 0, 0x80];
        add(&channels, |i| codes[i], &mut element);
        let wanted = [0, 4, 0, 0, 0, 0, 0xff, 0xff, 0, 0, 0, 0x08];
        assert_eq!(element, wanted);
    }

    #[test]
    fn nothing_to_decode() {
        let v0 = [&[0xa0][..], &[0; 32]].concat();
        assert_eq!(decode(&v0, 0, 4), Ok(vec![]));
        assert!(decode(&v0[1..], 0, 4).is_err());
        assert!(decode(&[0xa2; 40], 0, 4).is_err());
    }
}
