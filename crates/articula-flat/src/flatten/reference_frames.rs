//! Reference pictures of the character at sampled times, for measuring the written file.
//!
//! Source: `docs/methods/vector.md` 9 and 11: every tenth frame and times halfway between frames,
//! against the 8 x 8 supersampled picture, over the pixels that show the character.

use super::source_frames::{BACKGROUND, SourceFrames};
use crate::compare::{masked_rmse, share_off, ssim};
use crate::item_buffer::Supersampling;
use crate::local_difference::LocalDifferences;
use crate::picture::Picture;
use crate::planar::reference::reference_with_mask;
use crate::planar::{PlanarClip, PlanarError};
use articula_core::Progress;

/// Difference above which a pixel counts as off, levels.
const OFF: f32 = 16.0;
/// Frames between two sampled times.
const STEP: usize = 10;
/// Maximum number of sampled times of each kind.
const MOST: usize = 16;

/// Returns the sampled times of a clip, in frames: every tenth frame (fewer of a long clip) and
/// times halfway between two frames. The last frame is left out, since the clip begins again there.
pub fn sampled_frames(frames: usize) -> Vec<f64> {
    let step = STEP.max(frames.div_ceil(MOST));
    let last = frames.saturating_sub(1) as f64;
    let whole = (0..frames.saturating_sub(1).max(1)).step_by(step);
    let whole = whole.map(|f| f as f64);
    let half = (step / 2..frames).step_by(step).map(|f| f as f64 + 0.5);
    let mut all: Vec<f64> = whole.chain(half.filter(|f| *f < last)).collect();
    all.sort_by(f64::total_cmp);
    all
}

/// Reference pictures of the character at sampled times.
#[derive(Debug, Clone, PartialEq)]
pub struct ReferenceFrames {
    moments: Vec<Moment>,
    source: Option<SourceFrames>,
}

#[derive(Debug, Clone, PartialEq)]
struct Moment {
    frame: f64,
    picture: Picture,
    mask: Vec<bool>,
}

/// Image error over all sampled times.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ImageError {
    /// Root mean square error over the character's pixels, mean over the sampled times; levels.
    pub rmse_levels: f64,
    /// Root mean square error at the worst time; levels.
    pub rmse_levels_max: f64,
    /// Structural similarity, mean over the sampled times; 1 is equal.
    pub ssim: f64,
    /// Structural similarity at the worst time.
    pub ssim_min: f64,
    /// Pixels of the character that are off by more than 16 levels, mean; percent.
    pub off_percent: f64,
    /// Number of sampled times.
    pub moments: usize,
    /// Largest local differences from the character itself, if its pictures are known
    /// ([`ReferenceFrames::with_source`]).
    pub local: Option<LocalDifferences>,
}

impl ReferenceFrames {
    /// Renders the reference pictures; `clip` has one frame for each of `frames`, seen by the same
    /// camera.
    ///
    /// # Errors
    /// [`PlanarError`] if the clip is invalid or has a different number of frames.
    pub fn new(clip: &PlanarClip, frames: &[f64]) -> Result<Self, PlanarError> {
        clip.check()?;
        if clip.frames.len() != frames.len() {
            let (found, expected) = (clip.frames.len(), frames.len());
            return Err(PlanarError::Mismatch {
                at: "frames",
                what: format!("the clip has {found} frames, expected {expected}"),
            });
        }
        let moment = |(f, frame): (usize, &f64)| {
            let (picture, mask) = reference_with_mask(clip, f, Supersampling::Eight, BACKGROUND)?;
            Ok(Moment {
                frame: *frame,
                picture,
                mask,
            })
        };
        let moments: Result<_, PlanarError> = frames.iter().enumerate().map(moment).collect();
        Ok(Self {
            moments: moments?,
            source: None,
        })
    }

    /// Adds pictures of the character itself, from which local differences are measured at those of
    /// the sampled times that both have.
    #[must_use]
    pub fn with_source(self, source: SourceFrames) -> Self {
        Self {
            source: Some(source),
            ..self
        }
    }

    /// The sampled times that are whole frames.
    pub(super) fn whole_frames(&self) -> Vec<usize> {
        let whole = self.moments.iter().filter(|m| m.frame.fract() == 0.0);
        whole.map(|m| m.frame as usize).collect()
    }

    /// Compares with the pictures that `shown` returns for a time in frames.
    ///
    /// # Errors
    /// Errors of `shown` or of a comparison; [`PlanarError::Cancelled`].
    pub(super) fn compare(
        &self,
        mut shown: impl FnMut(f64) -> Result<Picture, PlanarError>,
        progress: &mut Progress<'_>,
    ) -> Result<ImageError, PlanarError> {
        let mut all = ImageError {
            ssim_min: 1.0,
            moments: self.moments.len(),
            ..ImageError::default()
        };
        let count = self.moments.len().max(1) as f64;
        for (m, moment) in self.moments.iter().enumerate() {
            let picture = shown(moment.frame)?;
            let rmse = masked_rmse(&picture, &moment.picture, &moment.mask)?;
            let alike = ssim(&picture, &moment.picture)?;
            let off = share_off(&picture, &moment.picture, &moment.mask, OFF)?;
            all.rmse_levels += rmse / count;
            all.rmse_levels_max = all.rmse_levels_max.max(rmse);
            all.ssim += alike / count;
            all.ssim_min = all.ssim_min.min(alike);
            all.off_percent += 100.0 * off / count;
            if let Some(source) = &self.source {
                let known = source.at(moment.frame);
                let local = known
                    .map(|index| source.compare(index, &picture))
                    .transpose()?;
                all.local
                    .get_or_insert_default()
                    .add(&local.unwrap_or_default());
            }
            progress.step((m + 1) as f32 / count as f32)?;
        }
        Ok(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planar::clip::fixture;
    use crate::planar::reference::reference;

    #[test]
    fn every_tenth_frame_and_halves_between() {
        let frames = sampled_frames(25);
        assert_eq!(frames, [0.0, 5.5, 10.0, 15.5, 20.0]);
        assert_eq!(sampled_frames(21), [0.0, 5.5, 10.0, 15.5]);
        assert_eq!(sampled_frames(1), [0.0]);
        assert!(sampled_frames(100_000).len() <= 2 * MOST);
    }

    #[test]
    fn the_truth_is_like_itself_and_a_shifted_one_is_not() {
        let cube = fixture::turning_cube(3);
        let truth = ReferenceFrames::new(&cube, &[0.0, 1.0, 2.0]).unwrap();
        let of = |f: f64| {
            Ok(reference(
                &cube,
                f as usize,
                Supersampling::Eight,
                BACKGROUND,
            )?)
        };
        let same = truth.compare(of, &mut Progress::none()).unwrap();
        assert_eq!((same.rmse_levels, same.ssim_min), (0.0, 1.0));
        let next = |f: f64| of((f + 1.0).min(2.0));
        let other = truth.compare(next, &mut Progress::none()).unwrap();
        assert!(other.rmse_levels > 5.0 && other.ssim < 0.99 && other.off_percent > 1.0);
        assert!(other.rmse_levels_max >= other.rmse_levels && other.ssim_min <= other.ssim);
        assert!(ReferenceFrames::new(&cube, &[0.0]).is_err());
    }
}
