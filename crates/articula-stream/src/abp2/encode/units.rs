//! From levels to the units of access units.

use super::quantise::Levels;
use crate::abp2::contexts::{Contexts, MOST};
use crate::abp2::head::MotionHead;
use crate::abp2::levels::{coarser, code_coarsest, code_plane};
use crate::abp2::tracks::TrackTable;
use crate::abp2::wavelet::Place;
use crate::range_coder::Encoder;
use articula_core::Mismatch;

/// A unit: group, tier and body.
pub(super) type CodedUnit = (usize, usize, Vec<u8>);

/// The levels of a track after dropping planes.
fn at_plane(levels: &[i32], plane: u8) -> Vec<i32> {
    let drop = |level: &i32| (0..plane).fold(*level, |level, _| coarser(level));
    levels.iter().map(drop).collect()
}

/// Codes the units of a motion.
pub(super) struct UnitCoder<'a> {
    pub(super) head: &'a MotionHead,
    pub(super) table: &'a TrackTable,
    /// Levels of the tracks of the table.
    pub(super) levels: &'a Levels,
}

impl UnitCoder<'_> {
    /// Codes the units of an access unit by tier from coarse to fine, then by group.
    ///
    /// # Errors
    /// If a level of the coarsest tier is too large for the form.
    pub(super) fn units(
        &self,
        access_unit: usize,
        places: &[Place],
    ) -> Result<Vec<CodedUnit>, Mismatch> {
        let mut units = Vec::new();
        for group in 0..self.table.of_group.len() {
            let mut of_group = self.group(access_unit, places, group)?;
            // Zeros at the end say nothing. In a face, the first unit of a group says that it is there.
            let least = usize::from(self.says_presence(group));
            while of_group.len() > least && of_group.last().is_some_and(|(is_zero, _)| *is_zero) {
                of_group.pop();
            }
            units.extend(of_group.into_iter().map(|(_, unit)| unit));
        }
        units.sort_by_key(|(group, tier, _)| (std::cmp::Reverse(*tier), *group));
        Ok(units)
    }

    /// Whether a group has a unit in every access unit: in a face stream, where it shows the level.
    fn says_presence(&self, group: usize) -> bool {
        self.head.face.is_some() && group >= self.head.groups.len()
    }

    /// The units of a group from coarse to fine, and whether all digits of each are 0.
    fn group(
        &self,
        access_unit: usize,
        places: &[Place],
        group: usize,
    ) -> Result<Vec<(bool, CodedUnit)>, Mismatch> {
        let Self {
            head,
            table,
            levels,
        } = self;
        let tracks = &table.of_group[group];
        if tracks.is_empty() {
            let present = (true, (group, head.tiers - 1, Vec::new()));
            let present = self.says_presence(group).then_some(present);
            return Ok(present.into_iter().collect());
        }
        let planes = |track: usize, tier: usize| {
            let moving = table.tracks[track].moving();
            moving.map_or(0, |(_, planes)| planes.get(tier).map_or(0, |p| *p))
        };
        let mut now: Vec<Vec<i32>> = Vec::new();
        let mut units = Vec::new();
        for tier in (0..head.tiers).rev() {
            let mut coder = Encoder::new();
            let mut contexts = Contexts::trained();
            let mut is_zero = true;
            if tier + 1 == head.tiers {
                for track in tracks {
                    let mut coarsest =
                        at_plane(&levels.levels[*track][access_unit], planes(*track, tier));
                    if coarsest
                        .iter()
                        .any(|level| level.unsigned_abs() > MOST as u32)
                    {
                        let what = "moves too far for its tolerance; give more tiers or a greater tolerance";
                        return Err(Mismatch::new("the motion", what));
                    }
                    is_zero &= coarsest.iter().all(|level| *level == 0);
                    code_coarsest(&mut coder, &mut contexts, places, &mut coarsest);
                    now.push(coarsest);
                }
            } else {
                if tracks
                    .iter()
                    .all(|t| planes(*t, tier + 1) == planes(*t, tier))
                {
                    continue;
                }
                for (track, now) in tracks.iter().zip(&mut now) {
                    for plane in (planes(*track, tier)..planes(*track, tier + 1)).rev() {
                        let finer = at_plane(&levels.levels[*track][access_unit], plane);
                        let mut digits = finer.iter().zip(now.iter());
                        is_zero &= digits.all(|(fine, coarse)| *fine == 3 * coarse);
                        code_plane(&mut coder, &mut contexts, tier, places, now, &finer);
                    }
                }
            }
            units.push((is_zero, (group, tier, coder.finish())));
        }
        Ok(units)
    }
}
