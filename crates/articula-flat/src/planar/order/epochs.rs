//! Epochs: spans of frames that share one order.
//!
//! Source: `docs/methods/vector.md` 4. Each epoch's order is sifted from the one before it, so that
//! few triangles change their position and need a copy.

use super::graph::first_order;
use super::overlap::Overlaps;
use super::painting::{Epoch, OrderOptions, Painting, far_first, nearness};
use super::sift::sift;
use crate::planar::clip::PlanarClip;
use crate::planar::drawn::Drawn;
use crate::planar::error::PlanarError;
use std::ops::Range;

impl Painting {
    /// Orders a clip by constraints: one order for the whole clip if that is good enough, otherwise
    /// epochs.
    ///
    /// # Errors
    /// Errors of the clip, or [`PlanarError::Mismatch`] if `drawn` belongs to another one.
    #[cfg(test)]
    pub(crate) fn constraints(
        clip: &PlanarClip,
        drawn: &Drawn,
        options: &OrderOptions,
    ) -> Result<Self, PlanarError> {
        let overlaps = Overlaps::of(clip, drawn)?;
        let one = single(clip, drawn, &overlaps);
        Ok(epochs(clip, (drawn, &overlaps), one, options))
    }

    /// Orders a clip by constraints, with one order for the whole clip.
    ///
    /// # Errors
    /// Errors of the clip, or [`PlanarError::Mismatch`] if `drawn` belongs to another one.
    pub(crate) fn single(clip: &PlanarClip, drawn: &Drawn) -> Result<Self, PlanarError> {
        let overlaps = Overlaps::of(clip, drawn)?;
        Ok(single(clip, drawn, &overlaps))
    }

    /// Orders each frame separately: the fewest wrong samples of any painting, as far as this
    /// search finds it.
    ///
    /// # Errors
    /// Errors of the clip, or [`PlanarError::Mismatch`] if `drawn` belongs to another one.
    pub(crate) fn per_frame(clip: &PlanarClip, drawn: &Drawn) -> Result<Self, PlanarError> {
        let overlaps = Overlaps::of(clip, drawn)?;
        Ok(per_frame(clip, drawn, &overlaps))
    }
}

/// One order for the whole clip.
pub(super) fn single(clip: &PlanarClip, drawn: &Drawn, overlaps: &Overlaps) -> Painting {
    let frames = 0..clip.frames.len();
    let order = fresh_order(clip, drawn, overlaps, &frames);
    Painting {
        epochs: vec![Epoch { frames, order }],
    }
}

/// One order after fewer triangles are drawn: the previous one without those, sifted.
pub(super) fn again(painting: &Painting, drawn: &Drawn, overlaps: &Overlaps) -> Painting {
    let again = |epoch: &Epoch| {
        let frames = epoch.frames.clone();
        let is_drawn = drawn.mask(&frames);
        let kept = epoch.order.iter().copied();
        let mut order: Vec<u32> = kept.filter(|t| is_drawn[*t as usize]).collect();
        sift(overlaps, &overlaps.sum(&frames), &mut order);
        Epoch { frames, order }
    };
    Painting {
        epochs: painting.epochs.iter().map(again).collect(),
    }
}

/// An order for each frame.
pub(super) fn per_frame(clip: &PlanarClip, drawn: &Drawn, overlaps: &Overlaps) -> Painting {
    let epoch = |f: usize| {
        let frames = f..f + 1;
        let order = fresh_order(clip, drawn, overlaps, &frames);
        Epoch { frames, order }
    };
    Painting {
        epochs: (0..clip.frames.len()).map(epoch).collect(),
    }
}

/// Order of a span of frames, computed without a previous order.
fn fresh_order(
    clip: &PlanarClip,
    drawn: &Drawn,
    overlaps: &Overlaps,
    frames: &Range<usize>,
) -> Vec<u32> {
    let mut order = drawn.within(frames);
    let mut mean = vec![0.0; clip.triangles.len()];
    for t in &order {
        let shown = frames.clone().filter(|f| drawn.get(*f, *t as usize));
        let (sum, count) = shown.fold((0.0, 0), |(sum, n), f| (sum + nearness(clip, f, *t), n + 1));
        mean[*t as usize] = sum / f64::from(count);
    }
    far_first(&mut order, |t| mean[t as usize]);
    let weights = overlaps.sum(frames);
    let mut order = first_order(overlaps, &weights, &order);
    sift(overlaps, &weights, &mut order);
    order
}

/// The given order if it is good enough, otherwise as few epochs as a greedy search finds.
pub(super) fn epochs(
    clip: &PlanarClip,
    (drawn, overlaps): (&Drawn, &Overlaps),
    one: Painting,
    options: &OrderOptions,
) -> Painting {
    let best = per_frame(clip, drawn, overlaps);
    let allowed = |epoch: &Epoch| {
        let object = overlaps.object(&epoch.frames) as f64;
        let tolerance = options.order_tol.max(0.0) * object / epoch.frames.len() as f64;
        overlaps.wrong_within(&epoch.frames, &epoch.order) as f64 + tolerance
    };
    let allowed: Vec<f64> = best.epochs.iter().map(allowed).collect();
    let search = Search {
        drawn,
        overlaps,
        allowed,
    };
    let all = 0..clip.frames.len();
    if search.holds(&all, &one.epochs[0].order) || options.max_epochs <= 1 {
        return one;
    }
    let mut painting = Painting { epochs: Vec::new() };
    let mut before = one.epochs[0].order.clone();
    let mut from = 0;
    while from < all.end {
        let is_last = painting.epochs.len() + 1 >= options.max_epochs;
        let (end, order) = if is_last {
            (all.end, search.order(&(from..all.end), &before).0)
        } else {
            search.longest(from, &before)
        };
        let frames = from..end;
        let is_drawn = drawn.mask(&frames);
        let shown = order.iter().copied().filter(|t| is_drawn[*t as usize]);
        painting.epochs.push(Epoch {
            order: shown.collect(),
            frames,
        });
        before = order;
        from = end;
    }
    painting
}

/// Greedy search for epochs; its orders contain every triangle that is drawn in some frame.
struct Search<'a> {
    drawn: &'a Drawn,
    overlaps: &'a Overlaps,
    /// Maximum number of wrong samples in each frame.
    allowed: Vec<f64>,
}

impl Search<'_> {
    fn holds(&self, frames: &Range<usize>, order: &[u32]) -> bool {
        let allowed: f64 = self.allowed[frames.clone()].iter().sum();
        self.overlaps.wrong_within(frames, order) as f64 <= allowed
    }

    /// Order of a span, sifted from the one before only if that does not hold, and whether it
    /// holds.
    fn order(&self, frames: &Range<usize>, before: &[u32]) -> (Vec<u32>, bool) {
        let mut order = before.to_vec();
        if self.holds(frames, &order) {
            return (order, true);
        }
        let weights = self.overlaps.sum(frames);
        sift(self.overlaps, &weights, &mut order);
        let holds = self.holds(frames, &order);
        (order, holds)
    }

    /// End of the longest span found from a frame whose order holds, and the order; at least one
    /// frame.
    fn longest(&self, from: usize, before: &[u32]) -> (usize, Vec<u32>) {
        let last = self.drawn.frames();
        let (mut good, mut order) = (from + 1, self.order(&(from..from + 1), before).0);
        let (mut length, mut bad) = (2, last + 1);
        while good < last {
            let end = (from + length).min(last);
            let (next, holds) = self.order(&(from..end), before);
            if !holds {
                bad = end;
                break;
            }
            (good, order) = (end, next);
            length *= 2;
        }
        while good + 1 < bad.min(last + 1) {
            let end = good.midpoint(bad);
            let (next, holds) = self.order(&(from..end), before);
            if holds {
                (good, order) = (end, next);
            } else {
                bad = end;
            }
        }
        (good, order)
    }
}
