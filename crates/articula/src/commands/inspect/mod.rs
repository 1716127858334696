//! `articula inspect FILE`: what is in a file, and what is odd about it.

mod data;
mod extent;
mod findings;
mod human;
mod mesh_levels;
mod skeletons;
mod stream;
mod text;

use crate::arguments::CharacterArgs;
use crate::console::Console;
use crate::fault;
use crate::load::data::DataFormat;
use crate::motion_tables;
use crate::prepared::Prepared;
use clap::Args;

/// Arguments of `inspect`.
#[derive(Debug, Args)]
pub(crate) struct InspectArgs {
    #[command(flatten)]
    character: CharacterArgs,
    /// List every joint with its H-Anim name, level and region; of a FAP file every parameter
    #[arg(long)]
    map: bool,
    /// Say more of this clip only
    #[arg(long, value_name = "NAME")]
    clip: Option<String>,
}

/// Reads the file and prints what was found.
pub(crate) fn run(args: &InspectArgs, console: &Console) -> anyhow::Result<()> {
    if let Some(format) = DataFormat::of_name(&args.character.file) {
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
    let prepared = Prepared::new(&args.character)?;
    let clips: Vec<usize> = match &args.clip {
        Some(name) => prepared.clip(Some(name))?.into_iter().collect(),
        None => (0..prepared.asset.clips.len()).collect(),
    };
    let mut findings = findings::of(&prepared, &clips, console);
    if !args.character.leaves_out() {
        let tables = motion_tables::checked(&prepared)?;
        for (clip, found) in clips.iter().zip(&mut findings.clips) {
            found.motion_tables = tables.get(*clip).copied();
        }
    }
    console.result(&findings, |found| text::of(found, args.map))
}
