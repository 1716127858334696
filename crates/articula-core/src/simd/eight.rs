//! Slices of one length, one for each lane.
#![expect(
    unsafe_code,
    reason = "one check of an index instead of eight; the lengths are those of the constructor"
)]

use super::LANES;

/// Parts of a slice, one for each lane and all of one length, so that one check of an index holds
/// for every lane.
pub(crate) struct Eight<'a, T> {
    parts: [&'a [T]; LANES],
    len: usize,
}

impl<'a, T> Eight<'a, T> {
    /// The parts of `len` elements from each of the `starts`.
    ///
    /// # Panics
    /// If a part reaches beyond the slice.
    #[inline(always)]
    pub(crate) fn new(all: &'a [T], starts: [usize; LANES], len: usize) -> Self {
        Self {
            parts: std::array::from_fn(|lane| &all[starts[lane]..][..len]),
            len,
        }
    }

    /// The element at an index of every part.
    ///
    /// # Panics
    /// If the parts are shorter.
    #[inline(always)]
    pub(crate) fn at(&self, index: usize) -> [&'a T; LANES] {
        assert!(index < self.len, "the index must lie within the parts");
        // SAFETY: every part has `len` elements, and the index was just found to be below it.
        std::array::from_fn(|lane| unsafe { self.parts[lane].get_unchecked(index) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn parts_are_those_of_the_slice(
            starts in prop::array::uniform8(0usize..20),
            len in 1usize..12,
            index in 0usize..12,
        ) {
            let all: Vec<usize> = (100..132).collect();
            let eight = Eight::new(&all, starts, len);
            let found = std::panic::catch_unwind(|| eight.at(index).map(|v| *v));
            if index < len {
                prop_assert_eq!(found.unwrap(), starts.map(|s| 100 + s + index));
            } else {
                prop_assert!(found.is_err());
            }
        }
    }

    #[test]
    #[should_panic(expected = "range end index 5 out of range")]
    fn parts_end_with_the_slice() {
        Eight::new(&[0; 9], [5, 4, 3, 2, 1, 0, 0, 5], 5);
    }
}
