//! Sets of joints of one rig, as bit sets.

use std::fmt;

/// Maximum number of joints of a rig; building a larger one is an error.
pub const MAX_JOINTS: usize = 1024;

const WORDS: usize = MAX_JOINTS / 64;

/// A set of joint indices below [`MAX_JOINTS`]. Copying and combining sets does not allocate.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct JointSet {
    words: [u64; WORDS],
}

impl JointSet {
    /// The empty set.
    pub const EMPTY: Self = Self { words: [0; WORDS] };

    /// Returns the set of the first `count` joints.
    ///
    /// # Panics
    /// If `count` exceeds [`MAX_JOINTS`].
    pub fn first(count: usize) -> Self {
        assert!(count <= MAX_JOINTS, "a rig has at most {MAX_JOINTS} joints");
        let mut set = Self::EMPTY;
        for (w, word) in set.words.iter_mut().enumerate() {
            let bits = count.saturating_sub(w * 64).min(64);
            *word = if bits == 64 {
                u64::MAX
            } else {
                (1 << bits) - 1
            };
        }
        set
    }

    /// Returns whether `joint` is in the set; false for any index beyond [`MAX_JOINTS`].
    pub fn contains(&self, joint: usize) -> bool {
        joint < MAX_JOINTS && self.words[joint / 64] >> (joint % 64) & 1 == 1
    }

    /// Adds one joint.
    ///
    /// # Panics
    /// If `joint` is not below [`MAX_JOINTS`].
    pub fn insert(&mut self, joint: usize) {
        self.words[joint / 64] |= 1 << (joint % 64);
    }

    /// Removes one joint.
    ///
    /// # Panics
    /// If `joint` is not below [`MAX_JOINTS`].
    pub fn remove(&mut self, joint: usize) {
        self.words[joint / 64] &= !(1 << (joint % 64));
    }

    /// Returns the joints in either set.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        self.zip(other, |a, b| a | b)
    }

    /// Returns the joints in both sets.
    #[must_use]
    pub fn intersection(&self, other: &Self) -> Self {
        self.zip(other, |a, b| a & b)
    }

    /// Returns the joints of this set that are not in `other`.
    #[must_use]
    pub fn difference(&self, other: &Self) -> Self {
        self.zip(other, |a, b| a & !b)
    }

    /// Returns whether the sets have no joint in common.
    pub(crate) fn is_disjoint(&self, other: &Self) -> bool {
        let mut words = self.words.iter().zip(&other.words);
        words.all(|(a, b)| a & b == 0)
    }

    /// Returns the number of joints in the set.
    pub fn len(&self) -> usize {
        self.words.iter().map(|w| w.count_ones() as usize).sum()
    }

    /// Returns whether the set is empty.
    pub fn is_empty(&self) -> bool {
        self.words.iter().all(|w| *w == 0)
    }

    /// Iterates over the joints in ascending order.
    pub fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        self.words.iter().enumerate().flat_map(|(w, word)| {
            let mut rest = *word;
            std::iter::from_fn(move || {
                (rest != 0).then(|| {
                    let bit = rest.trailing_zeros() as usize;
                    rest &= rest - 1;
                    w * 64 + bit
                })
            })
        })
    }

    fn zip(&self, other: &Self, op: impl Fn(u64, u64) -> u64) -> Self {
        let mut words = [0; WORDS];
        for ((out, a), b) in words.iter_mut().zip(&self.words).zip(&other.words) {
            *out = op(*a, *b);
        }
        Self { words }
    }
}

impl FromIterator<usize> for JointSet {
    fn from_iter<I: IntoIterator<Item = usize>>(joints: I) -> Self {
        let mut set = Self::EMPTY;
        set.extend(joints);
        set
    }
}

impl Extend<usize> for JointSet {
    fn extend<I: IntoIterator<Item = usize>>(&mut self, joints: I) {
        for joint in joints {
            self.insert(joint);
        }
    }
}

impl Default for JointSet {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl fmt::Debug for JointSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.iter()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    fn joints() -> impl Strategy<Value = BTreeSet<usize>> {
        prop::collection::btree_set(0..MAX_JOINTS, 0..200)
    }

    proptest! {
        #[test]
        fn agrees_with_a_plain_set(a in joints(), b in joints()) {
            let (sa, sb): (JointSet, JointSet) =
                (a.iter().copied().collect(), b.iter().copied().collect());
            let list = |s: JointSet| s.iter().collect::<Vec<_>>();
            prop_assert_eq!(list(sa.union(&sb)), a.union(&b).copied().collect::<Vec<_>>());
            prop_assert_eq!(list(sa.intersection(&sb)), a.intersection(&b).copied().collect::<Vec<_>>());
            prop_assert_eq!(list(sa.difference(&sb)), a.difference(&b).copied().collect::<Vec<_>>());
            prop_assert_eq!(sa.len(), a.len());
            prop_assert_eq!(sa.difference(&sb).is_empty(), a.is_subset(&b));
            prop_assert_eq!(sa.is_disjoint(&sb), a.is_disjoint(&b));
        }

        #[test]
        fn first_is_a_range(count in 0..=MAX_JOINTS) {
            prop_assert_eq!(JointSet::first(count), (0..count).collect());
        }
    }
}
