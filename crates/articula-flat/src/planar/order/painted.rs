//! Visibility, painting order and overlaps of a clip.

use super::epochs;
use super::gaps::without_harm;
use super::overlap::{Overlaps, WrongPixels};
use super::painting::{OrderOptions, Painting};
use crate::planar::clip::PlanarClip;
use crate::planar::drawn::Drawn;
use crate::planar::error::PlanarError;

/// Visibility, painting order and overlaps of a clip's triangles.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Painted {
    /// Drawn triangles: visible ones, and hidden ones in short gaps where that does no harm.
    pub drawn: Drawn,
    /// Painting order.
    pub painting: Painting,
    /// Overlap sets of the drawn triangles.
    pub overlaps: Overlaps,
}

impl Painted {
    /// Finds the visible triangles, orders them, and removes hidden triangles of short gaps that
    /// would cover a visible one; in epochs if the options require it.
    ///
    /// O(frames x samples covered), two or three times.
    ///
    /// # Errors
    /// Errors of the clip, or [`PlanarError::NothingVisible`].
    pub(crate) fn of(clip: &PlanarClip, options: &OrderOptions) -> Result<Self, PlanarError> {
        let seen = Drawn::seen(clip)?;
        let filled = seen.with_short_gaps();
        let mut overlaps = Overlaps::of(clip, &filled)?;
        let mut one = epochs::single(clip, &filled, &overlaps);
        let drawn = without_harm(&overlaps, &one, &seen, &filled);
        if drawn != filled {
            overlaps = Overlaps::of(clip, &drawn)?;
            one = epochs::again(&one, &drawn, &overlaps);
        }
        let painting = epochs::epochs(clip, (&drawn, &overlaps), one, options);
        Ok(Self {
            drawn,
            painting,
            overlaps,
        })
    }

    /// Counts the wrong samples, frame by frame.
    pub(crate) fn wrong(&self) -> WrongPixels {
        self.overlaps.wrong(&self.painting)
    }
}
