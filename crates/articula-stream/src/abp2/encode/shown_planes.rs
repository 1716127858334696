//! What a motion shows without some planes of its tracks, decoded where it is looked at and as far as it has
//! changed.

use super::quantise::{Coding, Levels, show};
use super::truth::Truth;
use std::ops::Range;

/// A motion of which each track may lack planes.
pub(super) struct ShownPlanes<'a> {
    coding: &'a Coding<'a>,
    levels: &'a Levels,
    motion: Truth,
    /// Planes that the tracks lack in `motion`: `[access unit][track]`.
    dropped: Vec<Vec<u8>>,
    /// Buffer of the values of a track.
    values: Vec<i64>,
}

impl<'a> ShownPlanes<'a> {
    /// `whole` is what all planes show.
    pub(super) fn new(coding: &'a Coding<'a>, levels: &'a Levels, whole: &Truth) -> Self {
        Self {
            coding,
            levels,
            motion: whole.clone(),
            dropped: vec![vec![0; levels.tracks.len()]; coding.orders.len()],
            values: Vec::new(),
        }
    }

    /// The motion if each track drops so many planes, right in these frames.
    pub(super) fn in_frames(&mut self, dropped: &[u8], frames: Range<usize>) -> &Truth {
        for number in self.coding.head.access_units_of(frames) {
            self.update(number, dropped);
        }
        &self.motion
    }

    /// Decodes the tracks of an access unit that have lacked another number of planes.
    fn update(&mut self, access_unit: usize, dropped: &[u8]) {
        let head = self.coding.head;
        let known = &mut self.dropped[access_unit];
        for (t, (known, dropped)) in known.iter_mut().zip(dropped).enumerate() {
            let track = &self.levels.tracks[t];
            if *known == *dropped || track.moving().is_none() {
                continue;
            }
            *known = *dropped;
            let levels = &self.levels.levels[t][access_unit];
            (self.coding).values(track, levels, access_unit, *dropped, &mut self.values);
            let frames = head.frames_of(access_unit);
            let values = Some(&self.values[..]);
            show(track, self.coding.rig, frames, values, &mut self.motion);
        }
    }
}
