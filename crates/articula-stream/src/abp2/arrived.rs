//! The units of a motion that have arrived, in whatever order they came.

use super::head::MotionHead;
use std::collections::BTreeMap;
use std::ops::Range;

/// A unit as it arrives.
#[derive(Debug, Clone, Copy)]
pub(super) struct ArrivingUnit<'a> {
    pub(super) access_unit: usize,
    pub(super) number: usize,
    /// Its first byte, for errors.
    pub(super) at: u64,
    pub(super) body: &'a [u8],
}

/// A unit that is there.
#[derive(Debug, Clone)]
pub(super) struct ArrivedUnit {
    /// Its first byte where it came from, for errors.
    pub(super) at: u64,
    body: Range<usize>,
}

/// The units of each access unit that is there, by their numbers.
#[derive(Debug, Clone, Default)]
pub(super) struct Arrived {
    bodies: Vec<u8>,
    access_units: BTreeMap<usize, BTreeMap<usize, ArrivedUnit>>,
}

/// What taking a unit changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Taken {
    New,
    /// It was there.
    Same,
    /// Another one of its number was there.
    Other,
}

impl Arrived {
    /// Bytes of all units.
    pub(super) fn bytes(&self) -> usize {
        self.bodies.len()
    }

    /// Number of access units that are there.
    pub(super) fn len(&self) -> usize {
        self.access_units.len()
    }

    pub(super) fn has(&self, access_unit: usize) -> bool {
        self.access_units.contains_key(&access_unit)
    }

    /// Adds an access unit, at first without units; false if it was there.
    pub(super) fn open(&mut self, access_unit: usize) -> bool {
        let is_new = !self.has(access_unit);
        if is_new {
            self.access_units.insert(access_unit, BTreeMap::new());
        }
        is_new
    }

    /// Adds a unit to an access unit that is there.
    pub(super) fn take(&mut self, unit: &ArrivingUnit<'_>) -> Taken {
        let bodies = &mut self.bodies;
        let units = self.access_units.entry(unit.access_unit).or_default();
        if let Some(found) = units.get(&unit.number) {
            return match bodies[found.body.clone()] == *unit.body {
                true => Taken::Same,
                false => Taken::Other,
            };
        }
        let start = bodies.len();
        bodies.extend(unit.body);
        let body = start..bodies.len();
        units.insert(unit.number, ArrivedUnit { at: unit.at, body });
        Taken::New
    }

    /// Removes a unit. Its bytes stay until [`Self::truncate`].
    pub(super) fn remove(&mut self, access_unit: usize, number: usize) {
        if let Some(units) = self.access_units.get_mut(&access_unit) {
            units.remove(&number);
        }
    }

    /// Removes an access unit.
    pub(super) fn close(&mut self, access_unit: usize) {
        self.access_units.remove(&access_unit);
    }

    /// Frees the bytes behind the first `bytes`, which no unit has any more.
    pub(super) fn truncate(&mut self, bytes: usize) {
        self.bodies.truncate(bytes);
    }

    /// The numbers of the access units that are there, from `first` on.
    pub(super) fn access_units(&self, first: usize) -> impl Iterator<Item = usize> {
        self.access_units.range(first..).map(|(number, _)| *number)
    }

    /// The groups of an access unit that have units, rising.
    pub(super) fn groups(&self, head: &MotionHead, access_unit: usize) -> Vec<usize> {
        let units = self.access_units.get(&access_unit).into_iter().flatten();
        let mut groups: Vec<usize> = units.map(|(n, _)| head.group_and_tier(*n).0).collect();
        groups.dedup();
        groups
    }

    /// Whether a group has its coarsest unit in an access unit, without which it shows nothing.
    pub(super) fn begins(&self, head: &MotionHead, access_unit: usize, group: usize) -> bool {
        let coarsest = head.unit_number(group, head.tiers - 1);
        let units = self.access_units.get(&access_unit);
        units.is_some_and(|units| units.contains_key(&coarsest))
    }

    /// The unit of a number.
    pub(super) fn unit(&self, access_unit: usize, number: usize) -> Option<&ArrivedUnit> {
        self.access_units.get(&access_unit)?.get(&number)
    }

    /// Tiers and bodies of a group in an access unit, from coarse to fine.
    pub(super) fn of_group<'a>(
        &'a self,
        head: &'a MotionHead,
        access_unit: usize,
        group: usize,
    ) -> impl Iterator<Item = (usize, &'a [u8])> {
        let numbers = group * head.tiers..(group + 1) * head.tiers;
        let units = self.access_units.get(&access_unit);
        let units = units
            .into_iter()
            .flat_map(move |u| u.range(numbers.clone()));
        units.map(|(number, unit)| {
            let (_, tier) = head.group_and_tier(*number);
            (tier, &self.bodies[unit.body.clone()])
        })
    }
}
