//! Client side of a motion stream: bytes as they arrive, a clip that refines.

use super::access_unit::AccessUnit;
use super::decode::AccessUnitDecoder;
use super::head::{MotionHead, ReadHead};
use super::pose_unit::{Kind, TrackForm};
use super::rotation::{exp, product};
use super::step::POINT;
use super::tracks::{TrackPlace, TrackTable};
use crate::error::StreamError;
use crate::limits::StreamLimits;
use articula_core::{Clip, Mismatch, Rig, Track, Tracks, same_hemisphere};
use glam::{Quat, Vec3};
use std::ops::Range;

/// Receives a motion stream, whole or in pieces of any length, and decodes what is there.
///
/// A group whose units are missing in a whole access unit keeps its reference pose there. While an
/// access unit is arriving, groups that are not there yet hold the frame before it; frames of access
/// units that have not arrived hold the last frame that has. The decoded whole numbers are
/// the same on every platform, and so are the rotations and translations made of them.
#[derive(Debug, Clone)]
pub struct MotionReceiver {
    rig: Rig,
    /// Whether face streams are received, in place of motions.
    of_face: bool,
    limits: StreamLimits,
    bytes: Vec<u8>,
    started: Option<Started>,
}

#[derive(Debug, Clone)]
struct Started {
    read: ReadHead,
    table: TrackTable,
    tracks: Tracks,
    /// For each track of the table its index in the tracks of its kind.
    shown: Vec<usize>,
    decoder: AccessUnitDecoder,
    /// Start of the first access unit that is not whole, and its number.
    next: (usize, usize),
    /// Frames before this are decoded, some perhaps coarsely.
    frames: usize,
    hash: u64,
}

impl MotionReceiver {
    /// Creates a receiver of a motion of this rig.
    pub fn new(rig: &Rig, limits: &StreamLimits) -> Self {
        Self {
            rig: rig.clone(),
            of_face: false,
            limits: *limits,
            bytes: Vec::new(),
            started: None,
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
    /// of another rig, more than the limits allow. The receiver keeps what it had decoded before.
    pub fn receive(&mut self, more: &[u8]) -> Result<Range<usize>, StreamError> {
        let total = (self.bytes.len() + more.len()) as u64;
        StreamLimits::check("the stream", "bytes", total, self.limits.bytes)?;
        self.bytes.extend(more);
        if self.started.is_none() {
            let Some(read) = MotionHead::read(&self.bytes, &self.limits)? else {
                return Ok(0..0);
            };
            if read.head.face.is_some() != self.of_face {
                let expected = if self.of_face {
                    "a face stream, AFP2"
                } else {
                    "a motion stream, ABP2"
                };
                return Err(StreamError::malformed(
                    "byte 0",
                    format!("expected {expected}"),
                ));
            }
            self.started = Some(Started::new(&self.bytes, read, &self.rig, &self.limits)?);
        }
        match &mut self.started {
            Some(started) => started.go_on(&self.bytes, &self.rig),
            None => Ok(0..0),
        }
    }

    /// Returns the head, if it has arrived.
    pub fn head(&self) -> Option<&MotionHead> {
        self.started.as_ref().map(|started| &started.read.head)
    }

    /// Returns the number of frames that can be shown, from the first.
    pub fn frames(&self) -> usize {
        self.started.as_ref().map_or(0, |started| started.frames)
    }

    /// Returns whether every access unit has arrived whole.
    pub fn is_whole(&self) -> bool {
        let started = self.started.as_ref();
        started.is_some_and(|s| s.next.1 == s.read.head.access_units)
    }

    /// Returns a hash (FNV-1a, over 64 bits at a time) of all whole numbers decoded from whole access
    /// units, to compare platforms.
    pub fn hash(&self) -> u64 {
        self.started
            .as_ref()
            .map_or(FNV_START, |started| started.hash)
    }

    /// The access units of which something has arrived.
    pub(crate) fn access_units(&self) -> Vec<AccessUnit> {
        let Some(started) = &self.started else {
            return Vec::new();
        };
        let mut at = started.read.bytes;
        let mut found = Vec::new();
        while found.len() < started.read.head.access_units {
            let read = AccessUnit::read(&self.bytes, at, found.len(), &started.read.head);
            let Ok(Some(access_unit)) = read else { break };
            at = access_unit.bytes.end;
            found.push(access_unit);
        }
        found
    }

    /// Returns the motion as received so far.
    ///
    /// # Errors
    /// A [`Mismatch`] if the head has not arrived.
    pub fn clip(&self) -> Result<Clip, Mismatch> {
        let Some(started) = &self.started else {
            return Err(Mismatch::new("stream", "the head has not arrived"));
        };
        let head = &started.read.head;
        let tracks = started.tracks.clone();
        Clip::new(&head.name, head.rate_hz, head.frames, head.joints, tracks)
    }
}

const FNV_START: u64 = 0xcbf2_9ce4_8422_2325;

fn hashed(hash: u64, values: &[i64]) -> u64 {
    let words = values.iter().map(|x| *x as u64);
    words.fold(hash, |h, word| (h ^ word).wrapping_mul(0x0100_0000_01b3))
}

impl Started {
    fn new(
        bytes: &[u8],
        read: ReadHead,
        rig: &Rig,
        limits: &StreamLimits,
    ) -> Result<Self, StreamError> {
        let table = TrackTable::read(bytes, &read, rig)?;
        let moving = table
            .tracks
            .iter()
            .filter(|track| track.moving().is_some())
            .count();
        let elements = moving as u64 * read.head.frames as u64;
        StreamLimits::check("the head", "values", elements, limits.elements)?;
        let (tracks, shown) = at_reference(&table, rig, read.head.frames);
        let frames = if read.head.access_units == 0 { 1 } else { 0 };
        Ok(Self {
            next: (read.bytes, 0),
            read,
            table,
            tracks,
            shown,
            decoder: AccessUnitDecoder::default(),
            frames,
            hash: FNV_START,
        })
    }

    /// Decodes the access units that have arrived since the last time.
    fn go_on(&mut self, bytes: &[u8], rig: &Rig) -> Result<Range<usize>, StreamError> {
        let head = &self.read.head;
        let first = head.frames_of(self.next.1).start;
        let mut changed = first..first;
        while self.next.1 < head.access_units {
            let (start, number) = self.next;
            let Some(access_unit) = AccessUnit::read(bytes, start, number, head)? else {
                break;
            };
            let frames = head.frames_of(number);
            let mut hash = self.hash;
            if access_unit.is_whole || frames.start == 0 {
                rest(&mut self.tracks, &self.table, &self.shown, &frames, rig);
            } else {
                hold(&mut self.tracks, frames.clone());
            }
            let Self {
                table,
                tracks,
                shown,
                decoder,
                ..
            } = self;
            decoder.decode(bytes, head, table, &access_unit, |track, values| {
                hash = hashed(hash, values);
                set(
                    tracks,
                    &table.tracks[track],
                    shown[track],
                    frames.start,
                    values,
                    rig,
                );
            })?;
            changed.end = frames.end;
            self.frames = frames.end;
            if !access_unit.is_whole {
                break;
            }
            self.hash = hash;
            self.next = (access_unit.bytes.end, number + 1);
        }
        if !changed.is_empty() && self.frames < head.frames {
            hold(&mut self.tracks, self.frames..head.frames);
            changed.end = head.frames;
        }
        let is_whole = self.next.1 == head.access_units;
        if is_whole && self.next.0 < bytes.len() {
            let at = format!("byte {}", self.next.0);
            return Err(StreamError::malformed(
                at,
                "bytes after the last access unit",
            ));
        }
        Ok(changed)
    }
}

/// All tracks at their reference values, and the index of each among those of its kind.
fn at_reference(table: &TrackTable, rig: &Rig, frames: usize) -> (Tracks, Vec<usize>) {
    let mut tracks = Tracks::default();
    let rest = rig.rest_pose();
    let mut shown = Vec::with_capacity(table.tracks.len());
    for place in &table.tracks {
        let target = place.target;
        let count = if place.moving().is_some() { frames } else { 1 };
        let is_rest = place.form == TrackForm::Rest;
        let joint = usize::from(target);
        let at = match place.kind {
            Kind::Rotation if !is_rest => push(
                &mut tracks.rotations,
                target,
                vec![place.rotation(rest.rotations[joint]); count],
            ),
            Kind::Translation if !is_rest => push(
                &mut tracks.translations,
                target,
                vec![place.vector(rest.translations[joint]); count],
            ),
            Kind::Scale if !is_rest => push(
                &mut tracks.scales,
                target,
                vec![place.vector(rest.scales[joint]); count],
            ),
            // A mesh has weights of its own: those at rest are told.
            Kind::Morph => push(
                &mut tracks.morphs,
                target,
                vec![place.reference()[0]; count],
            ),
            _ => usize::MAX,
        };
        shown.push(at);
    }
    (tracks, shown)
}

/// Sets moving tracks to their reference values in some frames.
fn rest(
    tracks: &mut Tracks,
    table: &TrackTable,
    shown: &[usize],
    frames: &Range<usize>,
    rig: &Rig,
) {
    let pose = rig.rest_pose();
    let moving = table
        .tracks
        .iter()
        .zip(shown)
        .filter(|(place, _)| place.moving().is_some());
    for (place, &at) in moving {
        let joint = usize::from(place.target);
        let frames = frames.clone();
        match place.kind {
            Kind::Rotation => {
                tracks.rotations[at].values[frames].fill(place.rotation(pose.rotations[joint]));
            }
            Kind::Translation => {
                let value = place.vector(pose.translations[joint]);
                tracks.translations[at].values[frames].fill(value);
            }
            Kind::Scale => tracks.scales[at].values[frames].fill(place.vector(pose.scales[joint])),
            Kind::Morph => tracks.morphs[at].values[frames].fill(place.reference()[0]),
        }
    }
}

fn push<T>(tracks: &mut Vec<Track<T>>, target: u16, values: Vec<T>) -> usize {
    tracks.push(Track {
        target,
        step: false,
        values,
    });
    tracks.len() - 1
}

/// Sets the frames of a track from `start` by decoded values.
fn set(
    tracks: &mut Tracks,
    place: &TrackPlace,
    shown: usize,
    start: usize,
    values: &[i64],
    rig: &Rig,
) {
    let joint = usize::from(place.target);
    let frames = values.len() / place.kind.axes();
    let unit = place.unit();
    let value = |axis: usize, i: usize| real(values[axis * frames + i]) * unit;
    let vector = |i: usize| [value(0, i), value(1, i), value(2, i)];
    let rest = rig.rest_pose();
    match place.kind {
        Kind::Rotation => {
            let reference = place.rotation(rest.rotations[joint]);
            let out = &mut tracks.rotations[shown].values;
            let mut before = if start > 0 { out[start - 1] } else { reference };
            for (i, out) in out[start..].iter_mut().take(frames).enumerate() {
                before = same_hemisphere(before, product(reference, exp(vector(i))));
                *out = before;
            }
        }
        Kind::Translation | Kind::Scale => {
            let (rest, out) = match place.kind {
                Kind::Scale => (rest.scales[joint], &mut tracks.scales[shown].values),
                _ => (
                    rest.translations[joint],
                    &mut tracks.translations[shown].values,
                ),
            };
            let reference = place.vector(rest);
            for (i, out) in out[start..].iter_mut().take(frames).enumerate() {
                *out = reference + Vec3::from(vector(i));
            }
        }
        Kind::Morph => {
            let reference = place.reference()[0];
            let out = &mut tracks.morphs[shown].values;
            for (i, out) in out[start..].iter_mut().take(frames).enumerate() {
                *out = reference + value(0, i);
            }
        }
    }
}

/// A decoded whole number as a value.
fn real(x: i64) -> f32 {
    x as f32 * (1.0 / (1_u32 << POINT) as f32)
}

/// Fills frames of the tracks that move with the frame before them.
fn hold(tracks: &mut Tracks, frames: Range<usize>) {
    fn each<T: Copy>(tracks: &mut [Track<T>], frames: &Range<usize>) {
        let moving = tracks.iter_mut();
        for track in moving.filter(|track| track.values.len() > frames.start) {
            let last = track.values[frames.start - 1];
            track.values[frames.clone()].fill(last);
        }
    }
    each::<Quat>(&mut tracks.rotations, &frames);
    each::<Vec3>(&mut tracks.translations, &frames);
    each::<Vec3>(&mut tracks.scales, &frames);
    each::<f32>(&mut tracks.morphs, &frames);
}
