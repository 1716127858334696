//! `articula inspect FILE`: what is in a file, and what is odd about it.

mod extent;
mod findings;
mod human;
mod skeletons;
mod text;

use crate::arguments::CharacterArgs;
use crate::console::Console;
use crate::motion_tables;
use crate::prepared::Prepared;
use clap::Args;

/// Arguments of `inspect`.
#[derive(Debug, Args)]
pub(crate) struct InspectArgs {
    #[command(flatten)]
    character: CharacterArgs,
    /// List every joint with its H-Anim name, level and region
    #[arg(long)]
    map: bool,
    /// Say more of this clip only
    #[arg(long, value_name = "NAME")]
    clip: Option<String>,
}

/// Reads the file and prints what was found.
pub(crate) fn run(args: &InspectArgs, console: &Console) -> anyhow::Result<()> {
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
