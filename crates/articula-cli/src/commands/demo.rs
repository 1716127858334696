//! `articula demo`: all steps on one character, with an HTML report, and a folder to serve.

use crate::arguments::ReadArgs;
use crate::commands::flatten::report::warnings;
use crate::commands::human;
use crate::commands::serve::{self, ServeArgs};
use crate::console::Console;
use crate::files::{self, Files};
use crate::open;
use anyhow::Context;
use articula::formats::Limits;
use articula::formats::gltf::Document;
use articula::human::HumanOptions;
use articula::{
    AddClipsOptions, CharacterFile, Figure, MeshLevelOptions, PrepareOptions, PreparedAsset,
    PreparedMeshLevels, prepare,
};
use articula_report::demo::Demo;
use clap::Args;
use std::path::{Path, PathBuf};

/// File of the reference human, if it is shown.
const HUMAN: &str = "human.glb";

/// Folder of characters to serve, in that of the demo.
const STORE: &str = "store";

/// What the guide says, on the clocks of its clips.
const CAPTIONS: &str = "WEBVTT

idle
00:00.000 --> 01:00.000
Ask me to walk or to wave: the keys 1 to 9 choose a clip.

walk
00:00.000 --> 01:00.000
This way, please. I arrive in parts; the first are enough to walk.

wave
00:00.000 --> 01:00.000
Here it is! Left and right change the bandwidth, up and down the distance.
";

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
    /// Then serve the character and a guide, at http://127.0.0.1:8080, until the program is ended
    #[arg(long)]
    serve: bool,
}

/// Runs all steps and prints the path of the page.
pub(crate) fn run(args: &DemoArgs, console: &Console) -> anyhow::Result<()> {
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
    let guide = match args.files.is_empty() {
        // It is what was shown.
        true => files::read(&folder.file(HUMAN), Limits::default().bytes)?,
        false => reference_human(console)?,
    };
    folder.write_store(&built.glb, &guide)?;
    let store = folder.file(STORE);
    console.result(&demo.report, |report| {
        let store = files::shown(&store);
        // The page comes last, where it is looked for.
        format!(
            "articula serve {store} serves the character and a guide\n{}",
            report.text()
        )
    })?;
    match args.serve {
        true => serve::run(&ServeArgs::of_folder(store), console),
        false => Ok(()),
    }
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
        let path = self.file(name);
        self.files
            .make_folder(path.parent().unwrap_or(&self.path))?;
        Ok(self.files.write(&path, bytes)?)
    }

    /// Writes the folder that can be served: the character, and a guide who speaks by captions.
    fn write_store(&self, character: &[u8], guide: &[u8]) -> anyhow::Result<()> {
        self.write(&format!("{STORE}/character.glb"), character)?;
        self.write(&format!("{STORE}/guide.glb"), guide)?;
        self.write(&format!("{STORE}/guide.vtt"), CAPTIONS.as_bytes())
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
            folder.write(HUMAN, &reference_human(console)?)?;
            let human = folder.file(HUMAN);
            open::character(&console.files, &human, &ReadArgs::default())?
        }
    };
    let options = PrepareOptions {
        mesh_levels: PreparedMeshLevels::New(MeshLevelOptions::levels(5)),
        ..PrepareOptions::default()
    };
    let built = console.work(|work| prepare(opened, &options, work))?;
    folder.write("asset.glb", &built.glb)?;
    Ok(built)
}

/// The file of the painted human.
fn reference_human(console: &Console) -> anyhow::Result<Vec<u8>> {
    let character = human::painted(HumanOptions::default().triangles, console)?;
    let document = Document::from_character(&character).context("the reference human")?;
    Ok(document.write_glb()?)
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
