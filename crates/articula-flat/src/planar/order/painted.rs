//! What of a clip is drawn, in which order, and what stays wrong.

use super::epochs;
use super::gaps::without_harm;
use super::overlap::{Overlaps, WrongPixels};
use super::painting::{OrderOptions, Painting};
use crate::planar::clip::PlanarClip;
use crate::planar::drawn::Drawn;
use crate::planar::error::PlanarError;

/// A clip's triangles with when and in which order they are painted.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Painted {
    /// What is drawn: what is seen, and short gaps where that does no harm.
    pub drawn: Drawn,
    /// In which order.
    pub painting: Painting,
    /// Who covers whom in what is drawn.
    pub overlaps: Overlaps,
}

impl Painted {
    /// Finds out what is seen, orders it, and leaves out hidden triangles of short gaps that
    /// would cover something seen; epochs where the options ask for them.
    ///
    /// O(frames x samples covered), twice or three times.
    ///
    /// # Errors
    /// What is wrong with the clip, or [`PlanarError::NothingSeen`].
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

    /// Samples that are wrong, frame by frame.
    pub(crate) fn wrong(&self) -> WrongPixels {
        self.overlaps.wrong(&self.painting)
    }
}
