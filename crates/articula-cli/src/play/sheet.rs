//! The character at several distances and frames, beside the reference: which joints move.
//!
//! Source: thesis figures 6.16 and 6.17. Each cell shows the clip as it is, and what the method
//! shows, drawn large; the small figure in the corner has the true size on the screen.

use super::Scene;
use super::artist::{artist, morphs};
use super::camera_path;
use super::methods::Chosen;
use super::rows::Table;
use anyhow::Context;
use articula::Figure;
use articula_build::evaluate::{Method, PathRun, Playback, Stage, play};
use articula_core::{LocalPose, Wrap, sample};
use articula_flat::Picture;
use articula_report::{Cell, ContactSheet, Row as SheetRow, Tile};
use articula_report::{JointMark, middles};

/// How large and how many the pictures of a sheet are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Format {
    /// Width and height of one tile, pixels.
    pub(crate) tile: (u32, u32),
    /// Moments of the clip.
    pub(crate) frames: usize,
}

impl Format {
    /// For a file of its own.
    pub(crate) const LARGE: Self = Self {
        tile: (200, 290),
        frames: 4,
    };
    /// For a page, where it is shown pixel for pixel.
    pub(crate) const SMALL: Self = Self {
        tile: (144, 206),
        frames: 3,
    };
}

/// One row of a sheet: a method with its parameter, at a distance.
pub(crate) struct Line<'a> {
    pub(crate) label: String,
    pub(crate) chosen: &'a Chosen,
    pub(crate) parameter: f32,
    pub(crate) distance_m: f32,
}

/// One line for each distance of a table.
pub(crate) fn lines_by_distance(table: &Table) -> Vec<Line<'_>> {
    let rows = table.rows.iter();
    rows.map(|row| Line {
        label: format!("{} m", row.distance_m),
        chosen: &table.chosen,
        parameter: row.parameter,
        distance_m: row.distance_m,
    })
    .collect()
}

/// One line for each method, all at one of the distances.
pub(crate) fn lines_by_method<'a>(tables: &'a [Table], distance: usize) -> Vec<Line<'a>> {
    let at = |table: &'a Table| {
        let row = table.rows.get(distance)?;
        Some(Line {
            label: table.chosen.label(),
            chosen: &table.chosen,
            parameter: row.parameter,
            distance_m: row.distance_m,
        })
    };
    tables.iter().filter_map(at).collect()
}

/// Draws the sheet of a played clip.
pub(crate) fn played(
    scene: &Scene<'_>,
    lines: &[Line<'_>],
    format: Format,
    title: &str,
    notes: Vec<String>,
) -> anyhow::Result<Picture> {
    let stage = scene.stage();
    let frames = middles(stage.truth.len(), format.frames);
    let mut artist = artist(scene.figure, format.tile);
    let poses: Vec<_> = frames
        .iter()
        .map(|f| (&stage.truth[*f], morphs(&stage, *f)))
        .collect();
    artist.frame_poses(&poses);
    let references: Vec<Picture> = frames
        .iter()
        .map(|f| Ok(artist.reference(&stage.truth[*f], morphs(&stage, *f))?))
        .collect::<anyhow::Result<_>>()?;
    let mut rows = Vec::new();
    for line in lines {
        let playbacks = play(&stage, &line.chosen.method, line.parameter).1;
        let Some(playback) = playbacks.first() else {
            continue;
        };
        let scale = scene.pixels_per_metre(line.distance_m);
        let mut cells = Vec::new();
        for (frame, reference) in frames.iter().zip(&references) {
            let shown = shown_pose(&stage, playback, *frame);
            let marks = marks(&stage, line.chosen, playback, line.parameter, *frame);
            let morphs = morphs(&stage, *frame);
            let reduced = artist.articulated(&shown, morphs, &marks, scale)?;
            cells.push(cell(
                reference.clone(),
                reduced,
                caption(&stage, playback, *frame),
            ));
        }
        rows.push(SheetRow {
            label: line.label.clone(),
            cells,
        });
    }
    let rate = stage.clip.rate_hz();
    let columns = frames.iter().map(|f| format!("{:.2} s", *f as f32 / rate));
    sheet(title, notes, columns.collect(), rows)
}

/// Draws moments of a run before a moving camera, each from where the camera stood.
pub(crate) fn along_a_path(
    scene: &Scene<'_>,
    run: &PathRun,
    title: &str,
    notes: Vec<String>,
) -> anyhow::Result<Picture> {
    const IN_A_ROW: usize = 4;
    let stage = scene.stage();
    let mut artist = artist(scene.figure, Format::LARGE.tile);
    let mut rows: Vec<SheetRow> = Vec::new();
    for (i, at) in middles(run.frames.len(), 3 * IN_A_ROW)
        .into_iter()
        .enumerate()
    {
        let frame = &run.frames[at];
        let mut truth = stage.asset.rig.rest_pose().clone();
        let all = stage.asset.rig.all();
        sample(&stage.clip, frame.secs, Wrap::Loop, &all, &mut truth);
        let morphs = stage.asset.mesh.morph_weights.clone();
        artist.eye = Some(frame.camera.eye);
        let reference = artist.reference(&truth, morphs.clone())?;
        let marks = camera_path::marks(scene, frame);
        let scale = scene.pixels_per_metre(frame.distance_m);
        let shown = artist.articulated(&frame.shown, morphs, &marks, scale)?;
        let caption = format!("{:.2} px", frame.error_px);
        let mut cell = cell(reference, shown, caption);
        cell.tiles[0].caption = format!("{:.2} s, {:.1} m", frame.secs, frame.distance_m);
        if i % IN_A_ROW == 0 {
            rows.push(SheetRow::default());
        }
        rows.last_mut()
            .context("a row was just added")?
            .cells
            .push(cell);
    }
    sheet(title, notes, Vec::new(), rows)
}

/// Draws a character that has no clip: its rest pose, seen from four sides.
pub(crate) fn at_rest(figure: &Figure, title: &str) -> anyhow::Result<Picture> {
    let rest = figure.asset.rig.rest_pose();
    let marks = vec![JointMark::Passive; figure.asset.rig.len()];
    let mut artist = artist(figure, Format::LARGE.tile);
    let morphs = figure.asset.mesh.morph_weights.clone();
    let mut cells = Vec::new();
    for turn in 0..4 {
        artist.azimuth = turn as f32 * std::f32::consts::FRAC_PI_2;
        artist.frame_pose(rest, &morphs);
        let figure = artist.reference(rest, morphs.clone())?;
        let joints = artist.articulated(rest, morphs.clone(), &marks, 0.0)?;
        cells.push(cell(figure, joints, "joints at rest".into()));
    }
    let row = SheetRow {
        label: String::new(),
        cells,
    };
    let columns = ["front", "left", "back", "right"]
        .map(String::from)
        .to_vec();
    let notes = vec!["The file has no clip: this is the rest pose, and nothing moves.".into()];
    sheet(title, notes, columns, vec![row])
}

fn sheet(
    title: &str,
    notes: Vec<String>,
    columns: Vec<String>,
    rows: Vec<SheetRow>,
) -> anyhow::Result<Picture> {
    let sheet = ContactSheet {
        title: title.to_owned(),
        notes,
        columns,
        rows,
        explains_joints: true,
    };
    sheet.draw().context("the contact sheet")
}

fn cell(reference: Picture, reduced: Picture, caption: String) -> Cell {
    let tile = |picture, caption| Tile { picture, caption };
    Cell {
        tiles: vec![tile(reference, "reference".into()), tile(reduced, caption)],
    }
}

fn caption(stage: &Stage<'_>, playback: &Playback, frame: usize) -> String {
    let updated = playback.updated[frame].len();
    format!("{updated} of {} updated", stage.moving.len())
}

fn shown_pose(stage: &Stage<'_>, playback: &Playback, frame: usize) -> LocalPose {
    let mut pose = stage.truth[frame].clone();
    pose.rotations.copy_from_slice(&playback.shown[frame]);
    pose
}

/// What each joint does at a frame: the root always follows the clip.
fn marks(
    stage: &Stage<'_>,
    chosen: &Chosen,
    playback: &Playback,
    parameter: f32,
    frame: usize,
) -> Vec<JointMark> {
    let rig = &stage.asset.rig;
    let level = match &chosen.method {
        Method::Loa(levels) => levels.get(parameter as usize),
        _ => None,
    };
    let mark = |joint: usize| {
        let allowed = level.is_some_and(|l| l.contains(joint));
        if playback.in_transition[frame].contains(joint) {
            JointMark::InTransition
        } else if allowed || joint == rig.root() || playback.updated[frame].contains(joint) {
            JointMark::Active
        } else {
            JointMark::Passive
        }
    };
    (0..rig.len()).map(mark).collect()
}
