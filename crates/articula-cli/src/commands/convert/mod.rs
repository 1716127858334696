//! `articula convert IN... OUT`: converts between formats, retargets onto a character, cleans and
//! reduces animations; one file or many.

mod boxing;
mod capture;
mod face;
mod face_level;
mod hygiene;
mod job;
mod joint_scheme;
mod mesh;
mod onto;
mod plan;
mod reduction;
mod report;
mod stream;

use crate::arguments::{ReadArgs, finite};
use crate::commands::face_shapes::FaceShapeArgs;
use crate::console::Console;
use crate::table::counted;
use crate::{fault, files};
use articula::Format;
use articula::core::face_levels::FaceLevels;
use articula::core::joint_state::PassivePolicy;
use clap::Args;
use job::{Done, Recipe};
use onto::{Hero, Pin};
use plan::Plan;
use rayon::prelude::*;
use reduction::Selected;
use report::{Batch, Failure};
use std::path::{Path, PathBuf};

/// Arguments of `convert`.
#[derive(Debug, Args)]
pub(crate) struct ConvertArgs {
    /// Files to read (.glb, .gltf, .vrm, .vrma, .fbx, .bvh, ...), or folders of them; last the file to
    /// write, in the format of its extension (.glb, .vrm, .vrma, .bvh, ...), or a folder that receives
    /// one file for each input
    #[arg(value_name = "IN… OUT", required = true)]
    paths: Vec<PathBuf>,
    /// Format of the files in an output folder [default: glb]
    #[arg(long, value_name = "FORMAT", value_parser = format)]
    to: Option<Format>,
    /// Character file onto which the motions are retargeted by the H-Anim map; OUT is this file
    /// with the motions as its clips
    #[arg(long, value_name = "CHARACTER")]
    onto: Option<PathBuf>,
    /// With --onto: keep the clips that the character already has
    #[arg(long, requires = "onto")]
    keep_clips: bool,
    /// With --onto: what is kept in place during contacts [default: feet]
    #[arg(
        long,
        value_enum,
        value_name = "WHAT,…",
        value_delimiter = ',',
        requires = "onto"
    )]
    pin: Vec<Pin>,
    /// With --onto: height of the floor in metres, in the motion's space [default: found from the
    /// feet]
    #[arg(long, value_name = "M", requires = "onto", allow_negative_numbers = true, value_parser = finite)]
    floor_metres: Option<f32>,
    /// With --onto: list the source of every joint's motion
    #[arg(long, requires = "onto")]
    map: bool,
    /// Name of the only clip to keep [default: all clips; for .bvh the first]
    #[arg(long, value_name = "NAME")]
    clip: Option<String>,
    /// Set of joints of the body: subtalars are merged into ankles and thumb0 joints inserted, or the
    /// other way round [default: the joints stay as they are]
    #[arg(long, value_name = "SCHEME", value_enum)]
    joint_scheme: Option<joint_scheme::SchemeName>,
    /// Joints that may move, such as "loa(Low) + zone(hands)"; all others are held
    #[arg(long, value_name = "EXPR")]
    loa: Option<String>,
    /// Also move the ancestors of joints that may move
    #[arg(long)]
    with_ancestors: bool,
    /// LoA profile with the joints that may move (JSON), instead of --loa
    #[arg(long, value_name = "F.json", conflicts_with = "loa")]
    loa_profile: Option<PathBuf>,
    /// Pose of held joints: hold, rest, key-pose, blend-to-rest:SECS [default: key-pose]
    #[arg(long, value_name = "POLICY", value_parser = reduction::passive)]
    passive: Option<PassivePolicy>,
    /// Level of articulation of FAP and AFP files: high, medium, low or very-low, and those of
    /// regions that differ, such as low,jaw=high,cheeks=medium; regions are high-level, jaw,
    /// eyeballs, eyebrows, cheeks, head, nose and ears. OUT.fap or OUT.afp holds what is kept; with
    /// --onto the face shows what a receiver makes of it
    #[arg(long, value_name = "LEVEL,REGION=LEVEL,...", value_parser = face_level::levels)]
    face_level: Option<FaceLevels>,
    /// Write the draft glTF extensions for characters: skeleton mapping and reference pose
    /// (.glb only)
    #[arg(long)]
    khr_character: bool,
    /// Further stream that goes into OUT.mp4, in a track of its own: .abp, .afp, .fba, .mp4, or .fap,
    /// which becomes an AFP-2 stream (repeatable)
    #[arg(long, value_name = "STREAM")]
    with: Vec<PathBuf>,
    #[command(flatten)]
    stream: stream::StreamArgs,
    #[command(flatten)]
    shapes: FaceShapeArgs,
    #[command(flatten)]
    mesh: mesh::MeshArgs,
    #[command(flatten)]
    hygiene: hygiene::HygieneArgs,
    #[command(flatten)]
    names: ReadArgs,
}

/// Reads, edits and writes.
pub(crate) fn run(args: &ConvertArgs, console: &Console) -> anyhow::Result<()> {
    args.check()?;
    boxing::check(args)?;
    face_level::check(args)?;
    if boxing::is_meant(args)? {
        return boxing::run(args, console);
    }
    if face::is_meant(args)? {
        return face::run(args, console);
    }
    let plan = Plan::of(args)?;
    args.mesh.check(plan.folder.is_some())?;
    for job in &plan.jobs {
        args.hygiene.check(job.format)?;
        args.check_khr_character(job.format)?;
        args.stream.check(job.format)?;
    }
    plan.check_files(args, &console.files)?;
    let recipe = Recipe {
        args,
        hero: Hero::new(args, &console.files)?,
        files: &console.files,
        folder: plan.folder.as_deref(),
        selected: Selected::of(args)?,
        bar: console.progress("converting", plan.inputs()),
    };
    let done: Vec<Done> = plan.jobs.par_iter().map(|job| recipe.run(job)).collect();
    recipe.bar.finish_and_clear();
    match &plan.folder {
        None => one_file(args, &plan, done, console),
        Some(folder) => many_files(args, files::shown(folder), done, console),
    }
}

/// Prints what was written, then the files that could not be used, with the reasons.
fn one_file(
    args: &ConvertArgs,
    plan: &Plan,
    mut done: Vec<Done>,
    console: &Console,
) -> anyhow::Result<()> {
    let Done { report, mut faults } = done.swap_remove(0);
    let Some(mut report) = report else {
        if faults.len() == 1 {
            return Err(faults.swap_remove(0).1);
        }
        report_faults(&faults, console);
        anyhow::bail!("none of the files could be used; nothing was written");
    };
    report.failed = failures(&faults);
    console.result(&report, |r| r.text(args.map))?;
    ended(&faults, plan.inputs(), console)
}

/// As [`one_file`], for a folder of files.
fn many_files(
    args: &ConvertArgs,
    out: String,
    done: Vec<Done>,
    console: &Console,
) -> anyhow::Result<()> {
    let count = done.len();
    let mut files = Vec::new();
    let mut faults = Vec::new();
    for done in done {
        files.extend(done.report);
        faults.extend(done.faults);
    }
    let batch = Batch {
        out,
        files,
        failed: failures(&faults),
    };
    console.result(&batch, |b| b.text(args.map))?;
    ended(&faults, count, console)
}

fn failures(faults: &[(PathBuf, anyhow::Error)]) -> Vec<Failure> {
    let failure = |(path, fault): &(PathBuf, anyhow::Error)| Failure::new(path, fault);
    faults.iter().map(failure).collect()
}

fn report_faults(faults: &[(PathBuf, anyhow::Error)], console: &Console) {
    for (_, fault) in faults {
        console.fault(fault);
    }
}

/// Prints one line for each fault; an error if there is any.
fn ended(
    faults: &[(PathBuf, anyhow::Error)],
    files: usize,
    console: &Console,
) -> anyhow::Result<()> {
    if faults.is_empty() {
        return Ok(());
    }
    report_faults(faults, console);
    let files = counted(files, "file", "files");
    anyhow::bail!("{} of {files} failed; the others are done", faults.len())
}

fn format(name: &str) -> Result<Format, String> {
    Format::of_extension(name)
        .ok_or_else(|| format!("supported conversions: {}", articula::conversions()))
}

impl ConvertArgs {
    /// The files and folders to convert.
    fn sources(&self) -> &[PathBuf] {
        &self.paths[..self.paths.len().saturating_sub(1)]
    }

    /// The file or folder to write.
    fn out(&self) -> &Path {
        self.paths.last().map_or(Path::new(""), PathBuf::as_path)
    }

    /// The named files that are read.
    fn inputs(&self) -> impl Iterator<Item = &Path> {
        let named = self.sources().iter().filter(|path| !path.is_dir());
        let named = named.chain(&self.onto).chain(&self.loa_profile);
        let named = named.chain(self.shapes.input()).chain(&self.with);
        named.map(PathBuf::as_path).chain(self.names.inputs())
    }

    fn check(&self) -> anyhow::Result<()> {
        if self.sources().is_empty() {
            return Err(fault::usage(
                "name the files to read, then the file to write: IN OUT",
            ));
        }
        Pin::check(&self.pin)?;
        let reduces = self.loa.is_some() || self.loa_profile.is_some();
        if (self.passive.is_some() || self.with_ancestors) && !reduces {
            return Err(fault::usage(
                "--passive and --with-ancestors need --loa EXPR or --loa-profile F.json",
            ));
        }
        Ok(())
    }

    /// Whether a flag is given that chooses or changes what a motion shows, or how it is coded.
    fn changes_motions(&self) -> bool {
        self.to.is_some()
            || self.onto.is_some()
            || self.clip.is_some()
            || self.loa.is_some()
            || self.loa_profile.is_some()
            || self.face_level.is_some()
            || self.khr_character
            || self.stream.asks()
            || self.shapes.asks()
            || self.mesh.options().is_some()
            || self.hygiene.asks()
            || self.names.asks()
    }

    fn check_khr_character(&self, out: Format) -> anyhow::Result<()> {
        if self.khr_character && out != Format::Glb {
            let what = "--khr-character requires a .glb output, not";
            return Err(fault::usage(format!("{what} .{}", out.name())));
        }
        Ok(())
    }
}
