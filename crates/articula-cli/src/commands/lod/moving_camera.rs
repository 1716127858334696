//! `lod --camera-path`: the controller of a frame before a moving camera.

use super::report::Report;
use super::{LodArgs, write_png};
use crate::console::Console;
use crate::files;
use crate::play::camera_path::{self, CameraPath};
use crate::play::{Scene, sheet};
use anyhow::Context;
use articula_report::{Plot, stacked};
use std::path::Path;

/// Plays the clip along the path and prints the report.
pub(super) fn run(
    args: &LodArgs,
    scene: &Scene<'_>,
    path: &Path,
    console: &Console,
) -> anyhow::Result<()> {
    let display_hz = f64::from(args.display_hz);
    let path = CameraPath {
        keys: camera_path::read(path, display_hz)?,
        display_hz,
        options: args.method.drift(args.parameter.unwrap_or(1.0))?,
    };
    let stage = scene.stage();
    let bar = console.progress("moving the camera", 1);
    let place = || scene.figure.opened.name.clone();
    let (run, options) = camera_path::run(&stage, &path, args.calibrate).with_context(place)?;
    bar.finish_and_clear();
    let (row, found) = camera_path::report(&stage, &path, &run, &options, args.calibrate);
    let mut report = Report::new(scene, args, &[]);
    report.rows.push(row);
    report.camera_path = Some(found);
    if let Some(target) = &args.plot {
        let clip = &scene.figure.asset.clips[scene.clip].name;
        let plots = camera_path::plots(&run, options.bound_px(), &format!("clip {clip}"));
        report.written.extend(write(&plots, target)?);
    }
    if let Some(target) = &args.contact_sheet {
        let notes = vec!["From where the camera stood; the opening follows the figure. Error: p95 over the skin.".into()];
        let picture = sheet::along_a_path(scene, &run, &report.heading(), notes)?;
        report.written.push(write_png(&picture, target)?);
    }
    console.result(&report, Report::text)
}

fn write(plots: &[Plot], target: &Path) -> anyhow::Result<Vec<String>> {
    if target
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("svg"))
    {
        files::write(target, stacked(plots).as_bytes())?;
        return Ok(vec![files::shown(target)]);
    }
    let mut written = Vec::new();
    for plot in plots {
        let file = target.join(plot.name);
        files::write(&file, plot.svg.as_bytes())?;
        written.push(files::shown(&file));
    }
    Ok(written)
}
