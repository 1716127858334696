//! Visibility, painting order and wrong pixels of a clip, computed once for all settings.

use crate::planar::order::{Layer, OrderOptions, Overlaps, Painted, Painting};
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
    /// Triangles that share samples.
    pub(crate) overlaps: Overlaps,
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
        let uncut = clip.albedo.len() as u32;
        let painted = Painted::of(&clip, &options.order)?;
        progress.step(0.4)?;
        // The baseline sorts the clip before it is cut.
        let sorted = Painting::depth_sort_per_frame(&clip, &painted.drawn)?;
        let wrong_percent_depth_sort = painted.overlaps.wrong(&sorted).percent_mean();
        progress.step(0.5)?;
        let (clip, drawn, painting, overlaps) = match &options.split {
            None => (clip, painted.drawn, painted.painting, painted.overlaps),
            Some(cut) => {
                let cut = SplitOptions {
                    order: options.order,
                    ..*cut
                };
                let cut = split(&clip, &cut, &mut progress.part(0.5, 0.9))?;
                let overlaps = Overlaps::of(&cut.clip, &cut.drawn)?;
                (cut.clip, cut.drawn, cut.painting, overlaps)
            }
        };
        progress.step(1.0)?;
        Ok(Self {
            layers: painting.layers(&drawn),
            wrong_percent: overlaps.wrong(&painting).percent_mean(),
            overlaps,
            painting,
            drawn,
            clip,
            wrong_percent_depth_sort,
            underlap: UnderlapOptions {
                uncut,
                ..UnderlapOptions::default()
            },
        })
    }

    /// Returns the number of triangles that are drawn in some frame.
    pub fn triangles_drawn(&self) -> usize {
        self.drawn.ever().len()
    }

    /// Triangles that are drawn in a frame, back to front.
    pub(crate) fn order_at(&self, frame: usize) -> Vec<u32> {
        self.order_of(&self.painting, frame)
    }

    /// The same of another painting of the clip.
    pub(crate) fn order_of(&self, painting: &Painting, frame: usize) -> Vec<u32> {
        let drawn = |t: &&u32| self.drawn.get(frame, **t as usize);
        let order = painting.order_at(frame);
        order.iter().filter(drawn).copied().collect()
    }
}
