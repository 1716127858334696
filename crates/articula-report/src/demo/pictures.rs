//! The pictures of the demo.

use super::report::MIDDLE;
use crate::artist::Artist;
use crate::contact_sheet::{ContactSheet, SheetCell, SheetRow};
use crate::method_lines::{lines_by_distance, lines_by_method};
use crate::motion_sheet::{MotionLine, motion_sheet};
use articula::build::evaluate::Method;
use articula::core::Region;
use articula::evaluate::{EvaluatedClip, MethodTable};
use articula::flat::{Picture, PictureError};
use std::f32::consts::FRAC_PI_2;

/// A function that draws one picture of the results.
pub(super) type Draw = fn(&EvaluatedClip<'_>, &[MethodTable]) -> Result<Picture, PictureError>;

/// The character at rest: from three sides, its face and a hand.
pub(super) fn character(
    scene: &EvaluatedClip<'_>,
    _: &[MethodTable],
) -> Result<Picture, PictureError> {
    let rest = scene.figure.asset.rig.rest_pose();
    let morphs = scene.figure.asset.mesh.morph_weights.clone();
    let mut artist = Artist::of_figure(scene.figure, (196, 300));
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
    sheet.draw()
}

/// `skin-px` at every distance.
pub(super) fn distances(
    scene: &EvaluatedClip<'_>,
    tables: &[MethodTable],
) -> Result<Picture, PictureError> {
    let lines = tables.first().map(lines_by_distance).unwrap_or_default();
    small_sheet(scene, &lines, "Our metric (hold) at every distance")
}

/// Every method at one distance.
pub(super) fn methods(
    scene: &EvaluatedClip<'_>,
    tables: &[MethodTable],
) -> Result<Picture, PictureError> {
    let lines = lines_by_method(tables, MIDDLE);
    small_sheet(scene, &lines, "Every method at one distance")
}

/// The levels of articulation, regardless of their error.
pub(super) fn levels(
    scene: &EvaluatedClip<'_>,
    tables: &[MethodTable],
) -> Result<Picture, PictureError> {
    let mut tables = tables.iter();
    let table = tables.find(|t| matches!(t.method.method, Method::Loa(_)));
    let table = table.and_then(|table| Some((table, table.rows.get(MIDDLE)?)));
    let lines = table.map_or_else(Vec::new, |(table, row)| {
        let line = |(i, level): (usize, &String)| {
            let label = level.trim_start_matches("loa(").trim_end_matches(')');
            MotionLine {
                label: label.to_owned(),
                method: &table.method.method,
                parameter: i as f32,
                distance_m: row.distance_m,
            }
        };
        table.method.levels.iter().enumerate().map(line).collect()
    });
    small_sheet(scene, &lines, "Levels of articulation")
}

/// A contact sheet of three frames at the size of a page.
fn small_sheet(
    scene: &EvaluatedClip<'_>,
    lines: &[MotionLine<'_>],
    title: &str,
) -> Result<Picture, PictureError> {
    let mut artist = Artist::of_figure(scene.figure, (144, 206));
    motion_sheet(&scene.stage(), &mut artist, lines, 3, title, Vec::new())
}
