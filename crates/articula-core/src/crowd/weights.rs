//! Importance and scale of the characters of a section, by which a tolerance in pixels becomes one in
//! metres of the unscaled character.
//!
//! They are noted, so that levels that were chosen hold until one of them changes.

use super::frame::Frame;
use crate::attention::multiplier;

/// Characters that are compared at once.
const TOGETHER: usize = 64;

const ONES: [f32; TOGETHER] = [1.0; TOGETHER];

/// Importance and absolute scale of each character; empty while all are 1, so that a crowd without either
/// needs no memory for them.
#[derive(Debug, Clone, Default)]
pub(super) struct Weights {
    importance: Vec<f32>,
    scales: Vec<f32>,
    /// Maximum over the characters of the multiplier of the tolerance.
    most: f32,
}

impl Weights {
    /// Notes what a frame says about its `count` characters, and tells whose importance or scale has
    /// changed. Allocates in the first frame that has either.
    pub(super) fn update(&mut self, frame: &Frame<'_>, count: usize, mut tell: impl FnMut(usize)) {
        let is_changed = note(&mut self.importance, frame.importance, count, &mut tell);
        note(&mut self.scales, frame.scales, count, &mut tell);
        if is_changed {
            let all = self.importance.iter().map(|i| multiplier(1.0, *i));
            self.most = all.fold(0.0, f32::max);
        }
    }

    /// Factor of the tolerance of a character in metres.
    #[inline]
    pub(super) fn of(&self, character: usize) -> f32 {
        if self.importance.is_empty() && self.scales.is_empty() {
            return 1.0;
        }
        let scale = self.scales.get(character).map_or(1.0, |s| s.abs());
        self.multiplier(character) / scale
    }

    /// Number of tolerances by which a character may be off; 1 beyond the last.
    #[inline]
    pub(super) fn multiplier(&self, character: usize) -> f32 {
        let importance = self.importance.get(character);
        importance.map_or(1.0, |i| multiplier(1.0, *i))
    }

    /// Maximum number of tolerances by which a character may be off.
    pub(super) fn most_multiplier(&self) -> f32 {
        if self.importance.is_empty() {
            1.0
        } else {
            self.most
        }
    }
}

/// Notes numbers that are 1 where they are left out, and tells which have changed. Returns whether one
/// has.
fn note(noted: &mut Vec<f32>, now: &[f32], count: usize, tell: &mut impl FnMut(usize)) -> bool {
    if noted.is_empty() && now.is_empty() {
        return false;
    }
    noted.resize(count, 1.0);
    let mut is_changed = false;
    for (chunk, noted) in noted.chunks_mut(TOGETHER).enumerate() {
        let first = chunk * TOGETHER;
        let now = now.get(first..first + noted.len());
        let now = now.unwrap_or(&ONES[..noted.len()]);
        // Of all at once, so that compilers use vectors.
        let pairs = noted.iter().zip(now.iter());
        let differing = pairs.fold(0, |bits, (a, b)| bits | (a.to_bits() ^ b.to_bits()));
        if differing == 0 {
            continue;
        }
        is_changed = true;
        for (i, (noted, now)) in noted.iter_mut().zip(now).enumerate() {
            if noted.to_bits() != now.to_bits() {
                *noted = *now;
                tell(first + i);
            }
        }
    }
    is_changed
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crowd::{CacheUse, Culling, Detail, Moved};

    fn frame<'a>(importance: &'a [f32], scales: &'a [f32]) -> Frame<'a> {
        Frame {
            dt_secs: 0.0,
            positions: &[],
            rotations: &[],
            moved: Moved::All,
            scales,
            cull_margin_metres: &[],
            importance,
            culling: Culling::Off,
            detail: Detail::Full,
            cache: CacheUse::Never,
        }
    }

    /// Who has changed.
    fn told(weights: &mut Weights, importance: &[f32], scales: &[f32]) -> Vec<usize> {
        let mut told = Vec::new();
        weights.update(&frame(importance, scales), 130, |c| told.push(c));
        told
    }

    #[test]
    fn changes_are_told_once() {
        let mut weights = Weights::default();
        assert!(told(&mut weights, &[], &[]).is_empty());
        assert_eq!((weights.of(3), weights.most_multiplier()), (1.0, 1.0));
        let mut importance = [1.0; 130];
        importance[3] = 2.0;
        importance[129] = 0.5;
        assert_eq!(told(&mut weights, &importance, &[]), [3, 129]);
        assert!(told(&mut weights, &importance, &[]).is_empty());
        assert_eq!([0, 3, 129].map(|c| weights.of(c)), [1.0, 0.5, 2.0]);
        assert_eq!(weights.most_multiplier(), 2.0);
        let mut scales = [1.0; 130];
        scales[129] = -4.0;
        assert_eq!(told(&mut weights, &importance, &scales), [129]);
        assert_eq!(weights.of(129), 0.5);
        // Left out again, all are 1.
        assert_eq!(told(&mut weights, &[], &scales), [3, 129]);
        assert_eq!(told(&mut weights, &[], &[]), [129]);
        assert_eq!((weights.of(129), weights.most_multiplier()), (1.0, 1.0));
    }
}
