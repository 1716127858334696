//! Pixels painted in the wrong order, by the method that finds the painting order.

use anyhow::Result;
use articula_core::Progress;
use articula_flat::flatten::{PrepareClipOptions, PreparedClip};
use articula_flat::planar::{OrderComparison, PlanarClip};

/// Wrong pixels in percent of the character's pixels, mean over the frames.
#[derive(Debug, Clone, Copy)]
pub(super) struct Orders {
    /// One depth sort, at the first frame.
    pub(super) thesis: f64,
    /// A depth sort for each frame.
    pub(super) depth_sort: f64,
    /// One order from constraints.
    pub(super) single: f64,
    /// Several orders, one per epoch.
    pub(super) epochs: f64,
    /// Number of orders, and copies of a triangle.
    pub(super) count: usize,
    pub(super) copies: f64,
    /// An order for each frame.
    pub(super) per_frame: f64,
    /// Several orders after cutting piercing triangles, and the number of triangles drawn then.
    pub(super) split: f64,
    pub(super) split_triangles: usize,
}

impl Orders {
    /// Prepares a clip as the command does.
    pub(super) fn prepare(clip: &PlanarClip) -> Result<PreparedClip> {
        let options = PrepareClipOptions::default();
        Ok(PreparedClip::new(
            clip.clone(),
            &options,
            &mut Progress::none(),
        )?)
    }

    /// Measures all methods on a clip; `cut` is the prepared clip with piercing triangles cut.
    pub(super) fn of(clip: &PlanarClip, cut: &PreparedClip) -> Result<Self> {
        let ways = OrderComparison::of(clip)?;
        Ok(Self {
            thesis: ways.one_depth_sort,
            depth_sort: cut.wrong_percent_depth_sort,
            single: ways.single,
            epochs: ways.epochs,
            count: ways.epoch_count,
            copies: ways.copies,
            per_frame: ways.per_frame,
            split: cut.wrong_percent,
            split_triangles: cut.triangles_drawn(),
        })
    }
}
