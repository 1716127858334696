//! A motion as far as its units have arrived, whatever the order.
//!
//! Form: `docs/formats/abp2.md`, part 8. Everything shown is a function of the set of units that are
//! there.

use super::arrived::{Arrived, ArrivingUnit, Taken};
use super::decode::GroupDecoder;
use super::head::{MotionHead, PosePlace, ReadHead};
use super::places::{Part, Places, units_of};
use super::shown::{Shown, Source};
use super::tracks::TrackTable;
use crate::error::StreamError;
use crate::limits::StreamLimits;
use articula_core::{Rig, Tracks};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// The state of a receiver that has the fields of the head.
#[derive(Debug, Clone)]
pub(super) struct MotionState {
    basis: Basis,
    places: Places,
    arrived: Arrived,
    /// The access unit that is arriving in the order of the bytes, in which groups that are not there
    /// show the frame before.
    arriving: Option<usize>,
    /// Finest tier of each group of that access unit.
    in_order: BTreeMap<usize, usize>,
    decoder: GroupDecoder,
    /// Greatest number of values.
    elements: u64,
}

/// The head as far as it is there, and the tracks that it tells of.
#[derive(Debug, Clone)]
struct Basis {
    /// Fields of the head, then the bodies of its units as they came.
    bytes: Vec<u8>,
    read: ReadHead,
    table: TrackTable,
    /// The groups that have tracks that move.
    moving: Vec<usize>,
    shown: Shown,
}

/// How bytes arrive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Arrival {
    /// Each after the one before: units whose coarser ones are missing are refused.
    InOrder,
    /// Anyhow: units wait for those that they need.
    Any,
}

/// The groups of an access unit that are decoded anew.
#[derive(Debug, Clone)]
enum Redo {
    All,
    Groups(BTreeSet<usize>),
}

/// What some bytes added, so that it can be taken back.
#[derive(Debug, Default)]
struct Added {
    access_units: Vec<usize>,
    /// Access unit and number of each.
    units: Vec<(usize, usize)>,
    /// Bytes of units before.
    bytes: usize,
}

/// A unit that does not decode.
struct Fault {
    access_unit: usize,
    number: usize,
    error: StreamError,
}

/// The access unit of some frames, if it is there; else they are of some that are not.
type Span = (Range<usize>, Option<usize>);

impl Basis {
    /// Reads the fields at the start of a stream.
    fn new(stream: &[u8], rig: &Rig, limits: &StreamLimits) -> Result<Self, StreamError> {
        let read = MotionHead::read_fields(stream, limits)?;
        Self::of(stream[..read.fields].to_vec(), read, rig, limits.elements)
    }

    fn of(bytes: Vec<u8>, read: ReadHead, rig: &Rig, elements: u64) -> Result<Self, StreamError> {
        let table = TrackTable::read(&bytes, &read, rig)?;
        let tracks = table.of_group.iter().map(Vec::len).sum::<usize>();
        let found = tracks as u64 * read.head.frames as u64;
        StreamLimits::check("the head", "values", found, elements)?;
        let groups = table.of_group.iter().enumerate();
        let moving = groups.filter(|(_, tracks)| !tracks.is_empty());
        let moving = moving.map(|(group, _)| group).collect();
        let shown = Shown::new(&table, rig, read.head.frames);
        Ok(Self {
            bytes,
            read,
            table,
            moving,
            shown,
        })
    }

    /// The basis with the pose units among some parts of `bytes`; `None` if all of them are there. The
    /// skeleton is of no use here.
    fn with(
        &self,
        parts: &[Part],
        bytes: &[u8],
        rig: &Rig,
        elements: u64,
    ) -> Result<Option<Self>, StreamError> {
        let mut more: Option<(Vec<u8>, ReadHead)> = None;
        for part in parts {
            let Part::Unit {
                access_unit: None,
                number,
                at,
                body,
            } = part
            else {
                continue;
            };
            let (stored, read) = more
                .as_ref()
                .map_or((&self.bytes, &self.read), |m| (&m.0, &m.1));
            let body = &bytes[body.clone()];
            if let Some(place) = read.place(*number) {
                if stored[place.body.clone()] != *body {
                    let what = format!("unit {number} of the head has other bytes than before");
                    return Err(StreamError::malformed(format!("byte {at}"), what));
                }
            } else if *number < self.read.head.pose_count() {
                let clone = || (self.bytes.clone(), self.read.clone());
                let (stored, read) = more.get_or_insert_with(clone);
                let start = *at as usize;
                read.put(PosePlace {
                    number: *number,
                    bytes: start..start + body.len(),
                    body: stored.len()..stored.len() + body.len(),
                });
                stored.extend(body);
            }
        }
        more.map(|(bytes, read)| Self::of(bytes, read, rig, elements))
            .transpose()
    }
}

impl MotionState {
    /// Reads the fields at the start of a stream.
    pub(super) fn new(
        stream: &[u8],
        rig: &Rig,
        limits: &StreamLimits,
    ) -> Result<Self, StreamError> {
        let basis = Basis::new(stream, rig, limits)?;
        Ok(Self {
            places: Places::new(&basis.read),
            basis,
            arrived: Arrived::default(),
            arriving: None,
            in_order: BTreeMap::new(),
            decoder: GroupDecoder::default(),
            elements: limits.elements,
        })
    }

    pub(super) fn head(&self) -> &MotionHead {
        &self.basis.read.head
    }

    pub(super) fn tracks(&self) -> &Tracks {
        &self.basis.shown.tracks
    }

    /// Bytes that are stored.
    pub(super) fn bytes(&self) -> usize {
        self.basis.bytes.len() + self.arrived.bytes()
    }

    /// Number of access units whose length is known.
    pub(super) fn known_lengths(&self) -> usize {
        self.places.known()
    }

    /// Number of frames from the first up to the first access unit that is not there.
    pub(super) fn frames(&self) -> usize {
        let head = self.head();
        let there = self.arrived.access_units(0).zip(0..);
        let count = there
            .take_while(|(number, expected)| number == expected)
            .count();
        match head.access_units {
            0 => head.frames,
            _ => head.frames_of(count).start,
        }
    }

    /// Whether all access units are there, and none is arriving.
    pub(super) fn is_whole(&self) -> bool {
        self.arriving.is_none() && self.arrived.len() == self.head().access_units
    }

    /// The access units that are there, rising.
    pub(super) fn access_units(&self) -> impl Iterator<Item = usize> {
        self.arrived.access_units(0)
    }

    pub(super) fn is_arriving(&self, access_unit: usize) -> bool {
        self.arriving == Some(access_unit)
    }

    /// The groups that show values of their own in an access unit, rising.
    pub(super) fn groups(&self, access_unit: usize) -> Vec<usize> {
        let head = self.head();
        let mut groups = self.arrived.groups(head, access_unit);
        groups.retain(|group| self.arrived.begins(head, access_unit, *group));
        groups
    }

    /// Takes bytes from `start` on; returns the frames that changed, and how many bytes were taken. On an
    /// error nothing changes.
    pub(super) fn take(
        &mut self,
        (start, bytes): (u64, &[u8]),
        arrival: Arrival,
        rig: &Rig,
    ) -> Result<(Range<usize>, usize), StreamError> {
        self.check_fields(start, bytes)?;
        let known = self.places.known();
        let read = self.places.read(start, bytes, &self.basis.read.head);
        let taken = read.and_then(|(parts, taken)| {
            if arrival == Arrival::Any {
                let changed = self.add(&parts, bytes, (arrival, self.arriving), rig)?;
                return Ok((changed, taken));
            }
            let arriving = self.places.within(start + bytes.len() as u64);
            let in_order = self.checked_order(&parts, arriving)?;
            let changed = self.add(&parts, bytes, (arrival, arriving), rig)?;
            self.in_order = in_order;
            Ok((changed, taken))
        });
        if taken.is_err() {
            self.places.forget(known);
        }
        taken
    }

    /// Takes whole units of an access unit, which is there from now on; returns the frames that changed.
    /// On an error nothing changes.
    pub(super) fn take_units(
        &mut self,
        access_unit: usize,
        bytes: &[u8],
        rig: &Rig,
    ) -> Result<Range<usize>, StreamError> {
        let mut parts = vec![Part::Length { access_unit }];
        parts.extend(units_of(access_unit, bytes, self.head())?);
        self.add(&parts, bytes, (Arrival::Any, self.arriving), rig)
    }

    /// Checks that bytes of the fields of the head are those that are there.
    fn check_fields(&self, start: u64, bytes: &[u8]) -> Result<(), StreamError> {
        let start = usize::try_from(start).unwrap_or(usize::MAX);
        let fields = self.basis.bytes.get(start..self.basis.read.fields);
        let fields = fields.unwrap_or_default();
        let count = fields.len().min(bytes.len());
        if fields[..count] == bytes[..count] {
            return Ok(());
        }
        let at = format!("byte {start}");
        Err(StreamError::malformed(
            at,
            "the head has other bytes than before",
        ))
    }

    /// Checks that the tiers of each group fall in the order of the bytes, and that no unit of the head
    /// comes twice; returns the tiers of the access unit that is still arriving.
    fn checked_order(
        &self,
        parts: &[Part],
        arriving: Option<usize>,
    ) -> Result<BTreeMap<usize, usize>, StreamError> {
        let mut of = self.arriving;
        let mut finest = self.in_order.clone();
        let mut of_head = BTreeSet::new();
        for part in parts {
            match part {
                Part::Length { access_unit } => {
                    of = Some(*access_unit);
                    finest.clear();
                }
                Part::Unit {
                    access_unit: Some(access_unit),
                    number,
                    at,
                    ..
                } => {
                    let (group, tier) = self.head().group_and_tier(*number);
                    let before = finest.insert(group, tier);
                    if let Some(before) = before.filter(|before| *before <= tier) {
                        let what = format!("tier {tier} of group {group} after tier {before}");
                        return Err(at_byte(*at, *access_unit, what));
                    }
                }
                Part::Unit { number, at, .. } => {
                    if !of_head.insert(*number) {
                        let what = format!("unit {number} of the head occurs twice");
                        return Err(StreamError::malformed(format!("byte {at}"), what));
                    }
                }
            }
        }
        if of != arriving {
            finest.clear();
        }
        Ok(finest)
    }

    /// Adds parts of `bytes` to what is there, and shows them.
    fn add(
        &mut self,
        parts: &[Part],
        bytes: &[u8],
        (arrival, arriving): (Arrival, Option<usize>),
        rig: &Rig,
    ) -> Result<Range<usize>, StreamError> {
        let grown = self.basis.with(parts, bytes, rig, self.elements)?;
        let basis = grown.map(|grown| std::mem::replace(&mut self.basis, grown));
        let arriving_before = std::mem::replace(&mut self.arriving, arriving);
        let mut redo = BTreeMap::new();
        if basis.is_some() {
            redo.extend(self.access_units().map(|number| (number, Redo::All)));
        }
        if arriving_before != arriving {
            let both = [arriving_before, arriving].into_iter().flatten();
            redo.extend(both.map(|number| (number, Redo::All)));
        }
        let mut added = Added {
            bytes: self.arrived.bytes(),
            ..Added::default()
        };
        let done = self.add_units(parts, bytes, &mut added, &mut redo);
        let done = done.and_then(|()| self.show_sound(&mut redo, &added, rig));
        let done = done.and_then(|changed| match arrival {
            Arrival::InOrder => self.check_tiers(&added).map(|()| changed),
            Arrival::Any => Ok(changed),
        });
        match done {
            Ok(_) if basis.is_some() => Ok(0..self.head().frames),
            Err(error) => {
                self.take_back(&added);
                self.arriving = arriving_before;
                match basis {
                    Some(basis) => self.basis = basis,
                    None => drop(self.show(&redo, rig)),
                }
                Err(error)
            }
            done => done,
        }
    }

    /// Adds the access units and units among some parts of `bytes`.
    fn add_units(
        &mut self,
        parts: &[Part],
        bytes: &[u8],
        added: &mut Added,
        redo: &mut BTreeMap<usize, Redo>,
    ) -> Result<(), StreamError> {
        for part in parts {
            match part {
                Part::Length { access_unit } => {
                    if self.arrived.open(*access_unit) {
                        added.access_units.push(*access_unit);
                        redo.insert(*access_unit, Redo::All);
                    }
                }
                Part::Unit {
                    access_unit: Some(access_unit),
                    number,
                    at,
                    body,
                } => {
                    let unit = ArrivingUnit {
                        access_unit: *access_unit,
                        number: *number,
                        at: *at,
                        body: &bytes[body.clone()],
                    };
                    match self.arrived.take(&unit) {
                        Taken::Same => {}
                        Taken::Other => {
                            let what = format!("unit {number} has other bytes than before");
                            return Err(at_byte(*at, *access_unit, what));
                        }
                        Taken::New => {
                            added.units.push((*access_unit, *number));
                            let (group, _) = self.head().group_and_tier(*number);
                            let none = || Redo::Groups(BTreeSet::new());
                            let of = redo.entry(*access_unit).or_insert_with(none);
                            if let Redo::Groups(groups) = of {
                                groups.insert(group);
                            }
                        }
                    }
                }
                Part::Unit { .. } => {}
            }
        }
        Ok(())
    }

    /// As [`Self::show`]. A unit that was there before, and only now turns out not to decode, is removed.
    fn show_sound(
        &mut self,
        redo: &mut BTreeMap<usize, Redo>,
        added: &Added,
        rig: &Rig,
    ) -> Result<Range<usize>, StreamError> {
        let mut first = None;
        loop {
            match self.show(redo, rig) {
                Ok(changed) => return first.map_or(Ok(changed), Err),
                Err(fault) => {
                    let of = (fault.access_unit, fault.number);
                    if added.units.contains(&of) {
                        return Err(fault.error);
                    }
                    self.arrived.remove(fault.access_unit, fault.number);
                    first.get_or_insert(fault.error);
                }
            }
        }
    }

    /// Removes what was added.
    fn take_back(&mut self, added: &Added) {
        for (access_unit, number) in &added.units {
            self.arrived.remove(*access_unit, *number);
        }
        for access_unit in &added.access_units {
            self.arrived.close(*access_unit);
        }
        self.arrived.truncate(added.bytes);
    }

    /// Checks that units that came in the order of the bytes need none that is missing.
    fn check_tiers(&self, added: &Added) -> Result<(), StreamError> {
        let Self { basis, arrived, .. } = self;
        let head = &basis.read.head;
        for (access_unit, number) in &added.units {
            let (group, tier) = head.group_and_tier(*number);
            let at = arrived
                .unit(*access_unit, *number)
                .map_or(0, |unit| unit.at);
            let bad = |what| Err(at_byte(at, *access_unit, what));
            if !basis.table.has_pose[group] {
                return bad(format!(
                    "a unit of group {group}, whose pose unit is missing"
                ));
            }
            let tiers = arrived
                .of_group(head, *access_unit, group)
                .map(|(tier, _)| tier);
            let missing = basis.table.missing_tier(head.tiers, group, tiers);
            if let Some(missing) = missing.filter(|missing| *missing > tier) {
                return bad(format!(
                    "tier {tier} of group {group} without tier {missing}"
                ));
            }
        }
        Ok(())
    }

    /// Decodes and shows what changed in some access units, and what follows it; returns the frames that
    /// changed.
    fn show(&mut self, redo: &BTreeMap<usize, Redo>, rig: &Rig) -> Result<Range<usize>, Fault> {
        let (Some(first), Some(last)) = (redo.keys().next(), redo.keys().next_back()) else {
            return Ok(0..0);
        };
        for (access_unit, redo) in redo {
            if self.arrived.has(*access_unit) {
                self.decode(*access_unit, redo, rig)?;
            }
        }
        let head = &self.basis.read.head;
        let mut changed = head.frames_of(*first).start..head.frames_of(*last).end;
        changed.end = self.follow(*first, changed.end, rig);
        Ok(changed)
    }

    /// Sets the frames of an access unit that is there by its units alone.
    fn decode(&mut self, access_unit: usize, redo: &Redo, rig: &Rig) -> Result<(), Fault> {
        let Self {
            basis:
                Basis {
                    read,
                    table,
                    moving,
                    shown,
                    ..
                },
            arrived,
            arriving,
            decoder,
            ..
        } = self;
        let head = &read.head;
        let frames = head.frames_of(access_unit);
        let groups = match redo {
            Redo::Groups(groups) => groups.clone(),
            Redo::All => arrived.groups(head, access_unit).into_iter().collect(),
        };
        if matches!(redo, Redo::All) && *arriving != Some(access_unit) {
            for group in moving.iter() {
                if !arrived.begins(head, access_unit, *group) {
                    for track in &table.of_group[*group] {
                        let place = (*track, &table.tracks[*track]);
                        shown.rest(place, frames.clone(), rig);
                    }
                }
            }
        }
        for group in groups.into_iter().filter(|group| table.has_pose[*group]) {
            let units = arrived.of_group(head, access_unit, group);
            let of = (head, &*table, group);
            let decoded = decoder.decode(of, frames.len(), units, |track, values| {
                let place = (track, &table.tracks[track]);
                shown.set(place, frames.start, values, rig);
            });
            decoded.map_err(|bad| {
                let number = head.unit_number(group, bad.tier);
                let at = arrived.unit(access_unit, number).map_or(0, |unit| unit.at);
                Fault {
                    access_unit,
                    number,
                    error: at_byte(at, access_unit, bad.what),
                }
            })?;
        }
        Ok(())
    }

    /// Makes the tracks follow from an access unit on, of which frames before `changed` are new; returns
    /// the end of the frames that changed.
    fn follow(&mut self, first: usize, changed: usize, rig: &Rig) -> usize {
        let spans = self.spans(first);
        let Self {
            basis:
                Basis {
                    read,
                    table,
                    moving,
                    shown,
                    ..
                },
            arrived,
            arriving,
            ..
        } = self;
        let head = &read.head;
        let mut end = changed;
        for group in moving.iter() {
            let source = |access_unit: &Option<usize>| match access_unit {
                None => Source::Before,
                Some(number) if arrived.begins(head, *number, *group) => Source::Values,
                Some(number) if *arriving == Some(*number) => Source::Before,
                Some(_) => Source::Reference,
            };
            for track in &table.of_group[*group] {
                let spans = spans
                    .iter()
                    .map(|(frames, of)| (frames.clone(), source(of)));
                let place = (*track, &table.tracks[*track]);
                end = end.max(shown.follow(place, spans, changed, rig));
            }
        }
        end
    }

    /// All frames from an access unit on.
    fn spans(&self, first: usize) -> Vec<Span> {
        let head = self.head();
        let mut at = head.frames_of(first).start;
        let mut spans = Vec::new();
        for access_unit in self.arrived.access_units(first) {
            let frames = head.frames_of(access_unit);
            if frames.start > at {
                spans.push((at..frames.start, None));
            }
            at = frames.end;
            spans.push((frames, Some(access_unit)));
        }
        if at < head.frames {
            spans.push((at..head.frames, None));
        }
        spans
    }

    /// Calls `see` with the whole numbers of each track of each access unit that is not arriving, in
    /// rising order.
    pub(super) fn visit(&self, mut see: impl FnMut(&[i64])) {
        let head = self.head();
        let table = &self.basis.table;
        let mut decoder = GroupDecoder::default();
        for access_unit in self.access_units().filter(|n| !self.is_arriving(*n)) {
            let frames = head.frames_of(access_unit).len();
            let groups = self.arrived.groups(head, access_unit).into_iter();
            for group in groups.filter(|group| table.has_pose[*group]) {
                let units = self.arrived.of_group(head, access_unit, group);
                // What is there has been decoded.
                let _ = decoder.decode((head, table, group), frames, units, |_, x| see(x));
            }
        }
    }
}

fn at_byte(at: u64, access_unit: usize, what: impl Into<String>) -> StreamError {
    StreamError::malformed(format!("byte {at} (access unit {access_unit})"), what)
}
