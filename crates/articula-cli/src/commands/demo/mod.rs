//! `articula demo`: all steps on one character, with an HTML report.
//!
//! Character → asset → every method over distance → a crowd → pictures, plots, page. All numbers on
//! the page are those of this run.

mod adaptation;
mod crowd;
mod face;
mod flatten;
mod mesh_levels;
mod page;
mod pictures;
mod report;

use crate::arguments::ReadArgs;
use crate::commands::human;
use crate::commands::lod::DISTANCES_M;
use crate::console::Console;
use crate::fault;
use crate::files::{self, Files};
use crate::open;
use crate::play::motion_plots::{error_plot, gain_plot, updates_plot};
use crate::play::{drawn, nanoseconds};
use anyhow::Context;
use articula::build::evaluate::{EvaluationSetup, MethodOptions};
use articula::evaluate::{Costs, EvaluatedClip, MethodTable, NamedMethod, ParameterChoice};
use articula::formats::gltf::Document;
use articula::human::HumanOptions;
use articula::{AddClipsOptions, Figure, MeshLevelOptions, PrepareOptions, prepare};
use clap::Args;
use mesh_levels::MeshLevels;
use report::{ClipRows, DemoReport, Found, Level};
use std::path::{Path, PathBuf};

/// Error to which every method is calibrated, pixels.
const TARGET_PX: f32 = 1.0;
/// The clip that all methods play, where the character has it; else its first.
const CLIP: &str = "walk";
/// Index of the distance in pictures of all methods: 9.05 m.
const MIDDLE: usize = 2;

/// Arguments of `demo`.
#[derive(Debug, Args)]
pub(crate) struct DemoArgs {
    /// Character to show, and files whose clips it plays besides its own, on the spot [default: the
    /// built-in reference human]
    #[arg(value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Folder to write
    #[arg(long, value_name = "DIR", default_value = "articula-demo")]
    out: PathBuf,
    /// Open the studio as well (not available yet)
    #[arg(long)]
    serve: bool,
}

/// Runs all steps and prints the path of the page.
pub(crate) fn run(args: &DemoArgs, console: &Console) -> anyhow::Result<()> {
    if args.serve {
        return Err(fault::usage(
            "--serve: the server comes with the studio, which is not available yet; leave --serve out",
        ));
    }
    let folder = Folder::new(&args.out, &args.files, &console.files)?;
    let (asset, mesh_levels) = make_asset(&folder, &args.files, console)?;
    let figure = Figure::new(open::character(
        &console.files,
        &asset,
        &ReadArgs::default(),
    )?)?;
    let scene = scene_of(&figure, clip_of(&figure)?)?;
    let chosen = NamedMethod::all(&figure.asset.rig);
    let tuning = ParameterChoice::Calibrated(TARGET_PX);
    let tables = console.work(|work| scene.tables(&chosen, &DISTANCES_M, tuning, work))?;
    let clips = over_clips(&figure, &chosen, console)?;
    let levels = levels_of(&figure);
    let costs = Costs::new(&scene.stage(), &nanoseconds);
    draw(&folder, &scene, &tables, console)?;
    plot(&folder, &scene, &tables, &costs)?;
    mesh_levels::draw(&folder, &scene)?;
    let flat = flatten::of(&folder, &scene, console)?;
    let face = face::of(&folder, &figure, console)?;
    let crowd = crowd::of(&figure, TARGET_PX, &folder, console)?;
    let adaptation = adaptation::of(&folder, &scene, console)?;
    let found = Found {
        clips,
        levels,
        costs,
        crowd,
        mesh_levels,
        flat,
        face,
        adaptation,
    };
    let name = match args.files.first() {
        Some(file) => name_of(file),
        None => "the reference human".to_owned(),
    };
    let report = DemoReport::new(&folder, name, &scene, &tables, found);
    folder.write("report.json", &serde_json::to_vec_pretty(&report)?)?;
    folder.write("index.html", page::of(&report).as_bytes())?;
    console.result(&report, DemoReport::text)
}

/// The output folder.
pub(super) struct Folder<'a> {
    path: PathBuf,
    files: &'a Files,
}

impl<'a> Folder<'a> {
    /// Refuses a folder with the report of an earlier run, before the work.
    fn new(path: &Path, inputs: &[PathBuf], files: &'a Files) -> anyhow::Result<Self> {
        let folder = Self {
            path: path.to_owned(),
            files,
        };
        let (first, last) = (folder.file("asset.glb"), folder.file("index.html"));
        let inputs = inputs.iter().map(PathBuf::as_path);
        let outputs = [first.as_path(), last.as_path()].into_iter();
        files.plan(inputs, outputs.filter(|_| path.is_dir()))?;
        Ok(folder)
    }

    fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    fn write(&self, name: &str, bytes: &[u8]) -> anyhow::Result<()> {
        self.files.make_folder(&self.path)?;
        Ok(self.files.write(&self.file(name), bytes)?)
    }
}

/// The file name of a path.
fn name_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

/// The name of the clip to play: `walk`, or the first.
fn clip_of(figure: &Figure) -> anyhow::Result<&str> {
    let clips = &figure.asset.clips;
    let walk = clips.iter().find(|c| c.name == CLIP);
    let clip = walk.or(clips.first()).context("the asset has no clip")?;
    Ok(&clip.name)
}

/// Writes the asset; returns its path. The reference human is written as well.
fn make_asset(
    folder: &Folder<'_>,
    files: &[PathBuf],
    console: &Console,
) -> anyhow::Result<(PathBuf, MeshLevels)> {
    let opened = match files.split_first() {
        Some((character, motions)) => {
            let open = |path: &PathBuf| open::character(&console.files, path, &ReadArgs::default());
            let mut opened = open(character)?;
            let motions = motions.iter().map(open).collect::<Result<Vec<_>, _>>()?;
            let options = AddClipsOptions::default();
            console.work(|work| opened.add_clips(&motions, &options, work))?;
            anyhow::ensure!(
                !opened.character().clips.is_empty(),
                "{}: the file has no clip; name a file of motions after it",
                files::shown(character)
            );
            opened.put_in_place();
            opened
        }
        None => {
            let character = human::made(HumanOptions::default().triangles, console)?;
            let document = Document::from_character(&character).context("the reference human")?;
            folder.write("human.glb", &document.write_glb()?)?;
            open::character(
                &console.files,
                &folder.file("human.glb"),
                &ReadArgs::default(),
            )?
        }
    };
    let options = PrepareOptions {
        mesh_levels: Some(MeshLevelOptions::levels(5)),
        ..PrepareOptions::default()
    };
    let built = console.work(|work| prepare(opened, &options, work))?;
    folder.write("asset.glb", &built.glb)?;
    let levels = built
        .mesh_levels
        .as_ref()
        .context("the asset has no mesh levels")?;
    Ok((
        folder.file("asset.glb"),
        MeshLevels::new(levels, built.mesh_bytes),
    ))
}

fn scene_of<'a>(figure: &'a Figure, clip: &str) -> anyhow::Result<EvaluatedClip<'a>> {
    let clip = figure.clip(Some(clip))?;
    Ok(EvaluatedClip {
        figure,
        clip: clip.unwrap_or(0),
        setup: EvaluationSetup::default(),
        options: MethodOptions::default(),
    })
}

/// `skin-px` on every clip of the character.
fn over_clips(
    figure: &Figure,
    chosen: &[NamedMethod],
    console: &Console,
) -> anyhow::Result<Vec<ClipRows>> {
    let ours = &chosen[..1];
    let mut all = Vec::new();
    for clip in &figure.asset.clips {
        let scene = scene_of(figure, &clip.name)?;
        let tuning = ParameterChoice::Calibrated(TARGET_PX);
        let tables = console.work(|work| scene.tables(ours, &DISTANCES_M, tuning, work))?;
        all.push(ClipRows {
            clip: clip.name.clone(),
            rows: tables.into_iter().flat_map(|t| t.rows).collect(),
        });
    }
    Ok(all)
}

/// The stored animation at each level of articulation.
fn levels_of(figure: &Figure) -> Vec<Level> {
    let rig = &figure.asset.rig;
    let clips = &figure.opened.character().clips;
    articula::core::Complexity::ALL
        .into_iter()
        .rev()
        .map(|level| Level::new(level, rig, clips))
        .collect()
}

fn draw(
    folder: &Folder<'_>,
    scene: &EvaluatedClip<'_>,
    tables: &[MethodTable],
    console: &Console,
) -> anyhow::Result<()> {
    let bar = console.progress("drawing", 4);
    for (name, picture) in [
        ("character.png", pictures::character as pictures::Draw),
        ("distances.png", pictures::distances),
        ("methods.png", pictures::methods),
        ("levels.png", pictures::levels),
    ] {
        let png = picture(scene, tables)?.to_png()?;
        folder.write(name, &png)?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(())
}

fn plot(
    folder: &Folder<'_>,
    scene: &EvaluatedClip<'_>,
    tables: &[MethodTable],
    costs: &Costs,
) -> anyhow::Result<()> {
    let clip = &scene.figure.asset.clips[scene.clip].name;
    let heading = format!("clip {clip}, calibrated to {TARGET_PX} px");
    let over_the_clip = drawn::lines_by_method(tables, MIDDLE);
    let at = format!("clip {clip}, {} m", DISTANCES_M[MIDDLE]);
    let errors = drawn::series(tables, |r| r.error_px.p95);
    let mut all = vec![
        gain_plot(&drawn::series(tables, |r| r.joint_update_gain), &heading),
        error_plot(&errors, &heading, Some(TARGET_PX)),
        updates_plot(&scene.stage(), &over_the_clip, &at),
    ];
    all.extend(drawn::cost_plots(costs, &format!("clip {clip}")));
    for plot in all {
        folder.write(plot.name, plot.svg.as_bytes())?;
    }
    Ok(())
}
