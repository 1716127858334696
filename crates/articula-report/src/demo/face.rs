//! The face section of the demo: facial animation parameters on the character.

use super::files::DemoFiles;
use crate::face_pictures::clip_sheet;
use articula::convert::write;
use articula::core::fap_table::{FAP_COUNT, LOW_FAPS};
use articula::face::{
    FaceDetailOptions, FaceDetailReport, FaceKind, add_face_table, face_detail, face_layout,
    fit_face,
};
use articula::formats::mpeg4::fap::{FapClip, FapFrame};
use articula::{Executor, Figure, Format, Result};
use serde::Serialize;

const RATE_HZ: u32 = 25;
/// Frames from one expression to the next.
const STEP: u32 = 12;
/// Number of moments that are drawn.
const MOMENTS: usize = 14;

/// Expressions that follow each other: a smile, an open mouth, closed eyes, surprise, a frown, a kiss.
/// Values are of an average face.
const EXPRESSIONS: [&[(usize, i32)]; 6] = [
    &[
        (6, 160),
        (7, 160),
        (12, 180),
        (13, 180),
        (41, 120),
        (42, 120),
        (19, 120),
        (20, 120),
    ],
    &[(3, 500), (5, -380), (10, -330), (11, -330)],
    &[(19, 1024), (20, 1024)],
    &[
        (3, 300),
        (5, -250),
        (10, -220),
        (11, -220),
        (31, 220),
        (32, 220),
        (33, 220),
        (34, 220),
        (35, 180),
        (36, 180),
        (19, -250),
        (20, -250),
    ],
    &[
        (31, -140),
        (32, -140),
        (33, -100),
        (34, -100),
        (37, 120),
        (38, 120),
        (12, -120),
        (13, -120),
    ],
    &[(6, -180), (7, -180), (16, 160), (17, 160)],
];

/// What the demo shows of a face.
#[derive(Debug, Serialize)]
pub(super) struct Face {
    /// What moves it.
    pub(super) driven_by: &'static str,
    /// Number of parameters that move in the clip.
    pub(super) faps_moving: usize,
    /// Its levels of articulation over distance.
    pub(super) detail: FaceDetailReport,
}

/// Moves the face of a character, draws and measures it; `None` for one whose face nothing moves and
/// whose mouth is not found.
pub(super) fn of(
    files: &mut DemoFiles,
    figure: &Figure,
    work: &Executor<'_>,
) -> Result<Option<Face>> {
    let clip = expressions();
    let mut opened = figure.opened.clone();
    let mut made = fit_face(&clip, "expressions.fap", &opened);
    if made.is_err() {
        // The table of a face without a mouth would draw its skin apart.
        let layout = face_layout(figure, &[]).ok();
        let layout = layout.filter(|l| !l.units.iter().any(|u| u.doubtful));
        let mut points = layout.iter().flat_map(|l| &l.points);
        if !points.any(|p| p.point == (2, 4) && p.source == "geometry") {
            return Ok(None);
        }
        add_face_table(&mut opened, &[])?;
        made = fit_face(&clip, "expressions.fap", &opened);
    }
    let made = made?;
    let driven_by = match (
        made.report.kind,
        opened.character().meshes == figure.opened.character().meshes,
    ) {
        (_, false) => "a face animation table, which was made from the shape of the face",
        (FaceKind::MorphTargets, _) => "the morph targets of the face",
        (FaceKind::Expressions, _) => "the expressions of the face",
        (FaceKind::Joints, _) => "the joints of the face",
    };
    let faps_moving = made.report.faps_moving;
    opened.put_clips(vec![made.fitted], false);
    let figure = Figure::new(opened)?;
    files.add_png("face.png", &clip_sheet(&figure, 0, MOMENTS)?)?;
    let file = write(&figure.opened, Format::Glb)?;
    files.add("face.glb", file.bytes);
    let options = FaceDetailOptions::default();
    let detail = face_detail(&clip, "expressions.fap", &figure, &options, work)?;
    Ok(Some(Face {
        driven_by,
        faps_moving,
        detail,
    }))
}

/// A clip that goes through the expressions, and is neutral between them.
fn expressions() -> FapClip {
    let frames = 2 * STEP * EXPRESSIONS.len() as u32;
    let frame = |number: u32| {
        let mut frame = FapFrame {
            number,
            ..FapFrame::default()
        };
        let (index, along) = (number / (2 * STEP), number % (2 * STEP));
        let share = 0.5 - 0.5 * (std::f32::consts::TAU * along as f32 / (2 * STEP) as f32).cos();
        for (fap, value) in EXPRESSIONS.get(index as usize).copied().unwrap_or(&[]) {
            frame.low[fap - LOW_FAPS.start()] = (share * *value as f32).round() as i32;
        }
        frame
    };
    let mut clip = FapClip {
        name: "expressions".to_owned(),
        rate_hz: RATE_HZ as f32,
        coded: [false; FAP_COUNT],
        frames: (0..=frames).map(frame).collect(),
        bridge: None,
    };
    clip.coded = clip.moving();
    clip
}
