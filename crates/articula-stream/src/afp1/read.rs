//! Decoding of a file, and its map.

use super::access_unit::{self, AccessUnit, CodedFap};
use super::head;
use crate::coding::Coding;
use crate::error::StreamError;
use crate::face::fade::Fade;
use crate::face::levels::{labels, levels_of};
use crate::face::{DecodedFace, FaceClip, FaceFrame, FaceReadOptions};
use crate::frame_rate::FrameRate;
use crate::limits::StreamLimits;
use crate::unit::{Field, Meaning, Unit};
use articula_core::fap_table::FAP_COUNT;
use std::ops::Range;

/// Decodes a file. It may have been cut in any way.
///
/// The level of a region in an access unit is the coarsest that keeps all its parameters that are
/// there. Parameters that this level does not keep copy others or are neutral, as the table of
/// levels says; those that it keeps, but the access unit lacks, are neutral.
///
/// # Errors
/// [`StreamError::Malformed`] that names the head, byte or bit, [`StreamError::Unsupported`] for
/// another version, [`StreamError::LimitExceeded`].
pub fn read(
    bytes: &[u8],
    options: &FaceReadOptions,
    limits: &StreamLimits,
) -> Result<DecodedFace, StreamError> {
    let (rate, container) = head::open(bytes, limits)?;
    let mut fade = Fade::new(options.fade_frames(rate));
    let mut coded = [false; FAP_COUNT];
    let mut frames = Vec::new();
    for range in &container.access_units {
        let unit = access_unit::read(bytes, range.clone())?;
        let bad = |what: String| StreamError::malformed(format!("byte {}", range.start), what);
        if unit.plane.rate.hz() != rate.hz() {
            return Err(bad("another frame rate than that of the head".into()));
        }
        let count = frames.len() + unit.plane.frames;
        let at = format!("byte {}", range.start);
        let elements = (count * FAP_COUNT) as u64;
        StreamLimits::check(&at, "elements", elements, limits.elements)?;
        let mut is_there = [false; FAP_COUNT];
        unit.faps.iter().for_each(|c| is_there[c.fap - 1] = true);
        for (coded, there) in coded.iter_mut().zip(is_there) {
            *coded |= there;
        }
        let roles = levels_of(&is_there).roles();
        fade.access_unit(&roles, &is_there);
        let first = frames.len();
        frames.resize(count, FaceFrame::NEUTRAL);
        for coded in &unit.faps {
            decode(coded, unit.plane.quantizer, &mut frames[first..]).map_err(bad)?;
        }
        for frame in &mut frames[first..] {
            roles.expand(&mut frame.low);
            fade.frame(&mut frame.low);
        }
    }
    let head = container.head;
    let clip = FaceClip {
        name: head.name,
        bridge: head.bridge,
        rate,
        frames,
    };
    Ok(DecodedFace { clip, coded })
}

/// Sets a parameter in some frames.
fn decode(coded: &CodedFap, quantizer: u8, frames: &mut [FaceFrame]) -> Result<(), String> {
    let step = access_unit::step(coded.fap, quantizer);
    for (field, block) in coded.blocks.iter().enumerate() {
        for (frame, value) in frames.iter_mut().zip(block.values(step)) {
            let value = value.round() as i32;
            let set = frame.set_field(coded.fap, field, value);
            set.ok_or_else(|| format!("a field of FAP {} is {value}", coded.fap))?;
        }
    }
    Ok(())
}

/// Returns the map of a file, by which [`crate::cut()`] removes parameters and access units.
///
/// The parameters of an access unit have the markers `loa` (0 very low to 3 high: the coarsest level
/// that keeps it), `region` (index in [`FaceRegion::ALL`](articula_core::face_levels::FaceRegion::ALL)) and `parameter`, access units
/// `access_unit`.
///
/// # Errors
/// As [`read`].
pub fn unit(bytes: &[u8], limits: &StreamLimits) -> Result<Unit, StreamError> {
    let (_, container) = head::open(bytes, limits)?;
    let units = container.access_units.iter();
    let parts = units.map(|range| Ok(parts(&access_unit::read(bytes, range.clone())?)));
    let parts = parts.collect::<Result<Vec<_>, StreamError>>()?;
    Ok(container.map("AFP-1", parts))
}

/// Returns the rate of a file and the number of frames of each access unit.
///
/// # Errors
/// As [`unit`].
pub(crate) fn frames_of(
    bytes: &[u8],
    limits: &StreamLimits,
) -> Result<(FrameRate, Vec<usize>), StreamError> {
    let (rate, container) = head::open(bytes, limits)?;
    let units = container.access_units.iter();
    let frames = units.map(|range| Ok(access_unit::read(bytes, range.clone())?.plane.frames));
    Ok((rate, frames.collect::<Result<_, StreamError>>()?))
}

/// Fields and parts of an access unit.
fn parts(unit: &AccessUnit) -> (Vec<Field>, Vec<Unit>) {
    let places = &unit.places;
    let part = |label: &'static str, bits: &Range<u64>| Unit {
        bits: bits.clone(),
        ..Unit::of_bytes(label, 0..0)
    };
    let of_fap = |label, fap: usize, bits| {
        let mut unit = part(label, bits);
        if let Some([loa, region]) = labels(fap) {
            unit = unit
                .marked("loa", u32::from(loa))
                .marked("region", u32::from(region));
        }
        unit.marked("parameter", fap as u32)
    };
    let mut children = vec![
        part("AFPPlane", &places.plane),
        part("MainHeader", &places.main),
    ];
    let masks = unit.faps.iter().zip(&places.masks);
    children.extend(masks.map(|(coded, bits)| of_fap("FapMask", coded.fap, bits)));
    children.push(part("FapCodingType", &places.coding));
    let values = unit.faps.iter().zip(&places.values);
    children.extend(values.map(|(coded, bits)| of_fap("FapValue", coded.fap, bits)));
    children.push(Unit {
        padding: true,
        ..part("Padding", &places.padding)
    });
    children.push(part("AFPPlaneEnd", &places.end));
    let count = Field {
        name: "fap_count".into(),
        bits: places.fap_count.clone(),
        value: unit.faps.len() as u64,
        coding: Coding::BigEndian,
        meaning: Meaning::CountOf("FapMask".into()),
    };
    (vec![count], children)
}
