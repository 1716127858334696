//! Levels of articulation of faces: parameters, errors and time (docs/methods/face-levels.md).

use super::Run;
use super::fap_clips::{CLIPS, read};
use crate::measure::{Contestant, race};
use anyhow::Result;
use articula::face::{FaceDetailOptions, FaceDetailReport, MeasuredFace, face_detail};
use articula::{Executor, Figure};
use articula_build::face::FapValues;
use articula_core::face_levels::{FaceLevel, FaceLevels};
use glam::Vec3;
use std::fmt::Write as _;

/// Name and file of each head.
const HEADS: [(&str, &str); 2] = [
    ("ICT", "face/ict_facekit_expressions.glb"),
    ("MakeHuman", "glb/mh_female_default163_arkit52.glb"),
];

/// Rounds of the timings.
const ROUNDS: usize = 9;

/// Writes the page and its CSV file.
pub(crate) fn write(run: &Run) -> Result<()> {
    let mut page = HEAD.to_owned();
    let mut csv = String::from("head,clip,distance_m,choice,parameters,error_px\n");
    let mut times = String::new();
    let clips = &CLIPS[..if run.small { 1 } else { CLIPS.len() }];
    for (head, file) in HEADS {
        let opened = articula::fs::open(run.data.join(file))?;
        let figure = Figure::new(opened)?;
        for name in clips {
            let clip = read(run, name)?;
            let options = FaceDetailOptions::default();
            let report = face_detail(&clip, name, &figure, &options, &Executor::default())?;
            rows(&mut page, &mut csv, (head, name), &report)?;
            let ns = time(&MeasuredFace::new(&clip, name, &figure)?);
            write!(times, "| {head} | {name} | {:.1} |", 1e-3 * ns[0])?;
            for level in &ns[1..] {
                write!(times, " {:.1} |", 100.0 * level / ns[0])?;
            }
            times.push('\n');
        }
    }
    page.push_str(TIMES);
    page.push_str(&times);
    run.save("face-levels", &page, &csv)
}

/// One row for each distance, and one line of CSV for each choice.
fn rows(
    page: &mut String,
    csv: &mut String,
    (head, clip): (&str, &str),
    report: &FaceDetailReport,
) -> Result<()> {
    let moving = report.levels[0].parameters;
    for row in &report.rows {
        let distance = row.distance_m;
        write!(page, "| {head} | {clip} | {moving} | {distance} |")?;
        let fixed = report.levels.iter().zip(&row.levels_px);
        let fixed = fixed.map(|(level, px)| (level.level, level.parameters, *px));
        let regions = ("regions", row.regions_parameters, row.regions_px);
        let chosen = ("chosen", row.chosen.len(), row.chosen_px);
        for (choice, parameters, px) in fixed.chain([regions, chosen]) {
            writeln!(
                csv,
                "{head},{clip},{distance},{choice},{parameters},{px:.4}"
            )?;
            if choice != FaceLevel::High.name() {
                write!(page, " {parameters}: {px:.2} |")?;
            }
        }
        page.push('\n');
    }
    Ok(())
}

/// Nanoseconds per frame of each level: the weights of the frame, and the displacement of every
/// vertex under them.
fn time(face: &MeasuredFace) -> Vec<f64> {
    let levels = FaceLevel::ALL.map(|level| frames(face, level));
    let numbers: Vec<f32> = (0..levels[0].len()).map(|frame| frame as f32).collect();
    let mut contestants: Vec<Contestant<'_>> = Vec::new();
    for (level, values) in FaceLevel::ALL.into_iter().zip(&levels) {
        let mut solver = face.bridge().solver(face.frames().counted());
        let mut moved = vec![Vec3::ZERO; face.fields().vertices()];
        contestants.push(Contestant {
            name: level.name().to_owned(),
            frame: Box::new(move |numbers| {
                for number in numbers {
                    let weights = solver.solve(&values[*number as usize]).weights;
                    moved.fill(Vec3::ZERO);
                    face.fields().add_weighted(&weights, &mut moved);
                }
            }),
        });
    }
    let timings = race(&mut contestants, &[numbers], ROUNDS);
    timings.iter().map(|t| t.median_ns).collect()
}

/// The values of all frames at a level.
fn frames(face: &MeasuredFace, level: FaceLevel) -> Vec<FapValues> {
    let roles = FaceLevels::all(level).roles();
    let mut frames = face.frames().clone();
    for frame in &mut frames.low {
        roles.expand(&mut frame.0);
    }
    (0..frames.low.len()).map(|f| frames.values(f)).collect()
}

const HEAD: &str = "# Levels of articulation of faces

Made by `cargo run --release -p articula-lab -- face-levels`. FAP clips on two heads with morph targets
([method](../methods/face-levels.md)): *parameters: pixels*, with the parameters that move in the clip and
are kept, and the greatest error over all frames and all vertices, as a distance in 3D, at 720 pixels and 45
degrees. *Regions*: the coarsest level of each region within 1 px. *Chosen*: parameters chosen one by one
within 1 px. *Moving*: parameters that move in the clip, all of which level high keeps with error 0.

| head | clip | moving | distance, m | medium | low | very low | regions | chosen |
| --- | --- | --- | --- | --- | --- | --- | --- | --- |
";

const TIMES: &str = "
## Time per frame

Solving the weights of a frame and displacing the vertices by them, in the processor time of one thread,
without skinning and drawing; the other levels in percent of high. The thesis (6.1) gives 86.6, 75.2 and
68.2 % for medium, low and very low on its own clips and calls them a gain; they are read here as the time
that remains, as its sizes in the table before are. In the thesis a parameter that is not sent is not
evaluated; here all parameters, copied ones too, go into one solution of the weights, so that only parameters
that are neutral make a frame cheaper.

| head | clip | high, us | medium, % | low, % | very low, % |
| --- | --- | --- | --- | --- | --- |
";
