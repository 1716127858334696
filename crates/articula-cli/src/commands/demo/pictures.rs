//! The pictures of the demo.

use super::MIDDLE;
use crate::play::Scene;
use crate::play::artist::artist;
use crate::play::rows::Table;
use crate::play::sheet::{self, Format, Line};
use anyhow::Context;
use articula_build::evaluate::Method;
use articula_core::Region;
use articula_flat::Picture;
use articula_report::{Cell, ContactSheet, Row as SheetRow};
use std::f32::consts::FRAC_PI_2;

/// Draws one picture of what was played.
pub(super) type Draw = fn(&Scene<'_>, &[Table]) -> anyhow::Result<Picture>;

/// The character at rest: from three sides, the face and a hand.
pub(super) fn character(scene: &Scene<'_>, _: &[Table]) -> anyhow::Result<Picture> {
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
    let cell = |(caption, picture): (&str, Picture)| Cell::of(picture, caption);
    let sheet = ContactSheet {
        title: "The reference human at rest".into(),
        rows: vec![SheetRow {
            label: String::new(),
            cells: tiles.into_iter().map(cell).collect(),
        }],
        ..ContactSheet::default()
    };
    sheet.draw().context("the picture of the character")
}

/// Our metric at every distance.
pub(super) fn distances(scene: &Scene<'_>, tables: &[Table]) -> anyhow::Result<Picture> {
    let table = tables.first().context("no method was played")?;
    let lines = sheet::lines_by_distance(table);
    sheet::played(
        scene,
        &lines,
        Format::SMALL,
        "Our metric (hold) at every distance",
        Vec::new(),
    )
}

/// Every method at one distance.
pub(super) fn methods(scene: &Scene<'_>, tables: &[Table]) -> anyhow::Result<Picture> {
    let lines = sheet::lines_by_method(tables, MIDDLE);
    sheet::played(
        scene,
        &lines,
        Format::SMALL,
        "Every method at one distance",
        Vec::new(),
    )
}

/// The levels of articulation, whatever their error.
pub(super) fn levels(scene: &Scene<'_>, tables: &[Table]) -> anyhow::Result<Picture> {
    let ladder = tables
        .iter()
        .find(|t| matches!(t.chosen.method, Method::Loa(_)))
        .context("no level of articulation was played")?;
    let row = ladder.rows.get(MIDDLE).context("no distance was played")?;
    let lines = ladder
        .chosen
        .levels
        .iter()
        .enumerate()
        .map(|(i, level)| Line {
            label: level
                .trim_start_matches("loa(")
                .trim_end_matches(')')
                .to_owned(),
            chosen: &ladder.chosen,
            parameter: i as f32,
            distance_m: row.distance_m,
        });
    let lines: Vec<Line<'_>> = lines.collect();
    sheet::played(
        scene,
        &lines,
        Format::SMALL,
        "Levels of articulation",
        Vec::new(),
    )
}
