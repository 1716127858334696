//! From the units of an access unit to whole numbers for each frame.
//!
//! Form: `docs/formats/abp2.md`, parts 4 to 6.

use super::access_unit::{AccessUnit, UnitPlace};
use super::contexts::Contexts;
use super::head::MotionHead;
use super::levels::{code_coarsest, code_plane};
use super::step::{coefficient, level_size};
use super::tracks::{TrackPlace, TrackTable};
use super::wavelet::{Place, inverse, order};
use crate::error::StreamError;
use crate::range_coder::{Coder, Decoder};

/// Decodes access units of one motion; reuses its memory.
#[derive(Debug, Clone, Default)]
pub(super) struct AccessUnitDecoder {
    /// Coded order of the last number of frames.
    places: Vec<Place>,
    /// Levels of the tracks of one group.
    levels: Vec<Vec<i32>>,
    /// Coefficients, then frames.
    frames: Vec<i64>,
}

impl AccessUnitDecoder {
    /// Decodes the units of an access unit. `show` gets the number of each track
    /// that has levels and, axis by axis, its values in 2^-22 at each frame; tracks without stay at
    /// their reference value.
    pub(super) fn decode(
        &mut self,
        stream: &[u8],
        head: &MotionHead,
        table: &TrackTable,
        access_unit: &AccessUnit,
        mut show: impl FnMut(usize, &[i64]),
    ) -> Result<(), StreamError> {
        let frames = access_unit.frames.len();
        if self.places.len() != frames {
            self.places = order(frames);
        }
        for (group, tracks) in table.of_group.iter().enumerate() {
            let units: Vec<&UnitPlace> = access_unit
                .units
                .iter()
                .filter(|unit| unit.group == group)
                .collect();
            let Some(first) = units.first() else {
                continue;
            };
            if !table.has_pose[group] {
                let what = format!("a unit of group {group}, whose pose unit is missing");
                return Err(at(first, what));
            }
            let dropped = self.group(stream, head, table, tracks, &units)?;
            for (slot, track) in tracks.iter().enumerate() {
                if !self.reconstruct(head, &table.tracks[*track], slot, dropped) {
                    return Err(at(
                        first,
                        format!("a coefficient of group {group} is too large"),
                    ));
                }
                show(*track, &self.frames);
            }
        }
        Ok(())
    }

    /// Decodes the levels of the tracks of a group; returns the finest tier.
    fn group(
        &mut self,
        stream: &[u8],
        head: &MotionHead,
        table: &TrackTable,
        tracks: &[usize],
        units: &[&UnitPlace],
    ) -> Result<usize, StreamError> {
        let frames = self.places.len();
        self.levels
            .resize_with(self.levels.len().max(tracks.len()), Vec::new);
        let mut units = units.iter().peekable();
        let mut reached = head.tiers;
        for tier in (0..head.tiers).rev() {
            let planes = |track: &usize, tier: usize| {
                let moving = table.tracks[*track].moving();
                moving.map_or(0, |(_, planes)| planes.get(tier).map_or(0, |p| *p))
            };
            let is_coarsest = tier + 1 == head.tiers;
            let adds = is_coarsest || tracks.iter().any(|t| planes(t, tier + 1) > planes(t, tier));
            if units.peek().is_none_or(|unit| unit.tier != tier) {
                if !adds {
                    continue;
                }
                if let Some(unit) = units.peek() {
                    return Err(at(unit, format!("tier {} without tier {tier}", unit.tier)));
                }
                break;
            }
            let Some(unit) = units.next() else { break };
            let mut coder = Decoder::new(&stream[unit.body.clone()]);
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
                        return Err(at(unit, "a level beyond 2^24"));
                    }
                }
            }
            if coder.is_exhausted() {
                return Err(at(unit, "the unit ends too early"));
            }
            reached = tier;
        }
        // Tiers that add nothing cost nothing.
        Ok(reached)
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

fn at(unit: &UnitPlace, what: impl Into<String>) -> StreamError {
    StreamError::malformed(format!("byte {}", unit.bytes.start), what)
}
