//! Morph levels of a crowd's character: how many of the morph targets that move are shown.
//!
//! Source: `docs/methods/runtime.md` 4.2. The targets are in one order, those first that cost most
//! when they are left out; a level shows a prefix of it. Targets that are left out keep their
//! default weights.

use crate::Mismatch;

/// Morph levels of a character with their errors; 0 is the finest and shows all targets.
#[derive(Debug, Clone, PartialEq)]
pub struct MorphLods {
    /// Targets that move in any clip.
    order: Vec<u16>,
    /// Number of targets of each level.
    counts: Vec<u16>,
    /// Error of each level in metres, level by level for each clip.
    errors_metres: Vec<f32>,
}

impl MorphLods {
    /// Maximum number of levels.
    pub const MAX_LEVELS: usize = 8;

    /// Levels that show the first `counts[level]` targets of `order`, from all of them to the fewest,
    /// with their errors in metres for each clip.
    ///
    /// An error is that of [`lod_error_metres`](crate::lod_error_metres): the larger of the 95th
    /// percentile over vertices and half of their maximum.
    ///
    /// # Errors
    /// A [`Mismatch`] if there is no level or more than [`MAX_LEVELS`](Self::MAX_LEVELS), the first
    /// does not show all targets, numbers of targets do not fall, or errors are negative, fall, or
    /// are not one for each level.
    pub fn new(
        order: Vec<u16>,
        counts: Vec<u16>,
        errors_metres: &[Vec<f32>],
    ) -> Result<Self, Mismatch> {
        let is_whole = counts.first().map(|c| usize::from(*c)) == Some(order.len());
        let fall = counts.windows(2).all(|pair| pair[0] > pair[1]);
        if !is_whole || !fall || counts.len() > Self::MAX_LEVELS {
            let what = format!(
                "levels must show fewer and fewer of the {} targets, beginning with all, and be at most {}",
                order.len(),
                Self::MAX_LEVELS
            );
            return Err(Mismatch::new("counts", what));
        }
        for (clip, errors) in errors_metres.iter().enumerate() {
            let rise = errors.windows(2).all(|pair| pair[0] <= pair[1]);
            let is_error = errors.iter().all(|e| *e >= 0.0 && e.is_finite());
            if errors.len() != counts.len() || !rise || !is_error {
                let what = format!("expected {} errors that do not fall", counts.len());
                return Err(Mismatch::new(format!("errors[{clip}]"), what));
            }
        }
        Ok(Self {
            order,
            counts,
            errors_metres: errors_metres.concat(),
        })
    }

    /// One level that shows all targets.
    pub(crate) fn whole(order: Vec<u16>, clips: usize) -> Self {
        Self {
            counts: vec![order.len() as u16],
            errors_metres: vec![0.0; clips],
            order,
        }
    }

    /// Number of levels, at least 1.
    pub fn levels(&self) -> usize {
        self.counts.len()
    }

    /// Number of targets that a level shows.
    ///
    /// # Panics
    /// If there is no such level.
    #[inline]
    pub fn count(&self, level: usize) -> usize {
        usize::from(self.counts[level])
    }

    /// The targets that move in any clip, those first that cost most when they are left out.
    pub fn order(&self) -> &[u16] {
        &self.order
    }

    /// Errors of all levels in a clip, in metres.
    ///
    /// # Panics
    /// If there is no such clip.
    #[inline]
    pub fn errors_metres(&self, clip: usize) -> &[f32] {
        &self.errors_metres[clip * self.levels()..][..self.levels()]
    }

    /// Number of clips.
    pub(crate) fn clips(&self) -> usize {
        self.errors_metres.len() / self.levels()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn made(counts: &[u16], errors: &[f32]) -> Result<MorphLods, Mismatch> {
        let errors = [errors.to_vec(), vec![0.0; counts.len()]];
        MorphLods::new(vec![7, 2, 5], counts.to_vec(), &errors)
    }

    #[test]
    fn levels_are_prefixes_with_an_error_for_each_clip() {
        let lods = made(&[3, 1, 0], &[0.0, 0.01, 0.02]).unwrap();
        assert_eq!((lods.levels(), lods.clips()), (3, 2));
        assert_eq!([0, 1, 2].map(|level| lods.count(level)), [3, 1, 0]);
        assert_eq!(lods.errors_metres(0), [0.0, 0.01, 0.02]);
        assert_eq!(lods.errors_metres(1), [0.0; 3]);
        let whole = MorphLods::whole(vec![7, 2, 5], 2);
        assert_eq!((whole.levels(), whole.count(0), whole.clips()), (1, 3, 2));
    }

    #[test]
    fn what_are_no_levels_is_refused() {
        for counts in [&[][..], &[2, 1], &[3, 3], &[3, 1, 2]] {
            let errors = vec![0.0; counts.len()];
            assert_eq!(made(counts, &errors).unwrap_err().at, "counts");
        }
        for errors in [&[0.0][..], &[0.0, -1.0], &[0.1, 0.0], &[0.0, f32::NAN]] {
            assert_eq!(made(&[3, 0], errors).unwrap_err().at, "errors[0]");
        }
        let many: Vec<u16> = (0..9).rev().collect();
        let errors = vec![0.0; many.len()];
        let made = MorphLods::new((0..8).collect(), many, &[errors]);
        assert_eq!(made.unwrap_err().at, "counts");
    }
}
