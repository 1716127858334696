//! Contact sheets of a character at several distances and frames, next to the reference, with marks
//! on its joints.
//!
//! Source: thesis figures 6.16 and 6.17. The first row shows the original clip, each further one the
//! result of a method, drawn large; the small figure in the corner has the size on the screen. Below
//! each is its error in pixels at that size.

use crate::artist::{Artist, evenly_spaced_frames};
use crate::contact_sheet::{ContactSheet, SheetCell, SheetRow, SheetTile};
use crate::skeleton::JointMark;
use articula::build::Asset;
use articula::build::evaluate::{ClipEvaluator, Method, PathFrame, PathRun, Playback, play};
use articula::core::joint_state::JointState;
use articula::core::{LocalPose, Wrap, sample, sample_morphs};
use articula::flat::{Picture, PictureError};

/// A method with its parameter and distance: a row of a sheet, a line of a plot.
#[derive(Debug, Clone)]
pub struct MotionLine<'a> {
    /// Label of the row or line.
    pub label: String,
    /// The method.
    pub method: &'a Method,
    /// Parameter of the method.
    pub parameter: f32,
    /// Distance from the camera to the root, metres.
    pub distance_m: f32,
}

/// Draws a clip and, below it, the result of each method, one row per method, at a number of frames.
///
/// # Errors
/// [`PictureError`] if the page is too large.
pub fn motion_sheet(
    stage: &ClipEvaluator<'_>,
    artist: &mut Artist<'_>,
    lines: &[MotionLine<'_>],
    frames: usize,
    title: &str,
    notes: Vec<String>,
) -> Result<Picture, PictureError> {
    let frames = evenly_spaced_frames(stage.truth.len(), frames);
    let poses: Vec<_> = frames
        .iter()
        .map(|f| (&stage.truth[*f], morphs(stage, *f)))
        .collect();
    artist.frame_poses(&poses);
    let references = frames.iter().map(|f| {
        let picture = artist.reference(&stage.truth[*f], morphs(stage, *f))?;
        Ok(SheetCell::of(picture, ""))
    });
    let mut rows = vec![SheetRow {
        label: "reference".into(),
        cells: references.collect::<Result<_, PictureError>>()?,
    }];
    for line in lines {
        let playbacks = play(stage, line.method, line.parameter).1;
        let Some(playback) = playbacks.first() else {
            continue;
        };
        let scale = stage.setup.viewport.pixels_per_metre(line.distance_m);
        let mut cells = Vec::new();
        for frame in &frames {
            let shown = shown_pose(stage, playback, *frame);
            let weights = morphs(stage, *frame);
            let error_px = scale * artist.displacement_m((&stage.truth[*frame], &shown), &weights);
            let marks = marks(stage, line, playback, *frame);
            let reduced = artist.articulated(&shown, weights, &marks, scale)?;
            cells.push(SheetCell::of(
                reduced,
                caption(stage, playback, *frame, error_px),
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

/// Draws frames of a run in front of a moving camera, each from the camera's position at that time.
///
/// # Errors
/// [`PictureError`] if the page is too large.
pub fn camera_path_sheet(
    stage: &ClipEvaluator<'_>,
    artist: &mut Artist<'_>,
    run: &PathRun,
    title: &str,
    notes: Vec<String>,
) -> Result<Picture, PictureError> {
    const IN_A_ROW: usize = 4;
    let rig = &stage.asset.rig;
    let mut cells = Vec::new();
    for at in evenly_spaced_frames(run.frames.len(), 3 * IN_A_ROW) {
        let frame = &run.frames[at];
        let mut truth = rig.rest_pose().clone();
        sample(&stage.clip, frame.secs, Wrap::Loop, &rig.all(), &mut truth);
        let morphs = stage.asset.mesh.morph_weights.clone();
        artist.eye = Some(frame.camera.eye);
        let reference = artist.reference(&truth, morphs.clone())?;
        let marks = path_marks(rig.root(), frame);
        let scale = stage.setup.viewport.pixels_per_metre(frame.distance_m);
        let shown = artist.articulated(&frame.shown, morphs, &marks, scale)?;
        let mut cell = cell(reference, shown, format!("{:.2} px", frame.error_px));
        cell.tiles[0].caption = format!("{:.2} s, {:.1} m", frame.secs, frame.distance_m);
        cells.push(cell);
    }
    let row = |cells: &[SheetCell]| SheetRow {
        label: String::new(),
        cells: cells.to_vec(),
    };
    let rows = cells.chunks(IN_A_ROW).map(row).collect();
    sheet(title, notes, Vec::new(), rows)
}

/// Draws the rest pose of a character without a clip, from four sides.
///
/// # Errors
/// [`PictureError`] if the page is too large.
pub fn rest_sheet(
    asset: &Asset,
    artist: &mut Artist<'_>,
    title: &str,
) -> Result<Picture, PictureError> {
    let rest = asset.rig.rest_pose();
    let marks = vec![JointMark::Passive; asset.rig.len()];
    let morphs = &asset.mesh.morph_weights;
    let mut cells = Vec::new();
    for turn in 0..4 {
        artist.azimuth = turn as f32 * std::f32::consts::FRAC_PI_2;
        artist.frame_pose(rest, morphs);
        let figure = artist.reference(rest, morphs.clone())?;
        let joints = artist.articulated(rest, morphs.clone(), &marks, 0.0)?;
        cells.push(cell(figure, joints, "joints at rest".into()));
    }
    let row = SheetRow {
        label: String::new(),
        cells,
    };
    let columns = ["front", "left", "back", "right"].map(String::from);
    let notes = vec!["The file has no clip: this is the rest pose, and nothing moves.".into()];
    sheet(title, notes, columns.to_vec(), vec![row])
}

fn sheet(
    title: &str,
    notes: Vec<String>,
    columns: Vec<String>,
    rows: Vec<SheetRow>,
) -> Result<Picture, PictureError> {
    let sheet = ContactSheet {
        title: title.to_owned(),
        notes,
        columns,
        rows,
        explains_joints: true,
    };
    sheet.draw()
}

fn cell(reference: Picture, reduced: Picture, caption: String) -> SheetCell {
    let tile = |picture, caption| SheetTile { picture, caption };
    SheetCell {
        tiles: vec![tile(reference, "reference".into()), tile(reduced, caption)],
    }
}

fn caption(stage: &ClipEvaluator<'_>, playback: &Playback, frame: usize, error_px: f32) -> String {
    let updated = playback.updated[frame].len();
    format!("{error_px:.2} px, {updated}/{} updated", stage.moving.len())
}

fn shown_pose(stage: &ClipEvaluator<'_>, playback: &Playback, frame: usize) -> LocalPose {
    let mut pose = stage.truth[frame].clone();
    pose.rotations.copy_from_slice(&playback.shown[frame]);
    pose
}

/// Morph weights at a frame of the evaluated clip.
fn morphs(stage: &ClipEvaluator<'_>, frame: usize) -> Vec<f32> {
    let mut weights = stage.asset.mesh.morph_weights.clone();
    let secs = frame as f64 / f64::from(stage.clip.rate_hz());
    sample_morphs(&stage.clip, secs, Wrap::Clamp, &mut weights);
    weights
}

/// Mark of each joint at a frame; the root follows the clip except outside of a fixed level.
fn marks(
    stage: &ClipEvaluator<'_>,
    line: &MotionLine<'_>,
    playback: &Playback,
    frame: usize,
) -> Vec<JointMark> {
    let rig = &stage.asset.rig;
    let level = match line.method {
        Method::Loa(levels) => levels.get(line.parameter as usize),
        _ => None,
    };
    let mark = |joint: usize| {
        let allowed = level.map_or(joint == rig.root(), |l| l.contains(joint));
        if playback.in_transition[frame].contains(joint) {
            JointMark::InTransition
        } else if allowed || playback.updated[frame].contains(joint) {
            JointMark::Active
        } else {
            JointMark::Passive
        }
    };
    (0..rig.len()).map(mark).collect()
}

/// Mark of each joint at a frame of a run with a moving camera.
fn path_marks(root: usize, frame: &PathFrame) -> Vec<JointMark> {
    let mark = |(joint, state): (usize, &JointState)| match state {
        JointState::ToActive | JointState::ToPassive => JointMark::InTransition,
        JointState::Passive if joint != root && !frame.updated.contains(joint) => {
            JointMark::Passive
        }
        _ => JointMark::Active,
    };
    frame.states.iter().enumerate().map(mark).collect()
}
