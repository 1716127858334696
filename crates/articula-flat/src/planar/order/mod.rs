//! In which order triangles are painted, and which pixels that leaves wrong.
//!
//! Source: `spec/vector.md` 4. Vector players have no depth buffer: what is painted later lies
//! on top. Wherever a triangle that is painted covers a sample that another one owns in the
//! item buffer, it has to come first; where such constraints contradict each other, the order
//! that leaves fewest samples wrong is sought.
//!
//! - [`overlap`]: who covers whom, sample by sample, summed up
//! - `graph`: a first order, by strongly connected components and least incoming weight
//! - `sift`: moves single triangles to where they leave fewest samples wrong
//! - `epochs`: spans of frames that share one order
//! - `gaps`: hidden triangles that are better not painted
//! - `painted`: all of this for a clip: what is drawn, in which order, what stays wrong
//! - [`layers`]: one list with copies that shows every epoch's order
//!
//! Differs: constraints also bind what is painted but hidden (short gaps are drawn), and an
//! order is improved by sifting after the greedy choice.

mod epochs;
mod gaps;
mod graph;
pub mod layers;
pub mod overlap;
mod painted;
mod sift;

use super::clip::PlanarClip;
use super::drawn::Drawn;
use super::error::PlanarError;
pub use layers::Layer;
pub use overlap::{Overlaps, WrongPixels, wrong_pixels};
pub use painted::Painted;
use std::ops::Range;

/// When which triangles are painted, and in which order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Painting {
    /// Spans that together are all frames, in turn.
    pub epochs: Vec<Epoch>,
}

/// A span of frames with one order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Epoch {
    /// The frames.
    pub frames: Range<usize>,
    /// The triangles that are drawn in some of these frames, back to front.
    pub order: Vec<u32>,
}

/// What an order may cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrderOptions {
    /// Share of the object's pixels that an epoch may show wrong beyond what an order for each
    /// frame would.
    pub order_tol: f64,
    /// Most epochs; the last one takes all that is left.
    pub max_epochs: usize,
}

impl Default for OrderOptions {
    fn default() -> Self {
        Self {
            order_tol: 0.003,
            max_epochs: 64,
        }
    }
}

impl Painting {
    /// All triangles by their mean depth in one frame, far first: the thesis' order.
    ///
    /// # Errors
    /// [`PlanarError::Mismatch`] if the clip has no such frame or `drawn` is of another clip.
    pub fn one_depth_sort(
        clip: &PlanarClip,
        drawn: &Drawn,
        frame: usize,
    ) -> Result<Self, PlanarError> {
        drawn.fits(clip)?;
        if frame >= clip.frames.len() {
            let (at, what) = ("frame", format!("{frame} of {}", clip.frames.len()));
            return Err(PlanarError::Mismatch { at, what });
        }
        let mut order = drawn.ever();
        far_first(&mut order, |t| nearness(clip, frame, t));
        let frames = 0..clip.frames.len();
        Ok(Self {
            epochs: vec![Epoch { frames, order }],
        })
    }

    /// The triangles of each frame by their mean depth in it, far first.
    ///
    /// # Errors
    /// [`PlanarError::Mismatch`] if `drawn` is of another clip.
    pub fn depth_sort_per_frame(clip: &PlanarClip, drawn: &Drawn) -> Result<Self, PlanarError> {
        drawn.fits(clip)?;
        let epoch = |f: usize| {
            let mut order = drawn.within(&(f..f + 1));
            far_first(&mut order, |t| nearness(clip, f, t));
            let frames = f..f + 1;
            Epoch { frames, order }
        };
        Ok(Self {
            epochs: (0..clip.frames.len()).map(epoch).collect(),
        })
    }

    /// The order that constraints ask for: one for the whole clip if that is good enough, else
    /// epochs.
    ///
    /// # Errors
    /// What is wrong with the clip, or [`PlanarError::Mismatch`] if `drawn` is of another one.
    pub fn constraints(
        clip: &PlanarClip,
        drawn: &Drawn,
        options: &OrderOptions,
    ) -> Result<Self, PlanarError> {
        let overlaps = Overlaps::of(clip, drawn)?;
        Ok(Self::from_overlaps(clip, drawn, &overlaps, options))
    }

    /// [`Self::constraints`] of overlaps that are at hand; they have to be those of `clip` and
    /// `drawn`.
    pub fn from_overlaps(
        clip: &PlanarClip,
        drawn: &Drawn,
        overlaps: &Overlaps,
        options: &OrderOptions,
    ) -> Self {
        let one = epochs::single(clip, drawn, overlaps);
        epochs::epochs(clip, (drawn, overlaps), one, options)
    }

    /// One order for the whole clip, whatever it costs.
    ///
    /// # Errors
    /// As [`Self::constraints`].
    pub fn single(clip: &PlanarClip, drawn: &Drawn) -> Result<Self, PlanarError> {
        let overlaps = Overlaps::of(clip, drawn)?;
        Ok(epochs::single(clip, drawn, &overlaps))
    }

    /// An order for each frame: the least that any painting leaves wrong, as far as this search
    /// finds it.
    ///
    /// # Errors
    /// As [`Self::constraints`].
    pub fn per_frame(clip: &PlanarClip, drawn: &Drawn) -> Result<Self, PlanarError> {
        let overlaps = Overlaps::of(clip, drawn)?;
        Ok(epochs::per_frame(clip, drawn, &overlaps))
    }

    /// The order of a frame, back to front; empty beyond the clip. Those that are not drawn in
    /// that very frame are in it too if they are in its epoch.
    pub fn order_at(&self, frame: usize) -> &[u32] {
        let epoch = self.epochs.iter().find(|e| e.frames.contains(&frame));
        epoch.map_or(&[], |e| &e.order)
    }
}

/// Mean nearness of a triangle's corners: greater is nearer.
fn nearness(clip: &PlanarClip, frame: usize, triangle: u32) -> f64 {
    let of = |v: u32| f64::from(clip.frames[frame].nearness[v as usize]);
    let [a, b, c] = clip.triangles[triangle as usize];
    (of(a) + of(b) + of(c)) / 3.0
}

/// Sorts from far to near; equals by their number.
fn far_first(order: &mut [u32], nearness: impl Fn(u32) -> f64) {
    order.sort_by(|a, b| nearness(*a).total_cmp(&nearness(*b)).then(a.cmp(b)));
}

#[cfg(test)]
mod tests;
