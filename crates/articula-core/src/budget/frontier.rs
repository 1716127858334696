//! Finds where the budget ends in the list of all upgrades, best first, without sorting it.
//!
//! The greedy method takes upgrades by falling gain per cost until the next one does not fit. The
//! upgrades taken are those above one key, which is found byte by byte, as in a radix sort, from
//! the costs summed for each value of a byte. The sums over the two high bytes are kept from frame
//! to frame, so a change costs only its own upgrades; they leave a span of keys that differ by less
//! than a hundredth, in which the upgrades are summed by the two low bytes.
//!
//! A key is the bits of a positive `f32`, which have the order of the numbers; the sign bit, free
//! in a positive number, marks the upgrades that come first.

const BYTE: usize = 256;

/// Sums of the costs of all upgrades by the high bytes of their keys.
#[derive(Debug, Clone)]
pub(super) struct Frontier {
    by_first: Vec<u64>,
    /// By both, the first byte times 256 plus the second.
    by_second: Vec<u64>,
}

/// The keys with the same high bytes, and the budget left for them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Span {
    pub(super) least: u32,
    pub(super) greatest: u32,
    pub(super) room: u64,
}

/// The lowest key that is taken, and the budget left for upgrades of exactly this key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Break {
    pub(super) key: u32,
    pub(super) room: u64,
}

impl Frontier {
    pub(super) fn new() -> Self {
        Self {
            by_first: vec![0; BYTE],
            by_second: vec![0; BYTE * BYTE],
        }
    }

    /// Removes all upgrades.
    pub(super) fn clear(&mut self) {
        self.by_first.fill(0);
        self.by_second.fill(0);
    }

    pub(super) fn add(&mut self, key: u32, cost: u32) {
        self.by_first[(key >> 24) as usize] += u64::from(cost);
        self.by_second[(key >> 16) as usize] += u64::from(cost);
    }

    pub(super) fn remove(&mut self, key: u32, cost: u32) {
        self.by_first[(key >> 24) as usize] -= u64::from(cost);
        self.by_second[(key >> 16) as usize] -= u64::from(cost);
    }

    /// Returns the span in which the budget ends; the lowest one if everything fits.
    pub(super) fn seek(&self, mut room: u64) -> Span {
        let first = descend(&self.by_first, &mut room);
        let second = descend(&self.by_second[first * BYTE..][..BYTE], &mut room);
        let least = ((first * BYTE + second) as u32) << 16;
        Span {
            least: least.max(1),
            greatest: least | 0xffff,
            room,
        }
    }
}

impl Span {
    /// Returns the exact key at which the budget ends. `upgrades` calls back with key and cost of
    /// every upgrade of the span; it is called twice.
    pub(super) fn find(mut self, upgrades: impl Fn(&mut dyn FnMut(u32, u32))) -> Break {
        let mut sums = [0; BYTE];
        upgrades(&mut |key, cost| sums[(key >> 8 & 0xff) as usize] += u64::from(cost));
        let third = descend(&sums, &mut self.room);
        let mut sums = [0; BYTE];
        upgrades(&mut |key, cost| {
            if (key >> 8 & 0xff) as usize == third {
                sums[(key & 0xff) as usize] += u64::from(cost);
            }
        });
        let fourth = descend(&sums, &mut self.room);
        Break {
            key: self.greatest & !0xffff | (third * BYTE + fourth) as u32,
            room: self.room,
        }
    }
}

/// Returns the highest byte whose sum no longer fits, or 0; subtracts the sums above it from
/// `room`.
fn descend(sums: &[u64], room: &mut u64) -> usize {
    for byte in (1..sums.len()).rev() {
        if sums[byte] > *room {
            return byte;
        }
        *room -= sums[byte];
    }
    0
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The plain version by sorting and adding.
    fn plain(upgrades: &[(u32, u32)], mut room: u64) -> (Vec<u32>, u64) {
        let mut sorted = upgrades.to_vec();
        sorted.sort_by_key(|u| std::cmp::Reverse(u.0));
        let mut taken = Vec::new();
        // All upgrades of one key are taken or none: the caller deals with ties.
        for group in sorted.chunk_by(|a, b| a.0 == b.0) {
            let cost: u64 = group.iter().map(|u| u64::from(u.1)).sum();
            if cost > room {
                break;
            }
            room -= cost;
            taken.push(group[0].0);
        }
        (taken, room)
    }

    proptest! {
        #[test]
        fn agrees_with_sorting(
            upgrades in prop::collection::vec((1_u32..0xff7f_ffff, 0_u32..1000), 0..60),
            shared in prop::collection::vec((0x3f80_0000_u32..0x3f80_0010, 0_u32..1000), 0..60),
            rooms in prop::collection::vec(0_u64..60_000, 1..6),
        ) {
            let all: Vec<(u32, u32)> = upgrades.into_iter().chain(shared).collect();
            let mut frontier = Frontier::new();
            all.iter().for_each(|u| frontier.add(u.0, u.1));
            for room in rooms {
                let span = frontier.seek(room);
                let found = span.find(|each| {
                    all.iter().filter(|u| u.0 >= span.least && u.0 <= span.greatest)
                        .for_each(|u| each(u.0, u.1));
                });
                let (taken, left) = plain(&all, room);
                for (key, _) in &all {
                    // The break's own key counts as not taken here, unless all of it fits.
                    let fits = taken.contains(key);
                    let right = if *key > found.key { fits } else { *key == found.key || !fits };
                    prop_assert!(right);
                }
                let ties: u64 = all.iter().filter(|u| u.0 == found.key).map(|u| u64::from(u.1)).sum();
                let rest = if taken.contains(&found.key) { found.room - ties } else { found.room };
                prop_assert_eq!(rest, left);
            }
        }
    }

    #[test]
    fn what_was_removed_is_gone() {
        let mut frontier = Frontier::new();
        let key = 2.0_f32.to_bits();
        frontier.add(key, 10);
        frontier.add(1.0_f32.to_bits(), 10);
        assert!(frontier.seek(5).least <= key && frontier.seek(5).greatest >= key);
        frontier.remove(key, 10);
        assert!(frontier.seek(5).greatest < key);
        assert_eq!(frontier.seek(10).least, 1, "all fits");
    }
}
