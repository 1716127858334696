//! Numbers as parts that are unsigned, the most significant bit first, as parameters hold them.

use crate::coding::Coding;

/// Bits of a value of the most common type that other programs know.
const MOST_BITS: u64 = 32;

const NAMES: [(Coding, &str); 3] = [
    (Coding::BigEndian, "bigEndian"),
    (Coding::LittleEndian, "littleEndian"),
    (Coding::Varint, "varint"),
];

/// The name of an encoding in a description.
pub(super) fn name(coding: Coding) -> &'static str {
    let found = NAMES.iter().find(|row| row.0 == coding);
    found.map_or("", |row| row.1)
}

/// The encoding of a name; of none, that of the standard.
pub(super) fn coding(name: Option<&str>) -> Option<Coding> {
    let name = name.unwrap_or(NAMES[0].1);
    let found = NAMES.iter().find(|row| row.1 == name);
    found.map(|row| row.0)
}

/// The bits of the parts of a number, in the order of the stream.
pub(super) fn widths(coding: Coding, bits: u64) -> Vec<u32> {
    let mut widths = Vec::new();
    let mut left = bits;
    while left > 0 {
        let width = match coding {
            Coding::BigEndian => (left - 1) % MOST_BITS + 1,
            Coding::LittleEndian | Coding::Varint => left.min(8),
        };
        widths.push(width as u32);
        left -= width;
    }
    widths
}

/// The values of the parts of a number; `None` if it does not fit.
pub(super) fn split(coding: Coding, value: u64, widths: &[u32]) -> Option<Vec<u64>> {
    let mut left = value;
    let mut parts = vec![0; widths.len()];
    let last = widths.len().checked_sub(1)?;
    let mut order: Vec<usize> = (0..=last).collect();
    if coding == Coding::BigEndian {
        order.reverse();
    }
    for place in order {
        let is_varint = coding == Coding::Varint;
        let width = if is_varint { 7 } else { widths[place] };
        let more = if is_varint && place < last { 0x80 } else { 0 };
        let mask = u64::MAX >> (64 - width.clamp(1, 64));
        parts[place] = left & mask | more;
        left = left.checked_shr(width).unwrap_or(0);
    }
    (left == 0).then_some(parts)
}

/// The number of some parts, in bits and value; `None` if they are none of this encoding.
pub(super) fn join(coding: Coding, parts: &[(u32, u64)]) -> Option<u64> {
    let total: u32 = parts.iter().map(|part| part.0).sum();
    let are_bytes = parts.iter().all(|part| part.0 == 8);
    let last = parts.len().checked_sub(1)?;
    match coding {
        Coding::BigEndian if total <= 64 => Some(parts.iter().fold(0, |value: u64, part| {
            value.checked_shl(part.0).unwrap_or(0) | part.1
        })),
        Coding::LittleEndian if are_bytes && total <= 64 => {
            let from_the_top = parts.iter().rev();
            Some(from_the_top.fold(0, |value, part| value << 8 | part.1))
        }
        Coding::Varint if are_bytes && total <= 72 => {
            let end = parts.iter().position(|part| part.1 & 0x80 == 0);
            let from_the_top = parts.iter().rev();
            let value = from_the_top.fold(0, |value, part| value << 7 | part.1 & 0x7f);
            (end == Some(last)).then_some(value)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn by_hand() {
        assert_eq!(widths(Coding::BigEndian, 40), [8, 32]);
        assert_eq!(widths(Coding::LittleEndian, 32), [8; 4]);
        let split = |coding, value, bits| split(coding, value, &widths(coding, bits));
        assert_eq!(
            split(Coding::BigEndian, 0x1_0000_0002, 40),
            Some(vec![1, 2])
        );
        assert_eq!(split(Coding::LittleEndian, 0x0102, 24), Some(vec![2, 1, 0]));
        assert_eq!(split(Coding::Varint, 300, 16), Some(vec![0xac, 2]));
        assert_eq!(split(Coding::Varint, 1 << 14, 16), None);
        assert_eq!(join(Coding::Varint, &[(8, 0xac), (8, 0x82)]), None);
    }

    proptest! {
        #[test]
        fn parts_are_the_number(value: u64, bytes in 1u64..=8, bits in 1u64..=64) {
            for coding in [Coding::BigEndian, Coding::LittleEndian, Coding::Varint] {
                let bits = if coding == Coding::BigEndian { bits } else { 8 * bytes };
                let held = if coding == Coding::Varint { bits / 8 * 7 } else { bits };
                let value = value & (u64::MAX >> (64 - held));
                let widths = widths(coding, bits);
                let values = split(coding, value, &widths).unwrap();
                let parts: Vec<_> = widths.into_iter().zip(values).collect();
                prop_assert_eq!(join(coding, &parts), Some(value));
                prop_assert_eq!(super::coding(Some(name(coding))), Some(coding));
            }
        }
    }
}
