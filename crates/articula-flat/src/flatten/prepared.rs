//! What is drawn, in which order, and what that leaves wrong, worked out once for all settings.

use crate::planar::order::{Layer, OrderOptions, Painted, Painting, wrong_pixels};
use crate::planar::split::{SplitOptions, split};
use crate::planar::underlap::UnderlapOptions;
use crate::planar::{Drawn, PlanarClip, PlanarError};
use articula_core::Progress;

/// How a clip is prepared.
#[derive(Debug, Clone, PartialEq)]
pub struct PrepareClipOptions {
    /// What one painting order may cost.
    pub order: OrderOptions,
    /// How triangles that pierce each other are cut, if they are.
    pub split: Option<SplitOptions>,
}

impl Default for PrepareClipOptions {
    /// Triangles that pierce each other are cut: no order shows them right.
    fn default() -> Self {
        Self {
            order: OrderOptions::default(),
            split: Some(SplitOptions::default()),
        }
    }
}

/// A clip that is ready to be written.
#[derive(Debug, Clone, PartialEq)]
pub struct PreparedClip {
    /// The clip; with more triangles than it came with if some were cut.
    pub clip: PlanarClip,
    /// Which triangles are drawn when.
    pub(crate) drawn: Drawn,
    /// In which order.
    pub(crate) painting: Painting,
    /// The order as one list with copies.
    pub(crate) layers: Vec<Layer>,
    /// Wrong pixels, percent of the character's.
    pub wrong_percent: f64,
    /// The same if every frame were sorted by depth.
    pub wrong_percent_depth_sort: f64,
    /// How writers seal edges.
    pub(crate) underlap: UnderlapOptions,
}

impl PreparedClip {
    /// Prepares a clip.
    ///
    /// # Errors
    /// What is wrong with the clip ([`PlanarError`]); [`PlanarError::Cancelled`].
    pub fn new(
        clip: PlanarClip,
        options: &PrepareClipOptions,
        progress: &mut Progress<'_>,
    ) -> Result<Self, PlanarError> {
        let painted = Painted::of(&clip, &options.order)?;
        progress.step(0.4)?;
        // The peer sorts the clip as it came.
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

    /// Triangles that are drawn in some frame.
    pub fn triangles_drawn(&self) -> usize {
        self.drawn.ever().len()
    }

    /// The triangles that are drawn in a frame, back to front.
    pub(crate) fn order_at(&self, frame: usize) -> Vec<u32> {
        let drawn = |t: &&u32| self.drawn.get(frame, **t as usize);
        let order = self.painting.order_at(frame);
        order.iter().filter(drawn).copied().collect()
    }
}
