//! `articula human OUT.glb`: writes the procedural reference human.

use crate::console::Console;
use crate::{fault, files};
use anyhow::Context;
use articula::core::source::Character;
use articula::formats::face_points;
use articula::formats::gltf::Document;
use articula::human::{HumanOptions, TRIANGLES, feature_points, human};
use articula::{Format, painted_human};
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;

/// Arguments of `human`.
#[derive(Debug, Args)]
pub(crate) struct HumanArgs {
    /// File to write (.glb)
    out: PathBuf,
    /// Number of triangles of all meshes together, 2000 to 70000
    #[arg(long, value_name = "N", default_value_t = HumanOptions::default().triangles)]
    triangles: usize,
    /// Make the plain mannequin, without a face that moves, hair and clothes
    #[arg(long)]
    mannequin: bool,
    /// Colours in a picture instead of materials: hair in strands, buttons, pockets, laces, the shade of folds
    #[arg(long, conflicts_with = "mannequin")]
    painted: bool,
    /// Also write where the feature points of the face are, as they were constructed
    #[arg(long, value_name = "F.json", conflicts_with = "mannequin")]
    face_points: Option<PathBuf>,
}

#[derive(Debug, Serialize)]
struct Written {
    out: String,
    triangles: usize,
    vertices: usize,
    joints: usize,
    clips: Vec<String>,
    bytes: usize,
}

/// Makes the human and writes it.
pub(crate) fn run(args: &HumanArgs, console: &Console) -> anyhow::Result<()> {
    if files::format(&args.out) != Some(Format::Glb) {
        let what = "the reference human is written as GLB; name the file .glb";
        return Err(fault::usage(format!("{}: {what}", files::shown(&args.out))));
    }
    let outputs = [Some(&args.out), args.face_points.as_ref()];
    let outputs = outputs.into_iter().flatten().map(PathBuf::as_path);
    console.files.plan([], outputs)?;
    let character = match args.painted {
        true => painted(args.triangles, console)?,
        false => plain(args, console)?,
    };
    let document = Document::from_character(&character).context("the reference human")?;
    let bytes = document.write_glb().context("the reference human")?;
    console.files.write(&args.out, &bytes)?;
    if let Some(path) = &args.face_points {
        let points = feature_points().into_iter();
        let places: Vec<_> = points.map(|p| (p.point, p.position)).collect();
        console.files.write(path, &face_points::write(&places))?;
    }
    let primitives = || character.meshes.iter().flat_map(|m| &m.primitives);
    let written = Written {
        out: files::shown(&args.out),
        triangles: primitives().map(|p| p.triangles.len()).sum(),
        vertices: primitives().map(|p| p.positions.len()).sum(),
        joints: character.skeleton.joints.len(),
        clips: character.clips.iter().map(|c| c.name.clone()).collect(),
        bytes: bytes.len(),
    };
    console.result(&written, |w| {
        format!(
            "{}: {} triangles, {} vertices, {} joints, clips {}; {:.1} kB\n",
            w.out,
            w.triangles,
            w.vertices,
            w.joints,
            w.clips.join(", "),
            w.bytes as f64 / 1e3
        )
    })
}

/// The human or the mannequin with its colours in materials.
fn plain(args: &HumanArgs, console: &Console) -> anyhow::Result<Character> {
    let options = HumanOptions {
        triangles: args.triangles,
        face: !args.mannequin,
    };
    with_progress(args.triangles, console, || {
        human(&options).context("the reference human")
    })
}

/// The human with its colours in a picture.
pub(crate) fn painted(triangles: usize, console: &Console) -> anyhow::Result<Character> {
    with_progress(triangles, console, || {
        painted_human(triangles).context("the reference human")
    })
}

/// Makes a human, if the number of triangles is supported.
fn with_progress(
    triangles: usize,
    console: &Console,
    make: impl FnOnce() -> anyhow::Result<Character>,
) -> anyhow::Result<Character> {
    if !TRIANGLES.contains(&triangles) {
        return Err(fault::usage(format!(
            "--triangles {triangles}: the reference human has {} to {} triangles",
            TRIANGLES.start(),
            TRIANGLES.end()
        )));
    }
    let bar = console.progress("building the human", 1);
    let character = make()?;
    bar.finish_and_clear();
    Ok(character)
}
