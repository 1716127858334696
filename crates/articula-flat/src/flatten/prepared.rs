//! Visibility, painting order and wrong pixels of a clip, computed once for all settings.

use crate::planar::order::{Layer, OrderOptions, Painted, Painting, wrong_pixels};
use crate::planar::split::{SplitOptions, split};
use crate::planar::underlap::UnderlapOptions;
use crate::planar::{Drawn, PlanarClip, PlanarError};
use articula_core::Progress;

/// Options of [`PreparedClip::new`].
#[derive(Debug, Clone, PartialEq)]
pub struct PrepareClipOptions {
    /// Tolerance and number of painting orders.
    pub order: OrderOptions,
    /// Options of cutting intersecting triangles; `None` to leave them.
    pub split: Option<SplitOptions>,
}

impl Default for PrepareClipOptions {
    /// Intersecting triangles are cut, since no order shows them correctly.
    fn default() -> Self {
        Self {
            order: OrderOptions::default(),
            split: Some(SplitOptions::default()),
        }
    }
}

/// A clip with its visibility and painting order, ready to be written.
#[derive(Debug, Clone, PartialEq)]
pub struct PreparedClip {
    /// The clip; with additional triangles if some were cut.
    pub clip: PlanarClip,
    /// Which triangles are drawn in which frames.
    pub(crate) drawn: Drawn,
    /// Painting order.
    pub(crate) painting: Painting,
    /// The painting order as one list with copies.
    pub(crate) layers: Vec<Layer>,
    /// Wrong pixels, percent of the character's.
    pub wrong_percent: f64,
    /// Wrong pixels of a depth sort per frame, percent of the character's.
    pub wrong_percent_depth_sort: f64,
    /// Options of sealing edges.
    pub(crate) underlap: UnderlapOptions,
}

impl PreparedClip {
    /// Computes visibility and painting order of a clip; cuts intersecting triangles.
    ///
    /// # Errors
    /// Errors of the clip ([`PlanarError`]); [`PlanarError::Cancelled`].
    pub fn new(
        clip: PlanarClip,
        options: &PrepareClipOptions,
        progress: &mut Progress<'_>,
    ) -> Result<Self, PlanarError> {
        let painted = Painted::of(&clip, &options.order)?;
        progress.step(0.4)?;
        // The baseline sorts the clip before it is cut.
        let sorted = Painting::depth_sort_per_frame(&clip, &painted.drawn)?;
        let wrong_percent_depth_sort = painted.overlaps.wrong(&sorted).percent_mean();
        progress.step(0.5)?;
        let (clip, drawn, painting, wrong_percent) = match &options.split {
            None => {
                let wrong = painted.wrong().percent_mean();
                (clip, painted.drawn, painted.painting, wrong)
            }
            Some(cut) => {
                let cut = SplitOptions {
                    order: options.order,
                    ..*cut
                };
                let cut = split(&clip, &cut, &mut progress.part(0.5, 0.9))?;
                let wrong = wrong_pixels(&cut.clip, &cut.drawn, &cut.painting)?;
                (cut.clip, cut.drawn, cut.painting, wrong.percent_mean())
            }
        };
        progress.step(1.0)?;
        Ok(Self {
            layers: painting.layers(&drawn),
            painting,
            drawn,
            clip,
            wrong_percent,
            wrong_percent_depth_sort,
            underlap: UnderlapOptions::default(),
        })
    }

    /// Returns the number of triangles that are drawn in some frame.
    pub fn triangles_drawn(&self) -> usize {
        self.drawn.ever().len()
    }

    /// Triangles that are drawn in a frame, back to front.
    pub(crate) fn order_at(&self, frame: usize) -> Vec<u32> {
        let drawn = |t: &&u32| self.drawn.get(frame, **t as usize);
        let order = self.painting.order_at(frame);
        order.iter().filter(drawn).copied().collect()
    }
}
