//! Painting order over time: epochs with one order each.

use crate::planar::clip::PlanarClip;
use crate::planar::drawn::Drawn;
use crate::planar::error::PlanarError;
use std::ops::Range;

/// Painting order of a clip, by epochs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Painting {
    /// Consecutive epochs that together cover all frames.
    pub epochs: Vec<Epoch>,
}

/// A span of frames with one order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Epoch {
    /// The frames.
    pub frames: Range<usize>,
    /// Triangles that are drawn in some of these frames, back to front.
    pub order: Vec<u32>,
}

/// Options of the painting order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrderOptions {
    /// Fraction of the character's pixels that an epoch may show wrong in addition to those of an
    /// order per frame.
    pub order_tol: f64,
    /// Maximum number of epochs; the last one covers all remaining frames.
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
    /// Orders all triangles by their mean depth in one frame, far first: the order of the thesis.
    ///
    /// # Errors
    /// [`PlanarError::Mismatch`] if the clip has no such frame or `drawn` belongs to another clip.
    pub(crate) fn one_depth_sort(
        clip: &PlanarClip,
        drawn: &Drawn,
        frame: usize,
    ) -> Result<Self, PlanarError> {
        drawn.fits(clip)?;
        if frame >= clip.frames.len() {
            let (at, what) = (
                "frame",
                format!(
                    "frame {frame} is out of range: the clip has {} frames",
                    clip.frames.len()
                ),
            );
            return Err(PlanarError::Mismatch { at, what });
        }
        let mut order = drawn.ever();
        far_first(&mut order, |t| nearness(clip, frame, t));
        let frames = 0..clip.frames.len();
        Ok(Self {
            epochs: vec![Epoch { frames, order }],
        })
    }

    /// Orders the triangles of each frame by their mean depth in it, far first.
    ///
    /// # Errors
    /// [`PlanarError::Mismatch`] if `drawn` belongs to another clip.
    pub(crate) fn depth_sort_per_frame(
        clip: &PlanarClip,
        drawn: &Drawn,
    ) -> Result<Self, PlanarError> {
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

    /// Order of a frame, back to front; empty beyond the clip. Contains all triangles of the
    /// frame's epoch, also those that are not drawn in that frame.
    pub(crate) fn order_at(&self, frame: usize) -> &[u32] {
        let epoch = self.epochs.iter().find(|e| e.frames.contains(&frame));
        epoch.map_or(&[], |e| &e.order)
    }
}

/// Mean nearness of a triangle's corners: greater is nearer.
pub(super) fn nearness(clip: &PlanarClip, frame: usize, triangle: u32) -> f64 {
    let of = |v: u32| f64::from(clip.frames[frame].nearness[v as usize]);
    let [a, b, c] = clip.triangles[triangle as usize];
    (of(a) + of(b) + of(c)) / 3.0
}

/// Sorts from far to near; ties by index.
pub(super) fn far_first(order: &mut [u32], nearness: impl Fn(u32) -> f64) {
    order.sort_by(|a, b| nearness(*a).total_cmp(&nearness(*b)).then(a.cmp(b)));
}
