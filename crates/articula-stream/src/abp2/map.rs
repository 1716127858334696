//! The map of a motion stream, by which it is cut.

use super::access_unit::{AccessUnit, PREFIX};
use super::grouping::Grouping;
use super::head::{self, MotionHead, PosePlace, ReadHead};
use crate::coding::Coding;
use crate::error::StreamError;
use crate::limits::StreamLimits;
use crate::unit::{Field, Meaning, Unit, bits_of};
use std::ops::Range;

/// Returns the map of a stream: the head with its pose units, then the access units with their
/// units, marked `loa`, `region`, `joint` (of morph targets `face_loa`, `face_region`) and `tier`. Labels as in `docs/formats/abp2.md`.
///
/// # Errors
/// A [`StreamError`] if the stream is malformed or ends early.
pub fn motion_map(stream: &[u8], limits: &StreamLimits) -> Result<Unit, StreamError> {
    let (map, is_whole) = map_of_whole(stream, limits)?;
    if is_whole {
        return Ok(map);
    }
    let at = format!("byte {}", stream.len());
    Err(StreamError::malformed(at, "unexpected end"))
}

/// Returns the map of a stream that may end early: the head and the access units that are there as a
/// whole, as [`motion_map`] has them; the first part of the map is the head. Bytes behind the map are of
/// an access unit that is not there as a whole.
///
/// # Errors
/// A [`StreamError`] if what is there is malformed, or ends within the head.
pub fn prefix_map(stream: &[u8], limits: &StreamLimits) -> Result<Unit, StreamError> {
    Ok(map_of_whole(stream, limits)?.0)
}

/// The map of the access units that are there as a whole, and whether these are all.
fn map_of_whole(stream: &[u8], limits: &StreamLimits) -> Result<(Unit, bool), StreamError> {
    let read = MotionHead::open_read(stream, limits)?;
    let mut children = vec![head_unit(&read, stream)];
    let mut at = read.bytes;
    for number in 0..read.head.access_units {
        let access_unit = AccessUnit::read(stream, at, number, &read.head)?;
        let Some(whole) = access_unit.filter(|a| a.is_whole) else {
            break;
        };
        children.push(access_unit_unit(&whole, number, &read.head));
        at = whole.bytes.end;
    }
    let is_whole = children.len() > read.head.access_units;
    if is_whole && at < stream.len() {
        let what = "bytes after the last access unit";
        return Err(StreamError::malformed(format!("byte {at}"), what));
    }
    let label = match read.head.face {
        Some(_) => "afp2",
        None => "abp2",
    };
    let map = Unit {
        children,
        ..Unit::of_bytes(label, 0..at)
    };
    Ok((map, is_whole))
}

fn length(name: &'static str, bytes: Range<usize>, value: usize) -> Field {
    Field {
        name: name.into(),
        bits: bits_of(bytes),
        value: value as u64,
        coding: Coding::BigEndian,
        meaning: Meaning::BytesAfter,
    }
}

/// Marks a unit with the labels of its group.
fn marked(unit: Unit, number: usize, head: &MotionHead) -> Unit {
    let group = head.group(number);
    if number >= head.groups.len() {
        return unit
            .marked("face_loa", u32::from(group.loa))
            .marked("face_region", u32::from(group.region));
    }
    let mut unit = unit.marked("loa", u32::from(group.loa));
    if head.grouping != Grouping::Loa {
        unit = unit.marked("region", u32::from(group.region));
    }
    match group.joint {
        Some(joint) => unit.marked("joint", u32::from(joint)),
        None => unit,
    }
}

fn head_unit(read: &ReadHead, stream: &[u8]) -> Unit {
    let levels = read.head.pose_levels();
    let pose = |place: &PosePlace| {
        let unit = Unit::of_bytes("pose", place.bytes.clone());
        match levels.get(place.number) {
            Some(level) => unit.marked("pose_loa", u32::from(*level)),
            None => unit,
        }
    };
    let mut units: Vec<Unit> = read.poses.iter().map(pose).collect();
    let skeleton = read.skeleton.iter();
    units.extend(skeleton.map(|place| Unit::of_bytes("skeleton", place.bytes.clone())));
    units.sort_by_key(|unit| unit.bits.start);
    let value = u32::from_be_bytes([stream[4], stream[5], stream[6], stream[7]]);
    Unit {
        fields: vec![length("head_bytes", 4..head::PREFIX, value as usize)],
        children: units,
        ..Unit::of_bytes("head", 0..read.bytes)
    }
}

fn access_unit_unit(access_unit: &AccessUnit, number: usize, head: &MotionHead) -> Unit {
    let start = access_unit.bytes.start;
    let units = access_unit.units.iter().map(|unit| {
        let of_bytes = Unit::of_bytes("unit", unit.bytes.clone());
        marked(of_bytes, unit.group, head).marked("tier", unit.tier as u32)
    });
    let after = start + PREFIX;
    let mut children = Vec::new();
    // Version 1 repeats the number of frames.
    if access_unit.header > PREFIX {
        children.push(Unit::of_bytes("frames", after..start + access_unit.header));
    }
    children.extend(units);
    Unit {
        fields: vec![length(
            "au_bytes",
            start..after,
            access_unit.bytes.end - after,
        )],
        children,
        ..Unit::of_bytes("access_unit", access_unit.bytes.clone())
    }
    .marked("access_unit", number as u32)
}
