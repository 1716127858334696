//! Units by the error that they take away for their bytes, and the error of every prefix.
//!
//! Form: `docs/methods/motion-stream.md`, part 7.

use super::quantise::{Coding, show};
use super::search::Judge;
use super::skin_points::{Measure, SkinError, Sums};
use super::truth::Truth;
use super::units::{CodedUnit, UnitCoder};
use crate::abp2::pose_unit::Kind;
use std::ops::Range;

/// Bytes of a unit besides its body: number and length, and the checksum.
const HEADER_BYTES: usize = 3;

/// What prefixes of access units show.
pub(super) struct Prefixes<'a> {
    coding: &'a Coding<'a>,
    coder: &'a UnitCoder<'a>,
    measure: Measure<'a>,
    /// The motion of the prefix at hand.
    shown: Truth,
    /// For each pair of groups whether a joint of one is at, above or below a joint of the other.
    related: Vec<Vec<bool>>,
}

impl<'a> Prefixes<'a> {
    pub(super) fn new(
        coding: &'a Coding<'a>,
        coder: &'a UnitCoder<'a>,
        judge: &'a Judge<'a>,
    ) -> Self {
        let mut shown = coding.truth.clone();
        let rest = coding.rig.rest_pose();
        shown.rotations = rest.rotations.repeat(shown.frames);
        shown.translations = rest.translations.repeat(shown.frames);
        shown.scales = rest.scales.repeat(shown.frames);
        shown.weights.fill(0.0);
        for track in &coder.table.tracks {
            show(track, coding.rig, 0..shown.frames, None, &mut shown);
        }
        Self {
            coding,
            coder,
            measure: judge.quick(),
            shown,
            related: related(coding, coder),
        }
    }

    /// Shows a group at a tier in an access unit; without one, as a receiver does that waits for it.
    fn set(&mut self, access_unit: usize, group: usize, tier: Option<usize>) {
        let frames = self.coding.head.frames_of(access_unit);
        let Some(tier) = tier else {
            self.wait(group, frames);
            return;
        };
        let mut values = Vec::new();
        for track in &self.coder.table.of_group[group] {
            let place = &self.coder.table.tracks[*track];
            let levels = &self.coder.levels.levels[*track][access_unit];
            let Some((_, planes)) = place.moving() else {
                continue;
            };
            let dropped = planes[tier];
            self.coding
                .values(place, levels, access_unit, dropped, &mut values);
            let known = Some(&values[..]);
            show(
                place,
                self.coding.rig,
                frames.clone(),
                known,
                &mut self.shown,
            );
        }
    }

    /// Shows the reference of a group, or the frame before the access unit.
    fn wait(&mut self, group: usize, frames: Range<usize>) {
        for track in &self.coder.table.of_group[group] {
            let place = &self.coder.table.tracks[*track];
            if frames.start == 0 {
                show(
                    place,
                    self.coding.rig,
                    frames.clone(),
                    None,
                    &mut self.shown,
                );
            } else {
                self.shown
                    .hold(place.kind, usize::from(place.target), frames.clone());
            }
        }
    }

    /// Shows no unit of an access unit.
    fn start(&mut self, access_unit: usize) {
        for group in 0..self.coder.table.of_group.len() {
            self.set(access_unit, group, None);
        }
    }

    /// Shows all units of an access unit, which later ones start from.
    fn end(&mut self, access_unit: usize) {
        for group in 0..self.coder.table.of_group.len() {
            self.set(access_unit, group, Some(0));
        }
    }

    fn sums(&self, access_unit: usize) -> Sums {
        let mut sums = Sums::default();
        let frames = self.coding.head.frames_of(access_unit);
        self.measure
            .distances(&self.shown, frames, |_, distance| sums.add(distance));
        sums
    }

    /// Orders the units of an access unit, given by tier, by their value: first those of the coarsest
    /// tier among themselves, then the others. The value of a unit is taken to be that from before where the units in between move other parts of the body.
    pub(super) fn by_value(&mut self, access_unit: usize, units: Vec<CodedUnit>) -> Vec<CodedUnit> {
        self.start(access_unit);
        let groups = self.coder.table.of_group.len();
        // Of each group the units from coarse to fine, in reverse; they are in this order already.
        let mut waiting: Vec<Vec<CodedUnit>> = vec![Vec::new(); groups];
        for unit in units.into_iter().rev() {
            waiting[unit.0].push(unit);
        }
        let mut reached: Vec<Option<usize>> = vec![None; groups];
        // The error with the next unit of a group; unknown after a unit that it depends on.
        let mut errors: Vec<Option<f64>> = vec![None; groups];
        let mut ordered = Vec::new();
        let mut error = self.sums(access_unit).squares;
        let coarsest = self.coding.head.tiers - 1;
        let is_coarsest = |units: &Vec<CodedUnit>| units.last().is_some_and(|u| u.1 == coarsest);
        loop {
            // The coarsest units are one range of bytes.
            let only_coarsest = waiting.iter().any(is_coarsest);
            let mut best: Option<(f64, usize)> = None;
            for group in 0..groups {
                let Some((_, tier, body)) = waiting[group].last() else {
                    continue;
                };
                if only_coarsest && *tier != coarsest {
                    continue;
                }
                let with = match errors[group] {
                    Some(known) => known,
                    None => {
                        self.set(access_unit, group, Some(*tier));
                        let with = self.sums(access_unit).squares;
                        self.set(access_unit, group, reached[group]);
                        with
                    }
                };
                errors[group] = Some(with);
                let value = (error - with) / (body.len() + HEADER_BYTES) as f64;
                if best.is_none_or(|(most, _)| value > most) {
                    best = Some((value, group));
                }
            }
            let Some((_, group)) = best else { break };
            let Some(unit) = waiting[group].pop() else {
                break;
            };
            self.set(access_unit, group, Some(unit.1));
            reached[group] = Some(unit.1);
            let change = errors[group].map_or(0.0, |with| with - error);
            error += change;
            for (other, known) in errors.iter_mut().enumerate() {
                *known = match *known {
                    Some(with) if !self.related[group][other] => Some(with + change),
                    _ => None,
                };
            }
            ordered.push(unit);
        }
        self.end(access_unit);
        ordered
    }

    /// Returns the error after each of the units of an access unit, in their order.
    pub(super) fn errors(&mut self, access_unit: usize, units: &[CodedUnit]) -> Vec<SkinError> {
        self.start(access_unit);
        let mut errors = Vec::with_capacity(units.len());
        for (group, tier, _) in units {
            self.set(access_unit, *group, Some(*tier));
            errors.push(self.sums(access_unit).error());
        }
        self.end(access_unit);
        errors
    }
}

fn related(coding: &Coding<'_>, coder: &UnitCoder<'_>) -> Vec<Vec<bool>> {
    let joints = |group: &Vec<usize>| -> Vec<usize> {
        let tracks = group.iter().map(|track| &coder.table.tracks[*track]);
        let of_joints = tracks.filter(|track| track.kind != Kind::Morph);
        of_joints.map(|track| usize::from(track.target)).collect()
    };
    let joints: Vec<Vec<usize>> = coder.table.of_group.iter().map(joints).collect();
    let chained = |a: &usize, b: &usize| {
        coding.rig.is_at_or_below(*a, *b) || coding.rig.is_at_or_below(*b, *a)
    };
    let are = |a: &Vec<usize>, b: &Vec<usize>| a.iter().any(|a| b.iter().any(|b| chained(a, b)));
    let row = |(g, a): (usize, &Vec<usize>)| {
        let pairs = joints.iter().enumerate();
        pairs.map(|(h, b)| g == h || are(a, b)).collect()
    };
    joints.iter().enumerate().map(row).collect()
}
