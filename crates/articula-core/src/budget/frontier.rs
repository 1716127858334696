//! Where the budget ends in the list of all upgrades, best first, without sorting it.
//!
//! Greedy takes upgrades by falling gain per cost until the next one does not fit. The taken
//! ones are those above one key, and that key is found by three digits, as a radix sort would,
//! with the costs summed for each value of a digit. The sums of the first digit are kept from
//! frame to frame, so a change costs its own upgrades only.
//!
//! A key is a positive `f32` as its bits, which order as the numbers do; the sign bit, free in a
//! positive number, marks the upgrades that come first.

/// Bits of a key below its first digit.
const LOW_BITS: u32 = 19;
/// Bits of the second digit, then of the third.
const MIDDLE_BITS: u32 = 10;
const LAST_BITS: u32 = LOW_BITS - MIDDLE_BITS;
const BUCKETS: usize = 1 << (32 - LOW_BITS);

/// Sums of the costs of all upgrades by the first digit of their key, and the digit at which the
/// room ends.
#[derive(Debug, Clone)]
pub(super) struct Frontier {
    sums: Vec<u64>,
    bucket: usize,
    /// Cost of everything above that bucket.
    above: u64,
    middle: Vec<u64>,
    last: Vec<u64>,
}

/// The keys with one first digit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Span {
    pub(super) least: u32,
    pub(super) greatest: u32,
}

/// The last key that is taken, and the room for upgrades of just this key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Break {
    pub(super) key: u32,
    pub(super) room: u64,
}

impl Frontier {
    pub(super) fn new() -> Self {
        Self {
            sums: vec![0; BUCKETS],
            bucket: 0,
            above: 0,
            middle: vec![0; 1 << MIDDLE_BITS],
            last: vec![0; 1 << LAST_BITS],
        }
    }

    /// Forgets all upgrades.
    pub(super) fn clear(&mut self) {
        self.sums.fill(0);
        self.above = 0;
    }

    pub(super) fn add(&mut self, key: u32, cost: u32) {
        let bucket = (key >> LOW_BITS) as usize;
        self.sums[bucket] += u64::from(cost);
        self.above += u64::from(cost) * u64::from(bucket > self.bucket);
    }

    pub(super) fn remove(&mut self, key: u32, cost: u32) {
        let bucket = (key >> LOW_BITS) as usize;
        self.sums[bucket] -= u64::from(cost);
        self.above -= u64::from(cost) * u64::from(bucket > self.bucket);
    }

    /// Moves to the bucket in which the room ends, and gives its keys. If everything fits, it is
    /// the lowest one.
    pub(super) fn seek(&mut self, room: u64) -> Span {
        while self.above > room {
            self.bucket += 1;
            self.above -= self.sums[self.bucket];
        }
        while self.bucket > 0 && self.above + self.sums[self.bucket] <= room {
            self.above += self.sums[self.bucket];
            self.bucket -= 1;
        }
        let least = (self.bucket as u32) << LOW_BITS;
        Span {
            least: least.max(1),
            greatest: least | ((1 << LOW_BITS) - 1),
        }
    }

    /// The exact key at which the room ends. `upgrades` calls back with key and cost of every
    /// upgrade in the span that `seek` gave; it is asked twice.
    pub(super) fn find(
        &mut self,
        room: u64,
        mut upgrades: impl FnMut(&mut dyn FnMut(u32, u32)),
    ) -> Break {
        let mut room = room - self.above;
        self.middle.fill(0);
        let middle = &mut self.middle;
        let mask = (1 << MIDDLE_BITS) - 1;
        upgrades(&mut |key, cost| {
            middle[((key >> LAST_BITS) & mask) as usize] += u64::from(cost);
        });
        let high = ((self.bucket as u32) << MIDDLE_BITS) | descend(middle, &mut room);
        self.last.fill(0);
        let last = &mut self.last;
        upgrades(&mut |key, cost| {
            if key >> LAST_BITS == high {
                last[(key & ((1 << LAST_BITS) - 1)) as usize] += u64::from(cost);
            }
        });
        let key = (high << LAST_BITS) | descend(last, &mut room);
        Break { key, room }
    }
}

/// The highest digit whose sum does not fit any more, or the lowest of all; `room` loses what
/// lies above.
fn descend(sums: &[u64], room: &mut u64) -> u32 {
    for digit in (1..sums.len()).rev() {
        if sums[digit] > *room {
            return digit as u32;
        }
        *room -= sums[digit];
    }
    0
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Sorting and adding up: what the digits must agree with.
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
                let found = frontier.find(room, |each| {
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
