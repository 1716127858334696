//! The ways of ordering a clip beside each other, for experiments.

use super::painted::Painted;
use super::painting::{OrderOptions, Painting};
use crate::planar::clip::PlanarClip;
use crate::planar::error::PlanarError;

/// What each way of ordering a clip's triangles shows wrong, per cent of the object's pixels, mean
/// over the frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrderComparison {
    /// One depth sort, at the first frame.
    pub one_depth_sort: f64,
    /// One order from constraints.
    pub single: f64,
    /// Orders as many as pay.
    pub epochs: f64,
    /// How many these are.
    pub epoch_count: usize,
    /// How often a triangle is written for them, on the mean.
    pub copies: f64,
    /// An order from constraints for each frame.
    pub per_frame: f64,
}

impl OrderComparison {
    /// Orders a clip in all these ways, with the usual options and nothing cut.
    ///
    /// O(frames x samples covered), a few times.
    ///
    /// # Errors
    /// What is wrong with the clip, or [`PlanarError::NothingSeen`].
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
