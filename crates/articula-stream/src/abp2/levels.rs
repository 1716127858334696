//! Levels of a track as binary decisions: the coarsest tier, and finer tiers by ternary digits.
//!
//! Form: `docs/formats/abp2.md`, part 6. A level of a finer plane is three times the coarser one
//! plus a digit of -1, 0 or 1, so that cells nest and each plane reconstructs at the middle of its
//! cells.
//!
//! One walk serves both directions: an encoder writes its arguments, a decoder returns what was
//! written.

use super::contexts::{Contexts, bucket, digit, digit_of_zero, flag, opposes};
use super::wavelet::Place;
use crate::range_coder::Coder;

/// Greatest magnitude of a level.
pub(super) const MOST_LEVEL: i32 = 1 << 24;
/// Most values at a time: the axes of a rotation, translation or scale.
const MOST_AXES: usize = 3;
/// Bucket of a value with no neighbour.
const ALONE: usize = 6;

/// The level of the next coarser plane.
pub(super) fn coarser(level: i32) -> i32 {
    (level + 1).div_euclid(3)
}

/// Magnitude of the value at a place that may be none; 0 then.
#[inline]
fn at(levels: &[i32], place: u32) -> u32 {
    levels
        .get(place as usize)
        .map_or(0, |level| level.unsigned_abs())
}

/// The levels of each axis.
#[inline]
fn rows<const AXES: usize>(levels: &mut [i32], frames: usize) -> [&mut [i32]; AXES] {
    let mut rows = levels.chunks_exact_mut(frames);
    std::array::from_fn(|_| rows.next().unwrap_or_default())
}

/// Codes the levels of the coarsest tier: `levels` has those of each axis one after the other, in
/// coded order; a decoder fills it in.
pub(super) fn code_coarsest<C: Coder>(
    coder: &mut C,
    contexts: &mut Contexts,
    places: &[Place],
    levels: &mut [i32],
) {
    if levels.len() == places.len() {
        coarsest_of::<C, 1>(coder, contexts, places, levels);
    } else {
        coarsest_of::<C, MOST_AXES>(coder, contexts, places, levels);
    }
}

fn coarsest_of<C: Coder, const AXES: usize>(
    coder: &mut C,
    contexts: &mut Contexts,
    places: &[Place],
    levels: &mut [i32],
) {
    let rows = rows::<AXES>(levels, places.len());
    let active: [bool; AXES] = std::array::from_fn(|axis| {
        let is_zero = rows[axis].iter().all(|level| *level == 0);
        !contexts.bit(coder, flag(0), is_zero)
    });
    for (i, place) in places.iter().enumerate() {
        let (mut others, mut other_weight) = (0, 0);
        for axis in 0..AXES {
            if !active[axis] {
                continue;
            }
            let mut sum = others;
            let mut weight = other_weight;
            for (neighbour, factor) in [(place.before, 2), (place.second, 1), (place.parent, 1)] {
                if neighbour != Place::NONE {
                    sum += factor * at(rows[axis], neighbour);
                    weight += factor;
                }
            }
            let factor = 1_703_936_u32.checked_div(weight);
            let q = factor.map_or(ALONE, |factor| {
                let mean = u64::from(sum.min(65_536)) * u64::from(factor);
                bucket(16 + (mean >> 16) as u32)
            });
            let level = &mut rows[axis][i];
            *level = contexts.value(coder, place.class, q, *level);
            others += level.unsigned_abs();
            other_weight += 1;
        }
    }
}

/// Codes the digits from one plane to the next finer one. `levels` has the levels of the coarser
/// plane and gets those of the finer one; `finer` has the latter for an encoder and is empty for a
/// decoder. Returns false if a level exceeds [`MOST_LEVEL`]; the levels are meaningless then.
pub(super) fn code_plane<C: Coder>(
    coder: &mut C,
    contexts: &mut Contexts,
    tier: usize,
    places: &[Place],
    levels: &mut [i32],
    finer: &[i32],
) -> bool {
    if levels.len() == places.len() {
        plane_of::<C, 1>(coder, contexts, tier, places, levels, finer)
    } else {
        plane_of::<C, MOST_AXES>(coder, contexts, tier, places, levels, finer)
    }
}

fn plane_of<C: Coder, const AXES: usize>(
    coder: &mut C,
    contexts: &mut Contexts,
    tier: usize,
    places: &[Place],
    levels: &mut [i32],
    finer: &[i32],
) -> bool {
    let frames = places.len();
    let rows = rows::<AXES>(levels, frames);
    let mut active = [true; AXES];
    for axis in 0..AXES {
        if rows[axis].iter().all(|level| *level == 0) {
            let stays = finer
                .get(axis * frames..(axis + 1) * frames)
                .is_some_and(|f| f.iter().all(|level| *level == 0));
            active[axis] = !contexts.bit(coder, flag(1), stays);
        } else if rows[axis]
            .iter()
            .any(|level| level.unsigned_abs() > MOST_LEVEL as u32)
        {
            return false;
        }
    }
    for (i, place) in places.iter().enumerate() {
        for axis in 0..AXES {
            if !active[axis] {
                continue;
            }
            let of_axis = &*rows[axis];
            let mut sum = 2 * at(of_axis, place.before)
                + at(of_axis, place.second)
                + at(of_axis, place.parent)
                + 3 * at(of_axis, i as u32 + 1);
            for (other, row) in rows.iter().enumerate() {
                if other != axis {
                    let known = row[i].unsigned_abs();
                    sum += if other < axis { known } else { 3 * known };
                }
            }
            let q = bucket(16 + 8 * sum.min(65_536));
            let coarse = of_axis[i];
            let digit = match finer.get(axis * frames + i) {
                Some(fine) if !C::READS => fine - 3 * coarse,
                _ => 0,
            };
            let digit = code_digit(coder, contexts, tier, q, coarse, digit);
            rows[axis][i] = 3 * coarse + digit;
        }
    }
    true
}

#[inline(always)]
fn code_digit(
    coder: &mut impl Coder,
    contexts: &mut Contexts,
    tier: usize,
    q: usize,
    coarse: i32,
    given: i32,
) -> i32 {
    let magnitude = coarse.unsigned_abs().min(3) as usize;
    if magnitude == 0 {
        if !contexts.bit(coder, digit_of_zero(tier, q), given != 0) {
            return 0;
        }
        return 1 - 2 * coder.raw(1, u32::from(given < 0)) as i32;
    }
    if !contexts.bit(coder, digit(tier, magnitude, q), given != 0) {
        return 0;
    }
    let against = contexts.bit(coder, opposes(tier, magnitude), (given < 0) != (coarse < 0));
    if against == (coarse < 0) { 1 } else { -1 }
}

#[cfg(test)]
mod tests {
    use super::super::wavelet::order;
    use super::*;
    use crate::range_coder::{Decoder, Encoder};
    use proptest::prelude::*;

    /// Levels of all axes at a plane.
    fn at_plane(levels: &[i32], plane: usize) -> Vec<i32> {
        let drop = |level: &i32| (0..plane).fold(*level, |level, _| coarser(level));
        levels.iter().map(drop).collect()
    }

    #[test]
    fn cells_nest() {
        let finest = [10, 49, 10, 1, 3];
        assert_eq!(at_plane(&finest, 1), [3, 16, 3, 0, 1]);
        assert_eq!(at_plane(&finest, 2), [1, 5, 1, 0, 0]);
        assert!((-50..50).all(|level| (level - 3 * coarser(level)).abs() <= 1));
    }

    /// Writes the coarsest plane and then the others with the given contexts, as in a file.
    fn written(levels: &[i32], frames: usize, planes: &[usize]) -> Vec<Vec<u8>> {
        let places = order(frames);
        let mut now = at_plane(levels, planes[0]);
        let mut coder = Encoder::new();
        code_coarsest(&mut coder, &mut Contexts::untrained(), &places, &mut now);
        let mut units = vec![coder.finish()];
        for (unit, pair) in planes.windows(2).enumerate() {
            let mut coder = Encoder::new();
            let mut contexts = Contexts::untrained();
            // The finest unit is tier 0.
            let tier = planes.len() - 2 - unit;
            for plane in (pair[1]..pair[0]).rev() {
                let finer = at_plane(levels, plane);
                assert!(code_plane(
                    &mut coder,
                    &mut contexts,
                    tier,
                    &places,
                    &mut now,
                    &finer
                ));
                assert_eq!(now, finer);
            }
            units.push(coder.finish());
        }
        units
    }

    #[test]
    fn one_joint_by_hand() {
        let mut levels = vec![0; 15];
        levels[..5].copy_from_slice(&[10, 49, 10, 1, 3]);
        assert_eq!(
            written(&levels, 5, &[2, 1, 0]),
            [vec![0x7b, 0x2e, 0x60], vec![0xb3], vec![0xe0, 0x80]]
        );
    }

    proptest! {
        #[test]
        fn every_plane_comes_back(
            frames in 2usize..40,
            axes in prop_oneof![Just(1usize), Just(3)],
            seed in prop::collection::vec(prop_oneof![Just(0i32), -4..4, -300_000..300_000], 120),
            planes in prop::collection::vec(0usize..3, 1..5),
        ) {
            let levels = &seed[..frames * axes];
            let mut planes: Vec<usize> = planes.iter().scan(0, |sum, p| { *sum += p; Some(*sum) }).collect();
            planes.insert(0, 0);
            planes.reverse();
            let units = written(levels, frames, &planes);
            let places = order(frames);
            let mut now = vec![0; levels.len()];
            let mut coder = Decoder::new(&units[0]);
            code_coarsest(&mut coder, &mut Contexts::untrained(), &places, &mut now);
            prop_assert_eq!(&now, &at_plane(levels, planes[0]));
            for (unit, pair) in planes.windows(2).enumerate() {
                let mut coder = Decoder::new(&units[1 + unit]);
                let mut contexts = Contexts::untrained();
                let tier = planes.len() - 2 - unit;
                for _ in pair[1]..pair[0] {
                    prop_assert!(code_plane(&mut coder, &mut contexts, tier, &places, &mut now, &[]));
                }
                prop_assert!(!coder.is_exhausted());
                prop_assert_eq!(&now, &at_plane(levels, pair[1]));
            }
        }
    }
}
