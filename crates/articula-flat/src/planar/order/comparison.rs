//! Comparison of ordering methods on one clip, for experiments.

use super::painted::Painted;
use super::painting::{OrderOptions, Painting};
use crate::planar::clip::PlanarClip;
use crate::planar::error::PlanarError;

/// Wrong pixels of each ordering method, percent of the character's pixels, mean over the frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrderComparison {
    /// One depth sort, in the first frame.
    pub one_depth_sort: f64,
    /// One constraint order for the whole clip.
    pub single: f64,
    /// Constraint orders in epochs.
    pub epochs: f64,
    /// Number of epochs.
    pub epoch_count: usize,
    /// Mean number of copies of a triangle in all epochs.
    pub copies: f64,
    /// A constraint order for each frame.
    pub per_frame: f64,
}

impl OrderComparison {
    /// Orders a clip by all methods, with default options and without cutting.
    ///
    /// O(frames x samples covered), a few times.
    ///
    /// # Errors
    /// Errors of the clip, or [`PlanarError::NothingVisible`].
    pub fn of(clip: &PlanarClip) -> Result<Self, PlanarError> {
        let painted = Painted::of(clip, &OrderOptions::default())?;
        let drawn = &painted.drawn;
        let wrong = |painting: &Painting| painted.overlaps.wrong(painting).percent_mean();
        Ok(Self {
            one_depth_sort: wrong(&Painting::one_depth_sort(clip, drawn, 0)?),
            single: wrong(&Painting::single(clip, drawn)?),
            epochs: wrong(&painted.painting),
            epoch_count: painted.painting.epochs.len(),
            copies: painted.painting.mean_copies(drawn),
            per_frame: wrong(&Painting::per_frame(clip, drawn)?),
        })
    }
}
