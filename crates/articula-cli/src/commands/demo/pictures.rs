//! The pictures of the demo.

use super::MIDDLE;
use crate::play::drawn::{self, artist};
use anyhow::Context;
use articula::build::evaluate::Method;
use articula::core::Region;
use articula::evaluate::{EvaluatedClip, MethodTable};
use articula::flat::Picture;
use articula_report::{ContactSheet, MotionLine, SheetCell, SheetRow};
use std::f32::consts::FRAC_PI_2;

/// A function that draws one picture of the results.
pub(super) type Draw = fn(&EvaluatedClip<'_>, &[MethodTable]) -> anyhow::Result<Picture>;

/// The character at rest: from three sides, its face and a hand.
pub(super) fn character(scene: &EvaluatedClip<'_>, _: &[MethodTable]) -> anyhow::Result<Picture> {
    let rest = scene.figure.asset.rig.rest_pose();
    let morphs = scene.figure.asset.mesh.morph_weights.clone();
    let mut artist = artist(scene.figure, (196, 300));
    let mut tiles = Vec::new();
    for (caption, azimuth) in [
        ("front", 0.0),
        ("side", FRAC_PI_2),
        ("back", 2.0 * FRAC_PI_2),
    ] {
        artist.azimuth = azimuth;
        tiles.push((caption, artist.figure(rest, morphs.clone())?));
    }
    for (caption, region, azimuth) in [("face", Region::Face, 0.4), ("hand", Region::Hands, 1.2)] {
        artist.azimuth = azimuth;
        artist.frame_region(rest, region);
        tiles.push((caption, artist.figure(rest, morphs.clone())?));
    }
    let cell = |(caption, picture): (&str, Picture)| SheetCell::of(picture, caption);
    let sheet = ContactSheet {
        title: "The character at rest".into(),
        rows: vec![SheetRow {
            label: String::new(),
            cells: tiles.into_iter().map(cell).collect(),
        }],
        ..ContactSheet::default()
    };
    sheet.draw().context("the picture of the character")
}

/// `skin-px` at every distance.
pub(super) fn distances(
    scene: &EvaluatedClip<'_>,
    tables: &[MethodTable],
) -> anyhow::Result<Picture> {
    let table = tables.first().context("no method was played")?;
    let lines = drawn::lines_by_distance(table);
    let title = "Our metric (hold) at every distance";
    Ok(drawn::small_sheet(scene, &lines, title)?)
}

/// Every method at one distance.
pub(super) fn methods(
    scene: &EvaluatedClip<'_>,
    tables: &[MethodTable],
) -> anyhow::Result<Picture> {
    let lines = drawn::lines_by_method(tables, MIDDLE);
    let title = "Every method at one distance";
    Ok(drawn::small_sheet(scene, &lines, title)?)
}

/// The levels of articulation, regardless of their error.
pub(super) fn levels(scene: &EvaluatedClip<'_>, tables: &[MethodTable]) -> anyhow::Result<Picture> {
    let table = tables
        .iter()
        .find(|t| matches!(t.method.method, Method::Loa(_)))
        .context("no level of articulation was played")?;
    let row = table.rows.get(MIDDLE).context("no distance was played")?;
    let line = |(i, level): (usize, &String)| {
        let label = level.trim_start_matches("loa(").trim_end_matches(')');
        MotionLine {
            label: label.to_owned(),
            method: &table.method.method,
            parameter: i as f32,
            distance_m: row.distance_m,
        }
    };
    let lines: Vec<_> = table.method.levels.iter().enumerate().map(line).collect();
    Ok(drawn::small_sheet(scene, &lines, "Levels of articulation")?)
}
