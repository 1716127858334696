//! Choice of the mesh level of one character: the coarsest whose error is within the tolerance.
//!
//! Source: `docs/methods/clustered-mesh.md` part 7. Rule and hysteresis are those of joint LODs
//! (`crate::crowd`): the error of a level in metres, times the pixels that one metre spans at the
//! character's nearest depth, is its error in pixels. Level 0 is the original. A level that is not
//! loaded cannot be shown.
//!
//! Pure functions over a table; only its construction allocates.

use crate::Mismatch;
use crate::level_choice::{level_range, level_within};
use crate::lod_error::lod_error_metres;

/// Errors of the levels of a mesh, by which a level is chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshErrors {
    /// From the original, whose error is 0, to the coarsest.
    levels_metres: Vec<f32>,
}

/// Mesh level chosen for a character.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshChoice {
    /// Level to draw now.
    pub level: usize,
    /// Level that would be drawn if it were loaded; to be requested from a stream.
    pub wanted: usize,
    /// Error of the level that is drawn, metres of the unscaled character.
    pub error_metres: f32,
}

impl MeshErrors {
    /// Takes the error of each level in metres, the original first. A level's error counts as at
    /// least that of every finer one.
    ///
    /// # Errors
    /// A [`Mismatch`] if there is no level, an error is negative or NaN, or the error of the first
    /// level, the original, is not 0. The error of an empty level may be infinite.
    pub fn new(levels_metres: &[f32]) -> Result<Self, Mismatch> {
        if let Some(l) = levels_metres.iter().position(|e| e.is_nan() || *e < 0.0) {
            let what = format!("must be at least 0 and not NaN, found {}", levels_metres[l]);
            return Err(Mismatch::new(format!("levels_metres[{l}]"), what));
        }
        if levels_metres.first() != Some(&0.0) {
            let what = "the first level is the original and must have error 0";
            return Err(Mismatch::new("levels_metres", what));
        }
        let mut greatest = 0.0f32;
        let rising = levels_metres.iter().map(|e| {
            greatest = greatest.max(*e);
            greatest
        });
        Ok(Self {
            levels_metres: rising.collect(),
        })
    }

    /// Computes the error of each level from two statistics, the 95th percentile over vertices and
    /// the maximum ([`lod_error_metres`]).
    ///
    /// # Errors
    /// As [`MeshErrors::new`], or if the lists differ in length.
    pub(crate) fn of_statistics(p95_metres: &[f32], max_metres: &[f32]) -> Result<Self, Mismatch> {
        if p95_metres.len() != max_metres.len() {
            let what = format!("{} levels, expected {}", max_metres.len(), p95_metres.len());
            return Err(Mismatch::new("max_metres", what));
        }
        let pairs = p95_metres.iter().zip(max_metres);
        let judged: Vec<f32> = pairs.map(|(p, m)| lod_error_metres(*p, *m)).collect();
        Self::new(&judged)
    }

    /// Errors of all levels, metres: at least 1, rising from the original's 0.
    pub fn levels_metres(&self) -> &[f32] {
        &self.levels_metres
    }

    /// Chooses the coarsest level within a tolerance in metres: tolerated pixels over pixels per
    /// metre, times the multiplier of attention.
    ///
    /// `shown` is the level that is drawn now: a coarser one is taken only when its error is below
    /// 0.8 of the tolerance, so that a character at the limit does not alternate between levels.
    /// `finest_loaded` limits [`MeshChoice::level`], not [`MeshChoice::wanted`].
    ///
    /// A NaN tolerance gives the original. O(levels).
    #[inline]
    pub fn choose(
        &self,
        tolerance_metres: f32,
        shown: Option<usize>,
        finest_loaded: usize,
    ) -> MeshChoice {
        let coarsest = self.levels_metres.len() - 1;
        let shown = shown.map(|level| level.min(coarsest));
        let wanted = level_within(tolerance_metres, shown, coarsest, |l| self.levels_metres[l]);
        let level = wanted.max(finest_loaded).min(coarsest);
        MeshChoice {
            level,
            wanted,
            error_metres: self.levels_metres[level],
        }
    }

    /// Returns the range of pixels per metre in which [`MeshErrors::choose`] keeps a level at a
    /// tolerance of `px` pixels: below it a coarser level is chosen, above it a finer one. A
    /// character whose size stays in the range needs no new choice.
    ///
    /// # Panics
    /// If there is no such level.
    #[inline]
    pub fn level_range(&self, level: usize, px: f32) -> [f32; 2] {
        level_range(&self.levels_metres, level, px)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn by_hand() {
        // 0, 2, 4 and 8 mm; 2 px at 500 px/m tolerate 4 mm.
        let errors = MeshErrors::new(&[0.0, 2e-3, 4e-3, 8e-3]).unwrap();
        let all = 0;
        let choose = |tolerance, shown, loaded| errors.choose(tolerance, shown, loaded);
        assert_eq!(choose(4e-3, None, all).level, 2);
        // From a finer level it is taken only with some slack: 4 mm are 0.8 of 5 mm.
        assert_eq!(choose(4e-3, Some(1), all).level, 1);
        assert_eq!(choose(5.01e-3, Some(1), all).level, 2);
        assert_eq!(choose(4e-3, Some(2), all).level, 2, "kept");
        assert_eq!(choose(3.9e-3, Some(2), all).level, 1, "too coarse");
        assert_eq!(choose(1.0, None, all).level, 3);
        assert_eq!(choose(f32::NAN, Some(3), all).level, 0);
        assert_eq!(choose(0.0, Some(9), all).level, 0);
        // Only the two coarsest are loaded.
        let capped = choose(1e-3, Some(2), 2);
        assert_eq!((capped.level, capped.wanted), (2, 0));
        assert_eq!(capped.error_metres, 4e-3);
        let [least, most] = errors.level_range(2, 2.0);
        assert!((least - 2.0 * 0.8 / 8e-3).abs() < 1e-3 && (most - 500.0).abs() < 1e-3);
    }

    #[test]
    fn what_is_no_table_of_errors() {
        let at = |levels: &[f32]| MeshErrors::new(levels).unwrap_err().at;
        assert_eq!(at(&[]), "levels_metres");
        assert_eq!(at(&[0.1]), "levels_metres");
        assert_eq!(at(&[0.0, f32::NAN, 0.1]), "levels_metres[1]");
        assert_eq!(at(&[0.0, -0.1]), "levels_metres[1]");
        let other = MeshErrors::of_statistics(&[0.0], &[]).unwrap_err();
        assert_eq!(other.at, "max_metres");
        let empty = MeshErrors::new(&[0.0, f32::INFINITY]).unwrap();
        assert_eq!(empty.choose(1e9, None, 0).level, 0);
        let odd = MeshErrors::new(&[0.0, 3.0, 1.0]).unwrap();
        assert_eq!(
            odd.levels_metres(),
            [0.0, 3.0, 3.0],
            "a coarser one is never better"
        );
        // 10 mm in a twentieth of the vertices, 30 mm in one finger: the finger decides.
        let both = MeshErrors::of_statistics(&[0.0, 0.01], &[0.0, 0.03]).unwrap();
        assert_eq!(both.levels_metres()[1], 0.015);
    }

    proptest! {
        #[test]
        fn the_coarsest_within_the_tolerance_and_never_to_and_fro(
            steps in prop::collection::vec(0.0f32..1.0, 1..8),
            tolerances in prop::collection::vec(0.0f32..4.0, 1..40),
            wobble in prop::collection::vec(0.9f32..1.1, 40),
        ) {
            let mut levels = vec![0.0];
            for step in &steps {
                levels.push(levels[levels.len() - 1] + step);
            }
            let errors = MeshErrors::new(&levels).unwrap();
            let mut shown = None;
            for tolerance in &tolerances {
                let fresh = errors.choose(*tolerance, None, 0);
                prop_assert!(fresh.error_metres <= *tolerance);
                let coarser = levels.get(fresh.level + 1);
                prop_assert!(coarser.is_none_or(|e| e > tolerance));
                let kept = errors.choose(*tolerance, shown, 0);
                prop_assert!(kept.error_metres <= *tolerance, "hysteresis only keeps finer");
                prop_assert!(kept.level <= fresh.level);
                shown = Some(kept.level);
            }
            // A size that varies by less than the hysteresis changes a level once at most.
            let mut level = errors.choose(1.0, shown, 0).level;
            let mut changes = 0;
            for tremble in &wobble {
                let next = errors.choose(*tremble, Some(level), 0).level;
                changes += u32::from(next != level);
                level = next;
            }
            prop_assert!(changes <= steps.len() as u32);
        }
    }
}
