//! `articula inspect FILE`: prints the contents of a file and warns about irregularities.

mod data;
mod human;
mod mesh_levels;
mod stream;
mod text;

use crate::arguments::CharacterArgs;
use crate::console::Console;
use crate::open;
use crate::{fault, files};
use articula::MotionTables;
use articula::inspect::WarningInspection;
use articula::inspect::inspect;
use clap::Args;

/// Arguments of `inspect`.
#[derive(Debug, Args)]
pub(crate) struct InspectArgs {
    #[command(flatten)]
    character: CharacterArgs,
    /// List every joint with its H-Anim name, level and region; of a FAP file every parameter
    #[arg(long)]
    map: bool,
    /// Name of the only clip to report
    #[arg(long, value_name = "NAME")]
    clip: Option<String>,
}

/// Reads the file and prints its contents.
pub(crate) fn run(args: &InspectArgs, console: &Console) -> anyhow::Result<()> {
    if let Some(format) = files::data_format(&args.character.file) {
        if args.clip.is_some() {
            return Err(fault::usage(format!(
                "--clip chooses a motion of joints; a .{} file has none",
                format.name()
            )));
        }
        return data::run(&args.character, format, args.map, console);
    }
    if stream::is_one(&args.character.file) {
        return stream::run(&args.character, console);
    }
    let figure = open::figure(&args.character)?;
    let clips: Vec<usize> = match &args.clip {
        Some(name) => figure.clip(Some(name))?.into_iter().collect(),
        None => (0..figure.asset.clips.len()).collect(),
    };
    let mut findings = console.work(|work| inspect(&figure, &clips, work))?;
    for (told, warning) in findings.warnings.iter_mut().zip(&figure.opened.warnings) {
        told.what = open::advised(warning);
    }
    if !args.character.leaves_out() {
        for (clip, found) in clips.iter().zip(&mut findings.clips) {
            let tables = MotionTables::stored(&figure, *clip);
            found.motion_tables = Some(tables.bytes);
            let told = |what| WarningInspection {
                at: "file".to_owned(),
                what,
            };
            findings
                .warnings
                .extend(tables.warnings.into_iter().map(told));
        }
    }
    console.result(&findings, |found| text::of(found, args.map))
}
