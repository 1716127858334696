//! Animations as streams that can be cut: conversion of the clips of characters and faces.
//!
//! - [`sniff`]: which stream some bytes are
//! - [`abp1`]: the motion of a character as ABP-1, and back
//! - [`abp2`]: the motion of a character as ABP-2, and back
//! - [`afp1`]: facial animation parameters as AFP-1, and back
//! - [`afp2`]: facial animation parameters as AFP-2, and back
//! - [`fba`]: facial animation parameters as MPEG-4's binary stream, and back
//! - [`layers()`]: the error of leaving out parts of a motion stream
//!
//! The streams themselves, and the map by which they are cut, are those of `articula_stream`.

pub mod abp1;
pub mod abp2;
pub mod afp1;
pub mod afp2;
mod face_clip;
mod face_frame;
pub mod fba;
mod layers;

pub use layers::{LayerOptions, LayerReport, LayersReport, WorstVertex, layers};

use articula_core::Region;
use articula_core::face_levels::FaceRegion;
use articula_formats::Limits;
use articula_stream::StreamLimits;

/// A stream of an animation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StreamKind {
    /// Bones, BBA-style, profile ABP-1.
    Abp1,
    /// A motion within a tolerance of the skin, profile ABP-2.
    Abp2,
    /// Facial animation parameters, profile AFP-1.
    Afp1,
    /// Facial animation parameters within a tolerance, profile AFP-2.
    Afp2,
}

/// Returns which stream some bytes are, by how they begin.
pub fn sniff(bytes: &[u8]) -> Option<StreamKind> {
    match bytes.first_chunk()? {
        b"ABPF" => Some(StreamKind::Abp1),
        b"ABP2" => Some(StreamKind::Abp2),
        b"AFPF" => Some(StreamKind::Afp1),
        b"AFP2" => Some(StreamKind::Afp2),
        _ => None,
    }
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
