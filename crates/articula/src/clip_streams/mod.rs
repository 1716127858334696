//! Animations as streams that can be cut: conversion of the clips of characters and faces.
//!
//! - [`StreamKind`]: which stream some bytes are
//! - [`abp1`]: the motion of a character as ABP-1, and back
//! - [`abp2`]: the motion of a character as ABP-2, and back
//! - [`afp1`]: facial animation parameters as AFP-1, and back
//! - [`afp2`]: facial animation parameters as AFP-2, and back
//! - [`fba`]: facial animation parameters as MPEG-4's binary stream, and back
//! - [`mp4`]: these streams in MP4 files
//! - [`AccessUnitCount`]: how much of a stream is there
//! - [`unit_tree()`]: the map of any of them and of mesh levels, by how the bytes begin
//!
//! The streams themselves, and the map by which they are cut, are those of `articula_stream`.

pub mod abp1;
pub mod abp2;
mod access_units;
pub mod afp1;
pub mod afp2;
mod face_clip;
mod face_frame;
pub mod fba;
pub mod mp4;
pub(crate) mod rig_hash;
mod unit_tree;

pub use access_units::AccessUnitCount;
pub use unit_tree::unit_tree;

use crate::error::Result;
use articula_core::Region;
use articula_core::face_levels::FaceRegion;
use articula_formats::Limits;
use articula_stream::StreamLimits;
use articula_stream::abp2::MotionHead;

pub use articula_stream::StreamKind;

/// Returns the name of the clip of a stream; empty for FBA, which holds none.
///
/// # Errors
/// An [`Error`](crate::Error) that names the position in the stream.
pub fn clip_name(stream: &[u8], limits: &Limits) -> Result<String> {
    let limits = stream_limits(limits);
    Ok(match StreamKind::of(stream) {
        Some(StreamKind::Abp1) => {
            let absent = articula_stream::abp1::AbsentBone::Rest;
            articula_stream::abp1::read(stream, absent, &limits)?.name
        }
        Some(StreamKind::Afp1) => {
            let options = articula_stream::FaceReadOptions::default();
            articula_stream::afp1::read(stream, &options, &limits)?
                .clip
                .name
        }
        Some(StreamKind::Abp2 | StreamKind::Afp2) => MotionHead::open(stream, &limits)?.name,
        Some(StreamKind::Fba) | None => String::new(),
    })
}

/// The limits of streams that correspond to those of files.
pub(crate) fn stream_limits(limits: &Limits) -> StreamLimits {
    StreamLimits {
        bytes: limits.bytes,
        elements: limits.elements,
    }
}

/// Name of a region by its number in a stream, if it has one.
pub(crate) fn region_name(is_face: bool, number: impl Into<u32>) -> String {
    let number = number.into() as usize;
    let name = if is_face {
        FaceRegion::ALL.get(number).map(ToString::to_string)
    } else {
        let region = number.checked_sub(1).and_then(|n| Region::ALL.get(n));
        region.map(ToString::to_string)
    };
    name.unwrap_or_else(|| number.to_string())
}
