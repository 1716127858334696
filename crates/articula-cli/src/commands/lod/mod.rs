//! `articula lod FILE`: plays a clip under motion level of detail; reports updates saved and error.

mod face;
mod moving_camera;
mod report;
mod schedule;
mod stream;
mod with_face;

use crate::arguments::{CharacterArgs, ViewArgs, file, not_negative, number, positive, settings};
use crate::console::Console;
use crate::fault;
use crate::files::{self, Files};
use crate::open;
use crate::play::methods::MethodArgs;
use anyhow::Context;
use articula::Figure;
use articula::build::evaluate::{EvaluationSetup, Method};
use articula::evaluate::{
    Costs, DISTANCES_M, EvaluatedClip, MethodTable, NamedMethod, ParameterChoice,
};
use articula::flat::Picture;
use articula_report::{
    Artist, Plot, cost_plots, error_plot, gain_plot, lines_by_distance, lines_by_method,
    motion_sheet, nanoseconds, rest_sheet, stacked, updates_plot,
};
use clap::Args;
use report::LodReport;
use std::path::{Path, PathBuf};

/// Width and height of a tile of a contact sheet, pixels.
const TILE_PX: (u32, u32) = (200, 290);

/// Maximum number of frames of a clip: the true poses of all frames are kept in memory.
const MAX_FRAMES: usize = 100_000;

/// Flags that a schedule of levels leaves no room for.
const SCHEDULE_ALONE: [&str; 6] = [
    "calibrate",
    "parameter",
    "method",
    "loa",
    "loa_profile",
    "contact_sheet",
];

/// Arguments of `lod`.
#[derive(Debug, Args)]
pub(crate) struct LodArgs {
    #[command(flatten)]
    character: CharacterArgs,
    /// Name of the clip to play [default: the first]
    #[arg(long, value_name = "NAME")]
    clip: Option<String>,
    #[command(flatten)]
    method: MethodArgs,
    /// With a FAP file, the head on which its levels of articulation are measured; with a motion
    /// stream (.abp), the character on which its tiers and groups are measured
    #[arg(long, value_name = "CHARACTER", conflicts_with_all = face::BODY_ALONE)]
    onto: Option<PathBuf>,
    /// Motion of the face beside the clip (.fap, .afp, .fba): as few parameters are kept at each distance as
    /// the error of the head by the method leaves room for, under --calibrate [default: 1]
    #[arg(long, value_name = "F.fap", conflicts_with_all = ["camera_path", "schedule"])]
    face: Option<PathBuf>,
    /// Write the selected joints as a LoA profile, loa-profile=F.json; or of a FAP file the clip with
    /// the parameters alone that the error at one distance asks for, fap=F.fap
    #[arg(long, value_name = "KEY=FILE,…", value_parser = written_files)]
    write: Option<WrittenFiles>,
    /// Distances from the camera to the root in metres, separated by commas
    /// [default: 3.5,5.65,9.05,16,25.6; of a FAP file 1,2,3.5,5.65,9.05]
    #[arg(long, value_name = "M,…", value_delimiter = ',', value_parser = distance,
          conflicts_with = "camera_path")]
    distances: Vec<f32>,
    /// Search the parameter that saves the most updates with a p95 error of at most this many
    /// pixels; of a FAP file, tolerated error of the chosen levels and parameters [default: 1]
    #[arg(long, value_name = "PX", value_parser = positive, conflicts_with = "parameter")]
    calibrate: Option<f32>,
    /// Parameter of the method: metres (skin-px, ahn), threshold (thesis), radians (pc), every n-th
    /// frame (skip-hold, skip-lerp), index of the level (loa), pixels (with --camera-path)
    #[arg(long, value_name = "P", value_parser = not_negative)]
    parameter: Option<f32>,
    /// Play before a moving camera: a JSON list of key frames with t, eye and target
    #[arg(long, value_name = "F.json", group = "moving")]
    camera_path: Option<PathBuf>,
    /// Play changes of the level of articulation over time: a JSON list with t and loa or level; at
    /// the first of --distances
    #[arg(long, value_name = "F.json", group = "moving", conflicts_with_all = SCHEDULE_ALONE)]
    schedule: Option<PathBuf>,
    /// Finest named level that the device allows, 0 (all joints) to 6 (none); play starts there
    /// (with --schedule)
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = named_level,
          requires = "schedule")]
    finest_level: usize,
    /// Refresh rate of the display in hertz (with --camera-path or --schedule)
    #[arg(long, value_name = "HZ", default_value_t = 60.0, value_parser = positive,
          requires = "moving")]
    display_hz: f32,
    /// Write plots: FILE.svg receives updates saved and error, a folder all plots
    /// [default without a value: lod-plots]
    #[arg(long, value_name = "FILE.svg|DIR", num_args = 0..=1, default_missing_value = "lod-plots")]
    plot: Option<PathBuf>,
    /// Write a contact sheet of frames at each distance, with held joints marked
    /// [default without a value: lod-sheet.png]
    #[arg(long, value_name = "FILE.png", num_args = 0..=1, default_missing_value = "lod-sheet.png")]
    contact_sheet: Option<PathBuf>,
    #[command(flatten)]
    view: ViewArgs,
    /// Seed for choosing the measured vertices
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Files that are written besides plots and sheets.
#[derive(Debug, Clone, Default)]
struct WrittenFiles {
    loa_profile: Option<PathBuf>,
    fap: Option<PathBuf>,
}

fn written_files(text: &str) -> Result<WrittenFiles, String> {
    settings(text, |to: &mut WrittenFiles, key, value| {
        match key {
            "loa-profile" => to.loa_profile = Some(file(value)?),
            "fap" => to.fap = Some(file(value)?),
            _ => return Ok(Some("loa-profile, fap")),
        }
        Ok(None)
    })
}

/// Plays the clip and prints the report.
pub(crate) fn run(args: &LodArgs, console: &Console) -> anyhow::Result<()> {
    if let Some(character) = &args.onto {
        args.method.selection.check(args.loa_profile().is_some())?;
        if stream::is_one(&args.character.file)? {
            return stream::run(args, character, console);
        }
        return face::run(args, character, console);
    }
    args.check()?;
    console.files.plan(args.inputs(), args.outputs())?;
    let figure = open::figure(&console.files, &args.character)?;
    let Some(clip) = figure.clip(args.clip.as_deref())? else {
        return at_rest(args, &figure, console);
    };
    let (name, frames) = (
        &figure.asset.clips[clip].name,
        figure.asset.clips[clip].frames(),
    );
    if frames > MAX_FRAMES {
        let what = format!("{frames} frames, at most {MAX_FRAMES} are allowed; trim the clip");
        anyhow::bail!("{}: clip \"{name}\": {what}", figure.opened.name());
    }
    let scene = EvaluatedClip {
        clip,
        setup: args.setup(),
        options: args.method.options(&figure.asset.rig)?,
        figure: &figure,
    };
    if let Some(path) = &args.camera_path {
        return moving_camera::run(args, &scene, path, console);
    }
    if let Some(path) = &args.schedule {
        return schedule::run(args, &scene, path, console);
    }
    let methods = args.method.chosen(&figure.asset.rig);
    let methods = methods.with_context(|| figure.opened.name().to_owned())?;
    args.check_parameter(&methods)?;
    let saved = args.save_selection(&figure, console)?;
    let tables =
        console.work(|work| scene.tables(&methods, args.distances(), args.tuning(), work))?;
    let mut report = LodReport::new(&scene, args, &tables);
    report.written.extend(saved);
    if let Some(path) = &args.face {
        report.face = Some(with_face::measured(args, path, &figure, &tables)?);
    }
    if let Some(path) = &args.plot {
        write_plots(&scene, &tables, path, &mut report, &console.files)?;
    }
    if let Some(path) = &args.contact_sheet {
        let notes = report.notes();
        let sheet = draw_sheet(&scene, &tables, &report.heading(), notes)?;
        report
            .written
            .push(files::write_png(&console.files, path, &sheet)?);
    }
    console.result(&report, LodReport::text)
}

impl LodArgs {
    /// The files that are read.
    fn inputs(&self) -> impl Iterator<Item = &Path> {
        let own = [
            &self.camera_path,
            &self.schedule,
            self.method.selection.input(),
            &self.face,
        ];
        let own = own.into_iter().flatten().map(PathBuf::as_path);
        self.character.inputs().chain(own)
    }

    /// The files that are written; those of a folder are checked when their names are known.
    fn outputs(&self) -> impl Iterator<Item = &Path> {
        let plot = self.plot.as_deref().filter(|path| is_svg(path));
        let sheet = self.contact_sheet.as_deref();
        plot.into_iter().chain(sheet).chain(self.loa_profile())
    }

    /// The LoA profile that is written.
    fn loa_profile(&self) -> Option<&Path> {
        self.write.as_ref()?.loa_profile.as_deref()
    }

    /// The FAP clip that is written.
    fn fap(&self) -> Option<&Path> {
        self.write.as_ref()?.fap.as_deref()
    }

    fn check(&self) -> anyhow::Result<()> {
        use crate::play::methods::MethodName;
        if self.parameter.is_some() && self.method.method() == MethodName::All {
            let what = "--parameter applies to one method; compare methods with --calibrate PX";
            return Err(fault::usage(what));
        }
        if self.fap().is_some() {
            let what = "--write fap needs --onto HEAD, on which its error is measured";
            return Err(fault::usage(what));
        }
        self.method.selection.check(self.loa_profile().is_some())?;
        self.method.check(self.schedule.is_some())?;
        let ends_with =
            |path: &PathBuf, endings: &[&str]| endings.contains(&files::extension(path).as_str());
        let sheet = self.contact_sheet.as_ref();
        if let Some(path) = sheet.filter(|path| !ends_with(path, &["png"])) {
            let path = files::shown(path);
            let what = format!("--contact-sheet {path}: sheets are PNG; name the file .png");
            return Err(fault::usage(what));
        }
        let pictures = ["png", "jpg", "jpeg", "pdf", "html"];
        if let Some(path) = self.plot.as_ref().filter(|p| ends_with(p, &pictures)) {
            let path = files::shown(path);
            let what = format!("--plot {path}: plots are SVG; name a .svg file or a folder");
            return Err(fault::usage(what));
        }
        self.check_distances()
    }

    fn check_distances(&self) -> anyhow::Result<()> {
        if self.distances.len() > 100 {
            return Err(fault::usage("--distances takes 1 to 100 distances"));
        }
        Ok(())
    }

    /// The distances, or the usual ones of bodies.
    fn distances(&self) -> &[f32] {
        self.distances_or(&DISTANCES_M)
    }

    /// The distances, or some others if none are given.
    fn distances_or<'a>(&'a self, usual: &'a [f32]) -> &'a [f32] {
        match &self.distances[..] {
            [] => usual,
            given => given,
        }
    }

    /// A parameter that counts frames or levels must be a whole number in range.
    fn check_parameter(&self, methods: &[NamedMethod]) -> anyhow::Result<()> {
        let (Some(parameter), [chosen]) = (self.parameter, methods) else {
            return Ok(());
        };
        let what = match &chosen.method {
            Method::SkipHold | Method::SkipLerp if parameter < 1.0 || parameter.fract() != 0.0 => {
                "every how many frames, a whole number from 1".to_owned()
            }
            Method::Loa(sets) if parameter.fract() != 0.0 || parameter >= sets.len() as f32 => {
                let last = sets.len() - 1;
                format!("the index of a level, from 0 (the most joints) to {last}")
            }
            _ => return Ok(()),
        };
        let name = chosen.method.name();
        Err(fault::usage(format!(
            "--parameter {parameter}: {name} takes {what}"
        )))
    }

    /// Writes the selected joints, if asked to; returns the path.
    fn save_selection(&self, figure: &Figure, console: &Console) -> anyhow::Result<Option<String>> {
        let Some(path) = self.loa_profile() else {
            return Ok(None);
        };
        let rig = &figure.asset.rig;
        let saved = self.method.selection.save(rig, path, &console.files);
        saved.with_context(|| figure.opened.name().to_owned())
    }

    fn tuning(&self) -> ParameterChoice {
        match (self.calibrate, self.parameter) {
            (Some(limit), _) => ParameterChoice::Calibrated(limit),
            (None, Some(parameter)) => ParameterChoice::Fixed(parameter),
            (None, None) => ParameterChoice::Usual,
        }
    }

    fn setup(&self) -> EvaluationSetup {
        EvaluationSetup {
            viewport: self.view.viewport(),
            seed: self.seed,
            ..EvaluationSetup::default()
        }
    }
}

/// Parses a distance in metres, from 0.01 to 100000.
fn distance(text: &str) -> Result<f32, String> {
    let is_allowed = |d| (0.01..=100_000.0).contains(&d);
    number(text, is_allowed, "a distance of 0.01 to 100000 m")
}

/// Parses the number of a named level.
fn named_level(text: &str) -> Result<usize, String> {
    let number = text.parse::<usize>().ok().filter(|n| *n <= 6);
    number.ok_or_else(|| "expected the number of a named level, 0 to 6".into())
}

fn at_rest(args: &LodArgs, figure: &Figure, console: &Console) -> anyhow::Result<()> {
    let mut report = LodReport::at_rest(figure, args);
    report.written.extend(args.save_selection(figure, console)?);
    if args.plot.is_some() {
        let what = "no clip, so there is nothing to plot; leave --plot out";
        anyhow::bail!("{}: {what}", figure.opened.name());
    }
    if let Some(path) = &args.contact_sheet {
        let mut artist = Artist::of_figure(figure, TILE_PX);
        let sheet = rest_sheet(&figure.asset, &mut artist, &report.heading());
        let sheet = sheet.context("the contact sheet")?;
        report
            .written
            .push(files::write_png(&console.files, path, &sheet)?);
    }
    console.result(&report, LodReport::text)
}

/// One line per distance for one method; one line per method at the middle distance for several.
fn draw_sheet(
    scene: &EvaluatedClip<'_>,
    tables: &[MethodTable],
    title: &str,
    mut notes: Vec<String>,
) -> anyhow::Result<Picture> {
    let lines = match tables {
        [table] => lines_by_distance(table),
        _ => {
            let middle = tables.first().map_or(0, |t| (t.rows.len() - 1) / 2);
            let row = tables.first().and_then(|t| t.rows.get(middle));
            notes.extend(row.map(|r| format!("All methods at {} m.", r.distance_m)));
            lines_by_method(tables, middle)
        }
    };
    let mut artist = Artist::of_figure(scene.figure, TILE_PX);
    motion_sheet(&scene.stage(), &mut artist, &lines, 4, title, notes).context("the contact sheet")
}

/// A file receives updates saved and error over distance; a folder all plots, costs included.
fn write_plots(
    scene: &EvaluatedClip<'_>,
    tables: &[MethodTable],
    path: &Path,
    report: &mut LodReport,
    files: &Files,
) -> anyhow::Result<()> {
    let clip = &scene.figure.asset.clips[scene.clip].name;
    let heading = format!("clip {clip}");
    let mut all = vec![
        gain_plot(tables, &heading),
        error_plot(tables, &heading, report.calibrate_px),
    ];
    if is_svg(path) {
        report.written.extend(write_plot_files(&all, path, files)?);
        return Ok(());
    }
    let rows = tables.first().map_or(&[][..], |t| &t.rows);
    let middle = rows.len().saturating_sub(1) / 2;
    let distance = rows.get(middle).map_or(0.0, |r| r.distance_m);
    let at = format!("{heading}, {distance} m");
    let (stage, lines) = (scene.stage(), lines_by_method(tables, middle));
    all.push(updates_plot(&stage, &lines, &at));
    let costs = Costs::new(&stage, &nanoseconds);
    all.extend(cost_plots(&costs, &heading));
    report.costs = Some(costs);
    report.written.extend(write_plot_files(&all, path, files)?);
    Ok(())
}

/// Writes plots into one file, or each into its own of a folder; returns the paths.
fn write_plot_files(plots: &[Plot], target: &Path, files: &Files) -> anyhow::Result<Vec<String>> {
    if is_svg(target) {
        files.write(target, stacked(plots).as_bytes())?;
        return Ok(vec![files::shown(target)]);
    }
    files.make_folder(target)?;
    let named = plots.iter().map(|plot| (target.join(plot.name), &plot.svg));
    let named: Vec<_> = named.collect();
    files.write_all(&named)?;
    Ok(named.iter().map(|(path, _)| files::shown(path)).collect())
}

fn is_svg(path: &Path) -> bool {
    files::extension(path) == "svg"
}
