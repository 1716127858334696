//! `articula demo`: all steps on one character, with an HTML report.

use crate::arguments::ReadArgs;
use crate::commands::flatten::report::warnings;
use crate::commands::human;
use crate::console::Console;
use crate::fault;
use crate::files::{self, Files};
use crate::open;
use anyhow::Context;
use articula::formats::gltf::Document;
use articula::human::HumanOptions;
use articula::{
    AddClipsOptions, CharacterFile, Figure, MeshLevelOptions, PrepareOptions, PreparedAsset,
    prepare,
};
use articula_report::demo::{Demo, DemoReport};
use clap::Args;
use std::path::{Path, PathBuf};

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
    let built = make_asset(&folder, &args.files, console)?;
    let levels = built.mesh_levels.as_ref();
    let levels = levels.context("the asset has no mesh levels")?;
    let asset = folder.file("asset.glb");
    let opened = open::character(&console.files, &asset, &ReadArgs::default())?;
    let figure = Figure::new(opened)?;
    let name = match args.files.first() {
        Some(file) => name_of(file),
        None => "the reference human".to_owned(),
    };
    let page = files::shown(&folder.file("index.html"));
    let levels = (levels, built.mesh_bytes);
    let mut demo = console.work(|work| Demo::new(&figure, levels, name, page, work))?;
    for flat in &mut demo.report.flat {
        flat.warnings = warnings(flat);
    }
    for (name, bytes) in &demo.files {
        folder.write(name, bytes)?;
    }
    folder.write("report.json", &serde_json::to_vec_pretty(&demo.report)?)?;
    folder.write("index.html", demo.page().as_bytes())?;
    console.result(&demo.report, DemoReport::text)
}

/// The output folder.
struct Folder<'a> {
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

/// Writes the asset, and the reference human if it is shown.
fn make_asset(
    folder: &Folder<'_>,
    files: &[PathBuf],
    console: &Console,
) -> anyhow::Result<PreparedAsset> {
    let opened = match files.split_first() {
        Some((character, motions)) => with_motions(character, motions, console)?,
        None => {
            let character = human::made(HumanOptions::default().triangles, console)?;
            let document = Document::from_character(&character).context("the reference human")?;
            folder.write("human.glb", &document.write_glb()?)?;
            let human = folder.file("human.glb");
            open::character(&console.files, &human, &ReadArgs::default())?
        }
    };
    let options = PrepareOptions {
        mesh_levels: Some(MeshLevelOptions::levels(5)),
        ..PrepareOptions::default()
    };
    let built = console.work(|work| prepare(opened, &options, work))?;
    folder.write("asset.glb", &built.glb)?;
    Ok(built)
}

/// A character with its clips and those of other files, on the spot.
fn with_motions(
    character: &Path,
    motions: &[PathBuf],
    console: &Console,
) -> anyhow::Result<CharacterFile> {
    let open = |path: &Path| open::character(&console.files, path, &ReadArgs::default());
    let mut opened = open(character)?;
    let motions = motions.iter().map(|path| open(path));
    let motions = motions.collect::<Result<Vec<_>, _>>()?;
    let options = AddClipsOptions::default();
    console.work(|work| opened.add_clips(&motions, &options, work))?;
    anyhow::ensure!(
        !opened.character().clips.is_empty(),
        "{}: the file has no clip; name a file of motions after it",
        files::shown(character)
    );
    opened.put_in_place();
    Ok(opened)
}
