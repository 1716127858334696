//! Increments: which bytes of a stream a client needs, that has some of them, to have others.
//!
//! Works by the map of the stream alone, without the codec, as the cut does. A client that fetches bytes
//! of the whole stream keeps them where they are there: no number is rewritten, and what a later
//! selection needs is never sent again.

use crate::unit::Unit;
use articula_core::Mismatch;
use std::ops::Range;

/// Bytes of a stream: ranges that rise and do not touch each other.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ByteRanges {
    ranges: Vec<Range<u64>>,
}

/// Collects ranges in any order, which may overlap.
impl FromIterator<Range<u64>> for ByteRanges {
    fn from_iter<I: IntoIterator<Item = Range<u64>>>(ranges: I) -> Self {
        let mut all: Vec<_> = ranges.into_iter().filter(|r| !r.is_empty()).collect();
        all.sort_unstable_by_key(|range| range.start);
        let mut joined = Self::default();
        all.into_iter().for_each(|range| joined.push(range));
        joined
    }
}

impl ByteRanges {
    /// Adds a range that does not begin before the last one.
    fn push(&mut self, range: Range<u64>) {
        match self.ranges.last_mut() {
            Some(last) if last.end >= range.start => last.end = last.end.max(range.end),
            _ => self.ranges.push(range),
        }
    }

    /// Returns the ranges, rising.
    pub fn ranges(&self) -> &[Range<u64>] {
        &self.ranges
    }

    /// Returns the number of bytes.
    pub fn bytes(&self) -> u64 {
        self.ranges
            .iter()
            .map(|range| range.end - range.start)
            .sum()
    }

    /// Returns the bytes that are among these or the others.
    #[must_use]
    pub fn union(&self, others: &Self) -> Self {
        self.ranges.iter().chain(&others.ranges).cloned().collect()
    }
}

/// Returns the bytes of a stream that a selection keeps, by the map of the stream: those that
/// [`cut`](crate::cut()) copies, with the numbers that a cut would rewrite as they are in the whole stream.
///
/// Time is linear in the map.
///
/// # Errors
/// A [`Mismatch`] if the map contradicts itself ([`Unit::check`]), and if kept and dropped units meet
/// within a byte, as in streams whose units are bits (ABP-1, AFP-1): such a stream is cut, not fetched in
/// parts.
pub fn selected(map: &Unit, keeps: impl Fn(&Unit) -> bool) -> Result<ByteRanges, Mismatch> {
    map.check()?;
    let mut bits = ByteRanges::default();
    select(map, &keeps, &mut bits);
    let whole = |bit: u64| {
        let within = "kept and dropped units meet within a byte; such a stream can only be cut";
        match bit.is_multiple_of(8) {
            true => Ok(bit / 8),
            false => Err(Mismatch::new(format!("bit {bit}"), within)),
        }
    };
    let ranges = bits.ranges.iter();
    let ranges = ranges.map(|bits| Ok(whole(bits.start)?..whole(bits.end)?));
    Ok(ByteRanges {
        ranges: ranges.collect::<Result<_, Mismatch>>()?,
    })
}

/// Adds the bits of a unit that stays.
fn select(unit: &Unit, keeps: &impl Fn(&Unit) -> bool, bits: &mut ByteRanges) {
    let mut at = unit.bits.start;
    for child in &unit.children {
        if at < child.bits.start {
            bits.push(at..child.bits.start);
        }
        at = child.bits.end;
        if keeps(child) {
            select(child, keeps, bits);
        }
    }
    if at < unit.bits.end {
        bits.push(at..unit.bits.end);
    }
}

/// Returns the bytes that a client must fetch that has some bytes and wants others: those of `want` that
/// are not among `have`.
///
/// ```
/// use articula_stream::{ByteRanges, CutRule, Unit, difference, selected};
///
/// // A byte of its own, then units of tier 1, 0, 1.
/// let unit = |bytes, tier| Unit::of_bytes("unit", bytes).marked("tier", tier);
/// let map = Unit {
///     children: vec![unit(1..5, 1), unit(5..9, 0), unit(9..12, 1)],
///     ..Unit::of_bytes("packet", 0..12)
/// };
/// let coarse = CutRule::default().at_least("tier", 1);
/// let coarse = selected(&map, |unit| coarse.keeps(unit))?;
/// let first = difference(&ByteRanges::default(), &coarse);
/// assert_eq!(first.ranges(), [0..5, 9..12]);
/// let all = selected(&map, |_| true)?;
/// assert_eq!(difference(&first, &all), std::iter::once(5..9).collect());
/// assert_eq!(difference(&all, &coarse).bytes(), 0);
/// # Ok::<(), articula_core::Mismatch>(())
/// ```
pub fn difference(have: &ByteRanges, want: &ByteRanges) -> ByteRanges {
    let mut needed = ByteRanges::default();
    let mut have = have.ranges.iter().peekable();
    for range in &want.ranges {
        let mut at = range.start;
        while let Some(had) = have.peek().filter(|had| had.start < range.end) {
            if at < had.start {
                needed.push(at..had.start);
            }
            at = at.max(had.end);
            if had.end > range.end {
                break;
            }
            have.next();
        }
        if at < range.end {
            needed.push(at..range.end);
        }
    }
    needed
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cut::{CutRule, cut};
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    fn bytes(ranges: &ByteRanges) -> BTreeSet<u64> {
        ranges.ranges.iter().cloned().flatten().collect()
    }

    /// Whether ranges rise and do not touch.
    fn is_sound(ranges: &ByteRanges) -> bool {
        let ranges = &ranges.ranges;
        ranges.iter().all(|r| r.start < r.end) && ranges.windows(2).all(|w| w[0].end < w[1].start)
    }

    fn some_ranges() -> impl Strategy<Value = ByteRanges> {
        let range = (0_u64..60, 0_u64..9).prop_map(|(start, length)| start..start + length);
        prop::collection::vec(range, 0..9).prop_map(|ranges| ranges.into_iter().collect())
    }

    proptest! {
        #[test]
        fn ranges_are_sets_of_bytes(a in some_ranges(), b in some_ranges()) {
            let (union, more) = (a.union(&b), difference(&a, &b));
            prop_assert!([&a, &b, &union, &more].into_iter().all(is_sound));
            let (of_a, of_b) = (bytes(&a), bytes(&b));
            prop_assert_eq!(bytes(&union), &of_a | &of_b);
            prop_assert_eq!(bytes(&more), &of_b - &of_a);
            prop_assert_eq!(more.bytes(), (&of_b - &of_a).len() as u64);
        }

        #[test]
        fn a_selection_has_the_bytes_that_a_cut_copies(
            lengths in prop::collection::vec((0_usize..5, 0_usize..5, 0_u32..3), 1..12),
            most in 0_u32..3,
        ) {
            // Each byte is its own number.
            let mut at = 0;
            let mut children = Vec::new();
            for (gap, length, tier) in lengths {
                let start = at + gap;
                at = start + length;
                children.push(Unit::of_bytes("unit", start..at).marked("tier", tier));
            }
            let map = Unit { children, ..Unit::of_bytes("whole", 0..at + 1) };
            let stream: Vec<u8> = (0..=at as u8).collect();
            let rule = CutRule::default().at_most("tier", most);
            let cut = cut(&stream, &map, |unit| rule.keeps(unit)).unwrap();
            let kept = selected(&map, |unit| rule.keeps(unit)).unwrap();
            prop_assert!(is_sound(&kept));
            let kept = bytes(&kept).into_iter().map(|byte| byte as u8);
            prop_assert_eq!(kept.collect::<Vec<_>>(), cut.bytes);
        }
    }

    #[test]
    fn units_of_bits_are_refused_where_they_meet_within_a_byte() {
        let unit = |bits: Range<u64>, loa| Unit {
            bits,
            ..Unit::of_bytes("value", 0..0).marked("loa", loa)
        };
        let map = Unit {
            children: vec![unit(8..13, 0), unit(13..24, 1), unit(24..32, 2)],
            ..Unit::of_bytes("whole", 0..4)
        };
        let of = |loa| {
            let rule = CutRule::default().at_most("loa", loa);
            selected(&map, |unit| rule.keeps(unit))
        };
        assert_eq!(of(0).unwrap_err().at, "bit 13");
        assert_eq!(of(1).unwrap(), std::iter::once(0..3).collect());
        assert_eq!(of(2).unwrap(), std::iter::once(0..4).collect());
    }
}
