//! Shares of a list that the parts of a frame write independently.

use std::ops::Range;

/// A range of a list, and the space for what is written of it.
#[derive(Debug)]
pub(super) struct Share<'a, T> {
    pub range: Range<usize>,
    pub out: &'a mut [T],
}

/// What is left of a list that is split into shares.
pub(super) struct Rest<'a, T> {
    out: &'a mut [T],
    first: usize,
}

/// Which of the parts of a frame takes its share.
#[derive(Clone, Copy)]
pub(super) struct PartOf {
    /// Number of parts.
    pub parts: usize,
    pub is_last: bool,
}

impl<'a, T> Rest<'a, T> {
    pub(super) fn of(out: &'a mut [T]) -> Self {
        Self { out, first: 0 }
    }

    /// Takes the share of a part of a list of `all` entries, each of which is written as `size` values;
    /// what is left if it is the last.
    pub(super) fn take(&mut self, all: usize, size: usize, part: PartOf) -> Share<'a, T> {
        let end = if part.is_last {
            all
        } else {
            (self.first + all.div_ceil(part.parts)).min(all)
        };
        let range = self.first..end;
        self.first = end;
        let (out, others) = std::mem::take(&mut self.out).split_at_mut(range.len() * size);
        self.out = others;
        Share { range, out }
    }
}
