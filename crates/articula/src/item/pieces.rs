//! Bytes of a file that arrive in any order.

use crate::error::{Error, Result};
use articula_stream::{ByteRanges, difference};
use std::ops::Range;

/// The bytes of a file that are there.
#[derive(Debug, Clone, Default)]
pub(super) struct Pieces {
    length: u64,
    /// Up to the last byte that is there; zero where none is.
    bytes: Vec<u8>,
    there: ByteRanges,
}

impl Pieces {
    /// None of a file of this length.
    pub(super) fn of_length(length: u64) -> Self {
        Self {
            length,
            ..Self::default()
        }
    }

    /// Takes bytes from byte `offset` on; returns the ranges that were not there. What was there stays.
    pub(super) fn put(&mut self, offset: u64, bytes: &[u8]) -> Result<ByteRanges> {
        let end = offset.checked_add(bytes.len() as u64);
        let Some(end) = end.filter(|end| *end <= self.length) else {
            let what = format!(
                "{} bytes from byte {offset} on, but the file has {}",
                bytes.len(),
                self.length
            );
            return Err(Error::argument(what));
        };
        let given: ByteRanges = std::iter::once(offset..end).collect();
        let new = difference(&self.there, &given);
        self.bytes.resize(self.bytes.len().max(end as usize), 0);
        for range in new.ranges() {
            let from = within(offset, range);
            self.bytes[place(range)].copy_from_slice(&bytes[from]);
        }
        self.there = self.there.union(&new);
        Ok(new)
    }

    /// Gives all bytes up.
    pub(super) fn clear(&mut self) {
        *self = Self::of_length(self.length);
    }

    /// The ranges that are there.
    pub(super) fn there(&self) -> &ByteRanges {
        &self.there
    }

    /// The bytes of a range, if all are there.
    pub(super) fn get(&self, range: &Range<u64>) -> Option<&[u8]> {
        let mut held = self.there.ranges().iter();
        let is_there = held.any(|held| held.start <= range.start && range.end <= held.end);
        is_there.then(|| &self.bytes[place(range)])
    }

    /// The bytes from the first on, as far as they are there without a gap.
    pub(super) fn start(&self) -> &[u8] {
        let first = self.there.ranges().first().filter(|first| first.start == 0);
        first.map_or(&[], |first| &self.bytes[place(first)])
    }

    /// All bytes, if they are there.
    pub(super) fn whole(&self) -> Option<&[u8]> {
        let start = self.start();
        (start.len() as u64 == self.length).then_some(start)
    }

    /// The bytes of each range that is there.
    pub(super) fn all(&self) -> impl Iterator<Item = (u64, &[u8])> {
        let ranges = self.there.ranges().iter();
        ranges.map(|range| (range.start, &self.bytes[place(range)]))
    }
}

/// Where a range of a file is in its bytes, of which there are as many as memory holds.
fn place(range: &Range<u64>) -> Range<usize> {
    range.start as usize..range.end as usize
}

/// Where a range of a file is in bytes from `offset` on.
fn within(offset: u64, range: &Range<u64>) -> Range<usize> {
    place(&(range.start - offset..range.end - offset))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_in_any_order_and_again() {
        let mut pieces = Pieces::of_length(10);
        let ranges = |found: ByteRanges| found.ranges().to_vec();
        assert_eq!(pieces.put(4, b"efg").unwrap().bytes(), 3);
        assert!(pieces.start().is_empty() && pieces.get(&(5..7)) == Some(b"fg"));
        // What is there stays.
        assert_eq!(ranges(pieces.put(2, b"cdEFGhi").unwrap()), [2..4, 7..9]);
        assert_eq!(pieces.get(&(2..9)), Some(&b"cdefghi"[..]));
        assert!(pieces.get(&(8..10)).is_none() && pieces.whole().is_none());
        pieces.put(9, b"j").unwrap();
        pieces.put(0, b"ab").unwrap();
        assert_eq!(pieces.whole(), Some(&b"abcdefghij"[..]));
        assert!(pieces.put(9, b"jk").is_err() && pieces.put(u64::MAX, b"a").is_err());
        pieces.clear();
        pieces.put(3, b"d").unwrap();
        pieces.put(7, b"hi").unwrap();
        let there: Vec<_> = pieces.all().collect();
        assert_eq!(there, [(3, &b"d"[..]), (7, b"hi")]);
    }
}
