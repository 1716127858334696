//! From the units of an access unit to whole numbers for each frame.
//!
//! Form: `docs/formats/abp2.md`, parts 4 to 6.

use super::contexts::Contexts;
use super::head::MotionHead;
use super::levels::{code_coarsest, code_plane};
use super::step::{coefficient, level_size};
use super::tracks::{TrackPlace, TrackTable};
use super::wavelet::{Place, inverse, order};
use crate::range_coder::{Coder, Decoder};

/// Decodes the groups of access units of one motion; reuses its memory.
#[derive(Debug, Clone, Default)]
pub(super) struct GroupDecoder {
    /// Coded order of the last number of frames.
    places: Vec<Place>,
    /// Levels of the tracks of one group.
    levels: Vec<Vec<i32>>,
    /// Coefficients, then frames.
    frames: Vec<i64>,
}

/// A unit of a group whose body does not decode.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct BadUnit {
    pub(super) tier: usize,
    pub(super) what: &'static str,
}

impl GroupDecoder {
    /// Decodes the units of a group in one access unit of so many frames: tiers and bodies, from coarse
    /// to fine. Returns the finest tier that could be decoded: units after a missing tier, without
    /// which they cannot be, are left; the number of tiers if the coarsest is missing.
    ///
    /// `show` gets the number of each track of the group and, axis by axis, its values in 2^-22 at each
    /// frame.
    pub(super) fn decode<'a>(
        &mut self,
        (head, table, group): (&MotionHead, &TrackTable, usize),
        frames: usize,
        units: impl Iterator<Item = (usize, &'a [u8])>,
        mut show: impl FnMut(usize, &[i64]),
    ) -> Result<usize, BadUnit> {
        if self.places.len() != frames {
            self.places = order(frames);
        }
        let finest = self.levels_of((head, table, group), units)?;
        if finest == head.tiers {
            return Ok(finest);
        }
        for (slot, track) in table.of_group[group].iter().enumerate() {
            if !self.reconstruct(head, &table.tracks[*track], slot, finest) {
                let what = "a coefficient is too large";
                return Err(BadUnit { tier: finest, what });
            }
            show(*track, &self.frames);
        }
        Ok(finest)
    }

    /// Decodes the levels of the tracks of a group; returns the finest tier.
    fn levels_of<'a>(
        &mut self,
        (head, table, group): (&MotionHead, &TrackTable, usize),
        units: impl Iterator<Item = (usize, &'a [u8])>,
    ) -> Result<usize, BadUnit> {
        let frames = self.places.len();
        let tracks = &table.of_group[group];
        self.levels
            .resize_with(self.levels.len().max(tracks.len()), Vec::new);
        let mut units = units.peekable();
        let mut finest = head.tiers;
        for tier in (0..head.tiers).rev() {
            let planes = |track: &usize, tier: usize| {
                let moving = table.tracks[*track].moving();
                moving.map_or(0, |(_, planes)| planes.get(tier).map_or(0, |p| *p))
            };
            let is_coarsest = tier + 1 == head.tiers;
            let Some((_, body)) = units.next_if(|(of, _)| *of == tier) else {
                if table.adds(head.tiers, group, tier) {
                    break;
                }
                // Tiers that add nothing cost nothing.
                continue;
            };
            let mut coder = Decoder::new(body);
            let mut contexts = Contexts::trained();
            for (slot, track) in tracks.iter().enumerate() {
                let levels = &mut self.levels[slot];
                if is_coarsest {
                    levels.clear();
                    levels.resize(frames * table.tracks[*track].kind.axes(), 0);
                    code_coarsest(&mut coder, &mut contexts, &self.places, levels);
                    continue;
                }
                for _ in planes(track, tier)..planes(track, tier + 1) {
                    if !code_plane(&mut coder, &mut contexts, tier, &self.places, levels, &[]) {
                        let what = "a level beyond 2^24";
                        return Err(BadUnit { tier, what });
                    }
                }
            }
            if coder.is_exhausted() {
                let what = "the unit ends too early";
                return Err(BadUnit { tier, what });
            }
            finest = tier;
        }
        Ok(finest)
    }

    /// Computes the frames of a track from its levels at a tier.
    fn reconstruct(
        &mut self,
        head: &MotionHead,
        track: &TrackPlace,
        slot: usize,
        tier: usize,
    ) -> bool {
        let frames = self.places.len();
        let Some((code, planes)) = track.moving() else {
            return false;
        };
        let levels = &self.levels[slot];
        self.frames.clear();
        self.frames.resize(levels.len(), 0);
        let (mut band, mut size) = ((usize::MAX, 0), 0);
        for (axis, levels) in levels.chunks(frames).enumerate() {
            let x = &mut self.frames[axis * frames..][..frames];
            for (place, level) in self.places.iter().zip(levels) {
                if band != (place.class, place.band) {
                    band = (place.class, place.band);
                    size = level_size(code, place.class, place.band, head.updates);
                }
                let Some(value) = coefficient(*level, u32::from(planes[tier]), size) else {
                    return false;
                };
                x[place.frame as usize] = value;
            }
            inverse(x, head.updates);
        }
        true
    }
}
