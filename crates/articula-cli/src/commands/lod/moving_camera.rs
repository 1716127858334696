//! `lod --camera-path`: a controller of the live playback before a moving camera.

use super::report::LodReport;
use super::{LodArgs, TILE_PX, write_plot_files};
use crate::console::Console;
use crate::play::read_camera_path;
use crate::{fault, files};
use anyhow::Context;
use articula::evaluate::{CameraPath, EvaluatedClip};
use articula_report::{Artist, camera_path_sheet, path_plots};
use std::path::Path;

/// Plays the clip along the path and prints the report.
pub(super) fn run(
    args: &LodArgs,
    scene: &EvaluatedClip<'_>,
    path: &Path,
    console: &Console,
) -> anyhow::Result<()> {
    let display_hz = f64::from(args.display_hz);
    let keys = read_camera_path(path, display_hz)?;
    let rig = &scene.figure.asset.rig;
    let (method, level) = args.method.before_a_camera(rig, args.parameter)?;
    if args.calibrate.is_some() && method.tolerance_px().is_none() {
        let what = "--calibrate with --camera-path searches a tolerance in pixels; give --parameter to thesis and loa";
        return Err(fault::usage(what));
    }
    let path = CameraPath {
        keys,
        display_hz,
        method,
        level,
    };
    let stage = scene.stage();
    let bar = console.progress("moving the camera", 1);
    let place = || scene.figure.opened.name().to_owned();
    let played = path.play(&stage, args.calibrate).with_context(place)?;
    bar.finish_and_clear();
    let mut report = LodReport::new(scene, args, &[]);
    report.rows.push(played.row);
    report
        .written
        .extend(args.save_selection(scene.figure, console)?);
    if let Some(target) = &args.plot {
        let clip = &scene.figure.asset.clips[scene.clip].name;
        let plots = path_plots(
            &played.run,
            played.summary.bound_px,
            &format!("clip {clip}"),
        );
        report
            .written
            .extend(write_plot_files(&plots, target, &console.files)?);
    }
    if let Some(target) = &args.contact_sheet {
        let notes = vec![
            "Seen from the camera's position, zoomed to the figure. Error: p95 over the skin."
                .into(),
        ];
        let mut artist = Artist::of_figure(scene.figure, TILE_PX);
        let heading = report.heading();
        let picture = camera_path_sheet(&stage, &mut artist, &played.run, &heading, notes);
        let picture = picture.context("the contact sheet")?;
        report
            .written
            .push(files::write_png(&console.files, target, &picture)?);
    }
    report.camera_path = Some(played.summary);
    console.result(&report, LodReport::text)
}
