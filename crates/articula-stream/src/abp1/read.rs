//! Decoding of a file, and its map.

use super::access_unit::{self, AccessUnit};
use super::clip::{Abp1Clip, Bone, BoneTracks, TrackKind};
use super::head::{self, Opened};
use crate::coding::Coding;
use crate::component::FRAMES;
use crate::error::StreamError;
use crate::frame_rate::FrameRate;
use crate::limits::StreamLimits;
use crate::unit::{Field, Meaning, Unit};
use std::ops::Range;

/// Pose of a bone in an access unit that does not have it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AbsentBone {
    /// At rest.
    #[default]
    Rest,
    /// As in the last frame that has it.
    Last,
}

/// Decodes a file. It may have been cut in any way: bones without access units have no track.
///
/// The frames are those of the access units, at most as many as the head says.
///
/// # Errors
/// [`StreamError::Malformed`] that names the head, byte or bit, [`StreamError::Unsupported`] for
/// another version or rotations other than rotation vectors, [`StreamError::LimitExceeded`].
pub fn read(
    bytes: &[u8],
    absent: AbsentBone,
    limits: &StreamLimits,
) -> Result<Abp1Clip, StreamError> {
    let (opened, container) = head::open(bytes, limits)?;
    let bones = opened.bones.len();
    let units = container.access_units.iter();
    let mut coded = Decoding::new(bones);
    for range in units {
        let unit = access_unit::read(bytes, range.clone(), bones)?;
        coded.access_unit(&unit, &opened, range.start, absent, limits)?;
    }
    Ok(coded.finish(opened))
}

struct Decoding {
    /// Coded frames, of the kinds and bones that were met.
    tracks: Vec<BoneTracks>,
    /// Number of coded frames.
    frames: usize,
    interpolated: Option<u8>,
    /// Number of tracks that were met.
    met: usize,
}

impl Decoding {
    fn new(bones: usize) -> Self {
        Self {
            tracks: vec![BoneTracks::default(); bones],
            frames: 0,
            interpolated: None,
            met: 0,
        }
    }

    fn access_unit(
        &mut self,
        unit: &AccessUnit,
        opened: &Opened,
        start: usize,
        absent: AbsentBone,
        limits: &StreamLimits,
    ) -> Result<(), StreamError> {
        let at = || format!("byte {start}");
        if !unit.has_vectors_only {
            return Err(StreamError::Unsupported {
                at: at(),
                what: "a rotation other than a rotation vector".into(),
                mend: "write the file with rotation vectors".into(),
            });
        }
        let plane = &unit.plane;
        let before = *self.interpolated.get_or_insert(plane.interpolated);
        if plane.rate.hz() != opened.rate.hz() || plane.interpolated != before {
            let what = "another frame rate or number of interpolated frames than before";
            return Err(StreamError::malformed(at(), what));
        }
        let is_new = |bone: &access_unit::CodedBone| {
            let known = &self.tracks[usize::from(bone.id)].0;
            let kinds = known.iter().zip(bone.kinds);
            kinds
                .filter(|(known, met)| known.is_none() && met.is_some())
                .count()
        };
        self.met += unit.bones.iter().map(is_new).sum::<usize>();
        let coded = self.frames + FRAMES;
        let shown = coded
            .saturating_mul(usize::from(before) + 1)
            .min(opened.total_frames);
        let elements = (3 * self.met as u64).saturating_mul(coded.max(shown) as u64);
        StreamLimits::check(&at(), "elements", elements, limits.elements)?;
        let mut is_there = vec![[false; TrackKind::ALL.len()]; self.tracks.len()];
        for bone in &unit.bones {
            let b = usize::from(bone.id);
            let mut blocks = bone.blocks.iter();
            for (kind, axes) in TrackKind::ALL.into_iter().zip(bone.kinds) {
                let Some(axes) = axes else { continue };
                is_there[b][kind as usize] = true;
                let rest = kind.rest(&opened.bones[b]);
                let step = opened.base_steps.of(kind) * plane.scale();
                let mut values = [rest; FRAMES];
                for (axis, _) in axes.iter().enumerate().filter(|(_, is_coded)| **is_coded) {
                    let Some(block) = blocks.next() else { break };
                    for (value, decoded) in values.iter_mut().zip(block.values(step)) {
                        value[axis] = decoded as f32;
                    }
                }
                let track = &mut self.tracks[b].0[kind as usize];
                let track = track.get_or_insert_with(|| vec![rest; self.frames]);
                track.extend(values);
            }
        }
        self.fill(&is_there, &opened.bones, absent);
        self.frames += FRAMES;
        Ok(())
    }

    /// Extends the tracks that the access unit does not have.
    fn fill(
        &mut self,
        is_there: &[[bool; TrackKind::ALL.len()]],
        bones: &[Bone],
        absent: AbsentBone,
    ) {
        for ((tracks, there), bone) in self.tracks.iter_mut().zip(is_there).zip(bones) {
            for (kind, track) in TrackKind::ALL.into_iter().zip(&mut tracks.0) {
                let Some(track) = track.as_mut().filter(|_| !there[kind as usize]) else {
                    continue;
                };
                let rest = kind.rest(bone);
                let value = match absent {
                    AbsentBone::Rest => rest,
                    AbsentBone::Last => track.last().copied().unwrap_or(rest),
                };
                track.extend([value; FRAMES]);
            }
        }
    }

    /// Inserts interpolated frames and removes those after the last.
    fn finish(self, opened: Opened) -> Abp1Clip {
        let stride = usize::from(self.interpolated.unwrap_or(0)) + 1;
        let all = self.frames.saturating_sub(1).saturating_mul(stride) + 1;
        let frames = opened
            .total_frames
            .min(if self.frames == 0 { 0 } else { all });
        let mut tracks = self.tracks;
        for track in tracks.iter_mut().flat_map(|t| &mut t.0).flatten() {
            if stride > 1 {
                *track = (0..frames).map(|f| between(track, f, stride)).collect();
            }
            track.truncate(frames);
        }
        Abp1Clip {
            name: opened.name,
            bones: opened.bones,
            rate: opened.rate,
            frames,
            tracks,
        }
    }
}

/// Value of a frame between coded ones.
fn between(coded: &[[f32; 3]], frame: usize, stride: usize) -> [f32; 3] {
    let (before, rest) = (frame / stride, frame % stride);
    if rest == 0 {
        return coded[before];
    }
    let part = rest as f32 / stride as f32;
    let (a, b) = (coded[before], coded[before + 1]);
    std::array::from_fn(|axis| a[axis] + (b[axis] - a[axis]) * part)
}

/// Returns the map of a file, by which [`crate::cut()`] removes bones and access units.
///
/// The bones of an access unit have the markers `loa`, `region` and `joint`, access units
/// `access_unit`.
///
/// # Errors
/// As [`read`], but any form of rotation is mapped.
pub fn unit(bytes: &[u8], limits: &StreamLimits) -> Result<Unit, StreamError> {
    let (opened, container) = head::open(bytes, limits)?;
    let parts = container.access_units.iter().map(|range| {
        let unit = access_unit::read(bytes, range.clone(), opened.bones.len())?;
        Ok(parts(&unit, &opened.bones))
    });
    let parts = parts.collect::<Result<Vec<_>, StreamError>>()?;
    Ok(container.map("ABP-1", parts))
}

/// Returns the rate of a file and the number of frames that each access unit adds to the clip.
///
/// # Errors
/// As [`unit`], and if access units differ in the number of interpolated frames.
pub(crate) fn frames_of(
    bytes: &[u8],
    limits: &StreamLimits,
) -> Result<(FrameRate, Vec<usize>), StreamError> {
    let (opened, container) = head::open(bytes, limits)?;
    let mut interpolated = None;
    let mut frames = Vec::with_capacity(container.access_units.len());
    let mut shown = 0;
    for (number, range) in container.access_units.iter().enumerate() {
        let plane = access_unit::read(bytes, range.clone(), opened.bones.len())?.plane;
        let before = *interpolated.get_or_insert(plane.interpolated);
        if plane.interpolated != before {
            let what = "another number of interpolated frames than before";
            return Err(StreamError::malformed(
                format!("byte {}", range.start),
                what,
            ));
        }
        let stride = usize::from(before) + 1;
        let is_last = number + 1 == container.access_units.len();
        // After the last coded frame nothing is interpolated.
        let coded = (number + 1) * FRAMES - usize::from(is_last);
        let end = coded
            .saturating_mul(stride)
            .saturating_add(usize::from(is_last))
            .min(opened.total_frames);
        frames.push(end - shown);
        shown = end;
    }
    Ok((opened.rate, frames))
}

/// Fields and parts of an access unit, with the names of the annex of the thesis.
fn parts(unit: &AccessUnit, bones: &[Bone]) -> (Vec<Field>, Vec<Unit>) {
    let places = &unit.places;
    let part = |label: &'static str, bits: &Range<u64>| Unit {
        bits: bits.clone(),
        ..Unit::of_bytes(label, 0..0)
    };
    let of_bone = |label, coded: &access_unit::CodedBone, bits| {
        let bone = &bones[usize::from(coded.id)];
        part(label, bits)
            .marked("loa", u32::from(bone.loa))
            .marked("region", u32::from(bone.region))
            .marked("joint", u32::from(coded.id))
    };
    let masks = unit.bones.iter().zip(&places.masks);
    let mut segment: Vec<Unit> = masks
        .map(|(bone, bits)| of_bone("BoneMask", bone, bits))
        .collect();
    segment.push(part("BBACodingType", &places.coding));
    let values = unit.bones.iter().zip(&places.values);
    segment.extend(values.map(|(bone, bits)| of_bone("BoneValue", bone, bits)));
    segment.push(Unit {
        padding: true,
        ..part("Padding", &places.padding)
    });
    let bone_segment = Unit {
        children: segment,
        ..part("BoneSegment", &(places.main.end..places.padding.end))
    };
    let count = Field {
        name: "NoOfBones".into(),
        bits: places.bone_count.clone(),
        value: unit.bones.len() as u64,
        coding: Coding::BigEndian,
        meaning: Meaning::CountOf("BoneMask".into()),
    };
    let children = vec![
        part("BBAPlane", &places.plane),
        part("MainHeader", &places.main),
        bone_segment,
        part("BBAPlaneEnd", &places.end),
    ];
    (vec![count], children)
}
