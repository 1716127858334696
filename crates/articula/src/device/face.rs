//! The content of faces: a head that moves by facial animation parameters.

use super::rest::at_rest;
use crate::error::{Error, Result};
use crate::face::{add_face_table, fit_face, reduce_face};
use crate::figure::Figure;
use articula_core::Libm;
use articula_core::face_levels::{FaceLevel, FaceLevels};
use articula_core::fap_table::{FAP_COUNT, LOW_FAPS};
use articula_flat::Bounds;
use articula_formats::mpeg4::fap::{FapClip, FapFrame};
use std::f32::consts::TAU;

/// Levels from the coarsest on: grades name them by their place.
const LEVELS: [FaceLevel; 4] = [
    FaceLevel::VeryLow,
    FaceLevel::Low,
    FaceLevel::Medium,
    FaceLevel::High,
];
const RATE_HZ: u32 = 25;
/// Frames of the clip.
const FRAMES: u32 = 50;
/// The greatest value of a parameter: no face is torn by it.
const MOST: f32 = 60.0;

/// A figure whose clips move its face, one for each level, and the bounds of its head.
pub(super) fn moving(figure: Figure) -> Result<(Figure, Bounds)> {
    let mut opened = figure.opened.clone();
    add_face_table(&mut opened, &[])?;
    let whole = every_parameter();
    let mut clips = Vec::with_capacity(LEVELS.len());
    for level in LEVELS {
        let clip = reduce_face(&whole, &FaceLevels::all(level).roles());
        clips.push(fit_face(&clip, level.name(), &opened)?.fitted);
    }
    opened.put_clips(clips, false);
    let figure = Figure::new(opened)?;
    let bounds =
        head(&figure).ok_or_else(|| Error::Unsupported("the figure has no head".to_owned()))?;
    Ok((figure, bounds))
}

/// A clip in which every parameter moves, each at a time of its own.
fn every_parameter() -> FapClip {
    let frame = |number: u32| {
        let mut frame = FapFrame {
            number,
            ..FapFrame::default()
        };
        for (i, value) in frame.low.iter_mut().enumerate() {
            let along = number as f32 / FRAMES as f32 + i as f32 / FAP_COUNT as f32;
            *value = (MOST * (TAU * along).libm_sin()).round() as i32;
        }
        frame
    };
    let mut coded = [true; FAP_COUNT];
    coded[..LOW_FAPS.start() - 1].fill(false);
    FapClip {
        name: "every parameter".to_owned(),
        rate_hz: RATE_HZ as f32,
        coded,
        frames: (0..=FRAMES).map(frame).collect(),
        bridge: None,
    }
}

/// Around the vertices that a parameter moves.
fn head(figure: &Figure) -> Option<Bounds> {
    let rest = at_rest(figure);
    let moved = figure.asset.mesh.morphs.iter().flat_map(|m| &m.vertices);
    Bounds::around(moved.map(|v| rest[*v as usize]).map(|p| (p, p)))
}
