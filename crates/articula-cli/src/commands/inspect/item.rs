//! `articula inspect ITEM/`: the parts of a digital item, their layers, bytes and errors.

use crate::arguments::CharacterArgs;
use crate::commands::package::report::ItemReport;
use crate::console::Console;
use crate::{fault, files};
use articula::formats::Limits;

/// Prints what the item holds.
pub(super) fn run(args: &CharacterArgs, console: &Console) -> anyhow::Result<()> {
    if args.leaves_out() {
        let what =
            "--hide and --only choose meshes of a character; convert the item to a .glb first";
        return Err(fault::usage(what));
    }
    let item = console.files.open_item(&args.file, &Limits::default())?;
    let report = ItemReport::new(files::shown(&args.file), &item);
    console.result(&report, ItemReport::text)
}
