//! `lod --schedule`: a clip whose level of articulation changes over time.

use super::report::LodReport;
use super::{LodArgs, write_plot_files};
use crate::console::Console;
use crate::files;
use anyhow::Context;
use articula::evaluate::{EvaluatedClip, ScheduleOptions, play_lod_schedule, read_lod_schedule};
use articula::formats::Limits;
use articula_report::schedule_plots;
use std::path::Path;

/// Plays the schedule and prints the report.
pub(super) fn run(
    args: &LodArgs,
    scene: &EvaluatedClip<'_>,
    path: &Path,
    console: &Console,
) -> anyhow::Result<()> {
    let bytes = files::read(path, Limits::default().bytes)?;
    let entries = read_lod_schedule(&bytes).with_context(|| files::shown(path))?;
    let options = ScheduleOptions {
        finest_level: args.finest_level,
        display_hz: f64::from(args.display_hz),
        distance_m: args.distances()[0],
        transition: args.method.live_transition(),
    };
    let bar = console.progress("changing the level", 1);
    let played = play_lod_schedule(&scene.stage(), &entries, &options);
    let played = played.with_context(|| files::shown(path))?;
    bar.finish_and_clear();
    let mut report = LodReport::new(scene, args, &[]);
    report.method = "loa".into();
    if let Some(target) = &args.plot {
        let clip = &scene.figure.asset.clips[scene.clip].name;
        let heading = format!("clip {clip}, {} m", options.distance_m);
        let plots = schedule_plots(&played, &heading);
        report
            .written
            .extend(write_plot_files(&plots, target, &console.files)?);
    }
    report.schedule = Some(played);
    console.result(&report, LodReport::text)
}
