//! Pixels that are painted wrong, by how the painting order was found.

use anyhow::Result;
use articula_core::Progress;
use articula_flat::flatten::{PrepareClipOptions, PreparedClip};
use articula_flat::planar::{OrderComparison, PlanarClip};

/// Wrong pixels in percent of the character's, mean over the frames.
#[derive(Debug, Clone, Copy)]
pub(super) struct Orders {
    /// One depth sort, at the first frame.
    pub(super) thesis: f64,
    /// A depth sort for each frame.
    pub(super) depth_sort: f64,
    /// One order from constraints.
    pub(super) single: f64,
    /// Orders as many as pay.
    pub(super) epochs: f64,
    /// How many, and how often a triangle is written.
    pub(super) count: usize,
    pub(super) copies: f64,
    /// An order for each frame.
    pub(super) per_frame: f64,
    /// As many as pay, after cutting what pierces; and the triangles that are drawn then.
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

    /// All ways of ordering a clip; `cut` is it prepared, what pierces cut.
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
