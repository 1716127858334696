//! Motion streams (ABP-2) without their character, and face streams (AFP-2): tiers and groups with
//! their bytes.

use super::mp4;
use super::text::{head_line, warnings_text};
use crate::arguments::CharacterArgs;
use crate::console::Console;
use crate::fault::clean;
use crate::open::{self, Stream};
use crate::table::{Table, counted};
use crate::{fault, files};
use articula::Format;
use articula::formats::Warning;
use articula::inspect::{MotionStreamInspection, WarningInspection, inspect_motion_stream};
use articula::stream::StreamLimits;

/// Prints the contents of a motion stream.
pub(super) fn run(stream: &Stream, args: &CharacterArgs, console: &Console) -> anyhow::Result<()> {
    if args.leaves_out() {
        let what = "--hide and --only choose meshes of a character; a motion stream has none";
        return Err(fault::usage(what));
    }
    let limits = StreamLimits::default();
    let mut found = inspect_motion_stream(&stream.bytes, &files::shown(&args.file), &limits)?;
    found.bytes = stream.file_bytes;
    found.tracks = open::tracks(&args.file)?;
    if !found.tracks.is_empty() {
        found.format = Format::Mp4.name();
    }
    let told = |warning: &Warning| WarningInspection {
        at: warning.at.clone(),
        what: warning.what.clone(),
    };
    found.warnings = stream.warnings.iter().map(told).collect();
    console.result(&found, text)
}

fn text(found: &MotionStreamInspection) -> String {
    let mut text = head_line(&found.file, found.format, found.bytes, &found.clip);
    text.push_str(&format!(
        "motion stream {}: {} frames at {} fps, {:.3} s, {}, head of {} bytes\n",
        found.profile,
        found.frames,
        found.fps,
        found.duration_secs,
        found.access_units,
        found.bytes_head,
    ));
    let morphs = match found.morph_targets {
        0 => String::new(),
        count => format!(" and {}", counted(count, "morph target", "morph targets")),
    };
    let skeleton = if found.skeleton {
        ", whose skeleton it carries"
    } else {
        ""
    };
    text.push_str(&format!(
        "for {}{morphs}{skeleton}; `lod {} --onto CHARACTER` measures errors\n\n",
        counted(found.joints, "joint", "joints"),
        clean(&found.file),
    ));
    text.push_str(&tables(found));
    text.push_str(&mp4::text(&found.tracks));
    text.push_str(&warnings_text(&found.warnings));
    text
}

/// Formats the tables of tiers and groups.
pub(super) fn tables(found: &MotionStreamInspection) -> String {
    let mut text = String::from("cut to a tier\n");
    let mut tiers = Table::new(&["tier", "tolerance mm", "bytes"]);
    for tier in &found.tiers {
        tiers.row([
            tier.tier.to_string(),
            format!("{:.1}", tier.tolerance_mm),
            tier.bytes.to_string(),
        ]);
    }
    text.push_str(&tiers.text());
    text.push_str("\nbytes of the units of each group\n");
    let names: Vec<String> = (0..found.tiers.len())
        .map(|t| format!("tier {t}"))
        .collect();
    let mut columns = vec!["", "LoA", "region", "joint"];
    columns.extend(names.iter().map(String::as_str));
    let mut groups = Table::new(&columns);
    for group in &found.groups {
        let mut cells = vec![
            if group.is_face { "face" } else { "body" }.to_owned(),
            group.loa.to_string(),
            group.region.clone().unwrap_or_default(),
            group
                .joint
                .map_or_else(String::new, |joint| joint.to_string()),
        ];
        cells.extend(group.bytes.iter().map(usize::to_string));
        groups.row(cells);
    }
    text.push_str(&groups.text());
    text
}
