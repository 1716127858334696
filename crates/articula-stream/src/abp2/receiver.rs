//! Client side of a motion stream: bytes as they arrive, a clip that refines.

use super::head::MotionHead;
use super::motion_state::{Arrival, MotionState};
use crate::error::StreamError;
use crate::limits::StreamLimits;
use articula_core::{Clip, Mismatch, Rig};
use std::collections::BTreeMap;
use std::ops::Range;

/// Receives a motion stream and decodes what is there: whole, in pieces of any length
/// ([`Self::receive`]), or its units in any order ([`Self::receive_at`], [`Self::receive_units`]).
///
/// What is shown depends on what is there, not on the order in which it came. An access unit is there
/// once its length is, or a unit of it. A group whose units are missing in an access unit that is there
/// keeps its reference pose in it; a unit whose coarser ones are missing waits for them. Frames of access
/// units that are not there hold the frame before them, at first the reference pose. While an access
/// unit is arriving by [`Self::receive`], groups that are not there yet hold the frame before it.
///
/// The decoded whole numbers are the same on every platform, and so are the rotations and translations
/// made of them.
#[derive(Debug, Clone)]
pub struct MotionReceiver {
    rig: Rig,
    /// Whether face streams are received, in place of motions.
    of_face: bool,
    limits: StreamLimits,
    /// Bytes that came in order.
    in_order: u64,
    /// Bytes that end within a part or wait until it is known where they belong, by their first.
    waiting: BTreeMap<u64, Vec<u8>>,
    state: Option<MotionState>,
}

/// An access unit that is there.
#[derive(Debug, Clone)]
pub(crate) struct AccessUnitThere {
    pub(crate) frames: Range<usize>,
    /// The groups that show values of their own, rising.
    pub(crate) groups: Vec<usize>,
    /// Whether it is arriving in the order of the bytes.
    pub(crate) is_arriving: bool,
}

impl MotionReceiver {
    /// Creates a receiver of a motion of this rig.
    pub fn new(rig: &Rig, limits: &StreamLimits) -> Self {
        Self {
            rig: rig.clone(),
            of_face: false,
            limits: *limits,
            in_order: 0,
            waiting: BTreeMap::new(),
            state: None,
        }
    }

    /// Creates a receiver of the channels of a face, which are those of this rig.
    pub(crate) fn of_face(rig: &Rig, limits: &StreamLimits) -> Self {
        Self {
            of_face: true,
            ..Self::new(rig, limits)
        }
    }

    /// Reads a stream, or a prefix of one.
    ///
    /// # Errors
    /// As [`Self::receive`]; a stream that ends early is not an error.
    pub fn read(bytes: &[u8], rig: &Rig, limits: &StreamLimits) -> Result<Self, StreamError> {
        let mut receiver = Self::new(rig, limits);
        receiver.receive(bytes)?;
        Ok(receiver)
    }

    /// Takes the next bytes of the stream, decodes the units that they complete, and returns the
    /// frames that changed.
    ///
    /// # Errors
    /// A [`StreamError`] that names the byte: malformed bytes, a head or unit that was damaged, a motion
    /// of another rig, more than the limits allow. The receiver stays as it was.
    pub fn receive(&mut self, more: &[u8]) -> Result<Range<usize>, StreamError> {
        let changed = self.take(self.in_order, more, Arrival::InOrder)?;
        self.in_order += more.len() as u64;
        Ok(changed)
    }

    /// Takes bytes of the stream from byte `offset` on, in any order and also again, decodes the units
    /// that they complete, and returns the frames that changed.
    ///
    /// The bytes must begin with a unit or the length of an access unit, as the ranges of
    /// [`difference`](crate::difference()) do, or where bytes that it took ended; those from 0 on must
    /// hold the head up to its first unit. Bytes wait until the head is there, and until the lengths of
    /// all access units before theirs are.
    ///
    /// # Errors
    /// A [`StreamError`] that names the byte: as [`Self::receive`], and units that are there with other
    /// bytes. The receiver stays as it was, unless the fault is in bytes that had waited or in a unit that
    /// had waited for a coarser one: then only what is at fault is dropped, and any frame may have
    /// changed.
    pub fn receive_at(&mut self, offset: u64, bytes: &[u8]) -> Result<Range<usize>, StreamError> {
        if bytes.is_empty() {
            return Ok(0..0);
        }
        self.take(offset, bytes, Arrival::Any)
    }

    /// Takes whole units of an access unit, in any order and also again, wherever they were stored, and
    /// returns the frames that changed. The access unit is there from then on, also if there are none.
    ///
    /// # Errors
    /// As [`Self::receive_at`], with the byte of those given; a [`Mismatch`] before the fields of the head
    /// are there, and for an access unit that the motion does not have.
    pub fn receive_units(
        &mut self,
        access_unit: usize,
        units: &[u8],
    ) -> Result<Range<usize>, StreamError> {
        self.check_limit(0, units)?;
        let Some(state) = &mut self.state else {
            return Err(Mismatch::new("stream", "the head has not arrived").into());
        };
        let count = state.head().access_units;
        if access_unit >= count {
            let what = format!("{access_unit}, the motion has {count}");
            return Err(Mismatch::new("access unit", what).into());
        }
        state.take_units(access_unit, units, &self.rig)
    }

    /// Returns the head without its units, if it has arrived.
    pub fn head(&self) -> Option<&MotionHead> {
        self.state.as_ref().map(MotionState::head)
    }

    /// Returns the number of frames that can be shown, from the first: those before the first access
    /// unit that is not there.
    pub fn frames(&self) -> usize {
        self.state.as_ref().map_or(0, MotionState::frames)
    }

    /// Returns whether every access unit is there, and none is still arriving in the order of the bytes.
    pub fn is_whole(&self) -> bool {
        self.state.as_ref().is_some_and(MotionState::is_whole)
    }

    /// Returns a hash (FNV-1a, over 64 bits at a time) of all whole numbers of the access units that are
    /// there, but for one that is arriving, to compare platforms. Decodes all units anew.
    pub fn hash(&self) -> u64 {
        let mut hash = FNV_START;
        if let Some(state) = &self.state {
            state.visit(|values| hash = hashed(hash, values));
        }
        hash
    }

    /// The access units that are there, rising.
    pub(crate) fn access_units(&self) -> Vec<AccessUnitThere> {
        let Some(state) = &self.state else {
            return Vec::new();
        };
        let head = state.head();
        let there = |number: usize| AccessUnitThere {
            frames: head.frames_of(number),
            groups: state.groups(number),
            is_arriving: state.is_arriving(number),
        };
        state.access_units().map(there).collect()
    }

    /// Returns the motion as received so far.
    ///
    /// # Errors
    /// A [`Mismatch`] if the head has not arrived.
    pub fn clip(&self) -> Result<Clip, Mismatch> {
        let Some(state) = &self.state else {
            return Err(Mismatch::new("stream", "the head has not arrived"));
        };
        let head = state.head();
        let tracks = state.tracks().clone();
        Clip::new(&head.name, head.rate_hz, head.frames, head.joints, tracks)
    }

    /// Checks that a stream with these bytes, and what is stored with them, is not too large.
    fn check_limit(&self, offset: u64, bytes: &[u8]) -> Result<(), StreamError> {
        let waiting: usize = self.waiting.values().map(Vec::len).sum();
        let stored = self.state.as_ref().map_or(0, MotionState::bytes) + waiting;
        let total = offset.max(stored as u64).saturating_add(bytes.len() as u64);
        StreamLimits::check("the stream", "bytes", total, self.limits.bytes)
    }

    /// Takes bytes, with those before them that wait for them, and then what waited for what they tell.
    fn take(
        &mut self,
        offset: u64,
        more: &[u8],
        arrival: Arrival,
    ) -> Result<Range<usize>, StreamError> {
        self.check_limit(offset, more)?;
        let before = self.waiting.range(..offset).next_back();
        let before = before.filter(|(start, bytes)| **start + bytes.len() as u64 == offset);
        let before = before.map(|(start, _)| *start);
        let mut joined = before.and_then(|start| self.waiting.remove(&start));
        let known = self.known_lengths();
        let result = match &mut joined {
            None => self.take_piece((offset, more), arrival),
            Some(bytes) => {
                bytes.extend(more);
                self.take_piece((offset - (bytes.len() - more.len()) as u64, bytes), arrival)
            }
        };
        let length = joined.as_ref().map_or(0, |bytes| bytes.len() - more.len());
        let start = offset - length as u64;
        let (changed, taken) = match result {
            Ok(done) => done,
            Err(error) => {
                if let Some(mut bytes) = joined {
                    bytes.truncate(length);
                    self.waiting.insert(start, bytes);
                }
                return Err(error);
            }
        };
        let left = match joined {
            None => more[taken..].to_vec(),
            Some(mut bytes) => {
                bytes.drain(..taken);
                bytes
            }
        };
        self.wait(start + taken as u64, left);
        if self.known_lengths() == known {
            return Ok(changed);
        }
        Ok(united(changed, self.take_waiting()?))
    }

    /// Keeps bytes until more are there, unless longer ones wait at the same place.
    fn wait(&mut self, start: u64, bytes: Vec<u8>) {
        let there = self.waiting.get(&start).map_or(0, Vec::len);
        if bytes.len() > there {
            self.waiting.insert(start, bytes);
        }
    }

    /// Number of access units whose length is known; `None` before the fields of the head are there.
    fn known_lengths(&self) -> Option<usize> {
        self.state.as_ref().map(MotionState::known_lengths)
    }

    /// Takes what waits and can be taken by now. What is at fault is dropped.
    fn take_waiting(&mut self) -> Result<Range<usize>, StreamError> {
        let mut changed = Ok(0..0);
        let starts: Vec<u64> = self.waiting.keys().copied().collect();
        for start in starts {
            let Some(mut bytes) = self.waiting.remove(&start) else {
                continue;
            };
            match self.take_piece((start, &bytes), Arrival::Any) {
                Ok((more, taken)) => {
                    bytes.drain(..taken);
                    self.wait(start + taken as u64, bytes);
                    changed = changed.map(|changed| united(changed, more));
                }
                Err(error) => changed = changed.and(Err(error)),
            }
        }
        changed
    }

    /// Takes bytes that begin with a part; returns the frames that changed, and how many were taken.
    fn take_piece(
        &mut self,
        (start, bytes): (u64, &[u8]),
        arrival: Arrival,
    ) -> Result<(Range<usize>, usize), StreamError> {
        if let Some(state) = &mut self.state {
            return state.take((start, bytes), arrival, &self.rig);
        }
        if start > 0 {
            return Ok((0..0, 0));
        }
        let end = MotionHead::end(bytes, &self.limits)?;
        if arrival == Arrival::InOrder && end.is_none_or(|end| bytes.len() < end) {
            return Ok((0..0, 0));
        }
        let mut state = MotionState::new(bytes, &self.rig, &self.limits)?;
        if state.head().face.is_some() != self.of_face {
            let expected = match self.of_face {
                true => "expected a face stream, AFP2",
                false => "expected a motion stream, ABP2",
            };
            return Err(StreamError::malformed("byte 0", expected));
        }
        let taken = state.take((start, bytes), arrival, &self.rig)?;
        self.state = Some(state);
        Ok(taken)
    }
}

/// The frames from the first of two ranges to the last.
fn united(a: Range<usize>, b: Range<usize>) -> Range<usize> {
    match (a.is_empty(), b.is_empty()) {
        (true, _) => b,
        (_, true) => a,
        _ => a.start.min(b.start)..a.end.max(b.end),
    }
}

const FNV_START: u64 = 0xcbf2_9ce4_8422_2325;

fn hashed(hash: u64, values: &[i64]) -> u64 {
    let words = values.iter().map(|x| *x as u64);
    words.fold(hash, |h, word| (h ^ word).wrapping_mul(0x0100_0000_01b3))
}
