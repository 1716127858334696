//! Slices of one length, one for each lane.
#![expect(
    unsafe_code,
    reason = "one check of an index instead of one for each lane; the lengths are those of the constructor"
)]

use std::marker::PhantomData;

/// Parts of a slice, one for each lane and all of one length, so that one check of an index holds
/// for every lane.
pub(crate) struct Parts<'a, T, const W: usize> {
    /// First elements of the parts, of which each has `len`.
    starts: [*const T; W],
    len: usize,
    all: PhantomData<&'a [T]>,
}

impl<'a, T, const W: usize> Parts<'a, T, W> {
    /// The parts of `len` elements from each of the `starts`.
    ///
    /// # Panics
    /// If a part reaches beyond the slice.
    #[inline(always)]
    pub(crate) fn new(all: &'a [T], starts: [usize; W], len: usize) -> Self {
        let mut last = 0;
        for start in starts {
            last = last.max(start);
        }
        let whole = last <= all.len() && len <= all.len() - last;
        assert!(whole, "the parts must lie within the slice");
        Self {
            // SAFETY: no start is beyond the last one, which lies within the slice or at its end.
            starts: std::array::from_fn(|lane| unsafe { all.as_ptr().add(starts[lane]) }),
            len,
            all: PhantomData,
        }
    }

    /// The element at an index of every part.
    ///
    /// # Panics
    /// If the parts are shorter.
    #[inline(always)]
    pub(crate) fn at(&self, index: usize) -> [&'a T; W] {
        assert!(index < self.len, "the index must lie within the parts");
        // SAFETY: every part has `len` elements of the slice, as was checked when it was made, and the
        // index was just found to be below it.
        std::array::from_fn(|lane| unsafe { &*self.starts[lane].add(index) })
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
            let parts = Parts::new(&all, starts, len);
            let found = std::panic::catch_unwind(|| parts.at(index).map(|v| *v));
            if index < len {
                prop_assert_eq!(found.unwrap(), starts.map(|s| 100 + s + index));
            } else {
                prop_assert!(found.is_err());
            }
        }
    }

    #[test]
    #[should_panic(expected = "the parts must lie within the slice")]
    fn parts_end_with_the_slice() {
        Parts::new(&[0; 9], [5, 4, 3, 2, 1, 0, 0, 5], 5);
    }
}
