//! Streams of mesh levels: every chunk is checked and decoded.

use super::text::head_line;
use crate::arguments::CharacterArgs;
use crate::console::Console;
use crate::table::{Table, millimetres};
use crate::{fault, files};
use articula::inspect::{StreamInspection, inspect_stream};
use articula::stream::StreamLimits;
use std::path::Path;

/// Whether a file has the extension of mesh streams.
pub(super) fn is_one(path: &Path) -> bool {
    files::extension(path) == "ams"
}

/// Reads the file and prints its contents.
pub(super) fn run(args: &CharacterArgs, console: &Console) -> anyhow::Result<()> {
    if args.leaves_out() {
        let what = "--hide and --only choose meshes of a character; a mesh stream has none";
        return Err(fault::usage(what));
    }
    let limits = StreamLimits::default();
    let bytes = files::read(&args.file, limits.bytes)?;
    let findings = inspect_stream(&bytes, &files::shown(&args.file), &limits)?;
    console.result(&findings, text)
}

fn text(found: &StreamInspection) -> String {
    let mut text = head_line(&found.file, found.format, found.bytes, "");
    text.push_str(&format!(
        "{} parts, header of {} bytes\n",
        found.objects, found.bytes_head
    ));
    let mut table = Table::new(&[
        "level",
        "triangles",
        "vertices",
        "error at rest",
        "error in motion",
        "bytes added",
        "",
    ]);
    for level in &found.levels {
        let [rest, motion] = [level.error_rest_m, level.error_motion_m].map(millimetres);
        table.row([
            level.level.to_string(),
            level.triangles.to_string(),
            level.vertices.to_string(),
            rest,
            motion,
            level.bytes_added.to_string(),
            (if level.complete { "" } else { "incomplete" }).to_owned(),
        ]);
    }
    text.push_str(&table.text());
    text
}
