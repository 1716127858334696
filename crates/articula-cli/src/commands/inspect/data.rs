//! MPEG-4 files without a character: parameters that move, their ranges and units.

use super::text::{head_line, warnings_text};
use super::{access_units, motion_stream, mp4};
use crate::arguments::CharacterArgs;
use crate::console::Console;
use crate::open;
use crate::table::Table;
use crate::{fault, files};
use articula::DataFormat;
use articula::clip_streams::StreamKind;
use articula::inspect::{
    DataInspection, FaceStreamInspection, inspect_access_units, inspect_data, inspect_motion_stream,
};
use articula::stream::StreamLimits;

/// Reads the file and prints its contents.
pub(super) fn run(
    args: &CharacterArgs,
    format: DataFormat,
    map: bool,
    console: &Console,
) -> anyhow::Result<()> {
    if args.leaves_out() {
        return Err(fault::usage(format!(
            "--hide and --only choose meshes; a .{} file has none",
            format.name()
        )));
    }
    let opened = open::data(&args.file, format, &args.names)?;
    let mut found = inspect_data(opened, &files::shown(&args.file), format);
    if matches!(format, DataFormat::Afp | DataFormat::Mp4) {
        let stream = open::stream(&args.file, true)?;
        let (name, limits) = (files::shown(&args.file), StreamLimits::default());
        found.stream = match stream.kind {
            Some(StreamKind::Afp2) => {
                let stream = inspect_motion_stream(&stream.bytes, &name, &limits)?;
                Some(FaceStreamInspection::Afp2(Box::new(stream)))
            }
            Some(StreamKind::Fba) => None,
            _ => {
                let stream = inspect_access_units(&stream.bytes, &name, &limits)?;
                Some(FaceStreamInspection::Afp1(stream))
            }
        };
    }
    found.tracks = open::tracks(&args.file)?;
    console.result(&found, |found| text(found, map))
}

fn text(found: &DataInspection, map: bool) -> String {
    let mut text = head_line(&found.file, found.format, found.bytes, &found.name);
    for clip in &found.clips {
        text.push_str(&format!(
            "{} frames at {} fps, {:.3} s\n",
            clip.frames, clip.fps, clip.duration_secs
        ));
    }
    if let Some(units) = &found.fapu {
        text.push_str(&format!(
            "units of the face: ENS0 {}, ES0 {}, IRISD0 {}, MNS0 {}, MW0 {}\n{} feature points\n",
            units.ens0,
            units.es0,
            units.irisd0,
            units.mns0,
            units.mw0,
            found.points.len()
        ));
    }
    if let Some(coding) = &found.coding {
        text.push_str(&format!(
            "{} frames, {} of them intra; face in {}, body in {}\n",
            coding.frames, coding.intra, coding.face, coding.body
        ));
        if let Some(fps) = coding.fps {
            text.push_str(&format!("{fps} fps\n"));
        }
    }
    if let Some(face) = &found.face {
        text.push_str(&format!(
            "\nface: {} facial animation parameters\n",
            face.faps
        ));
    }
    if !found.groups.is_empty() {
        let mut table = Table::new(&["group", "in masks", "moving"]);
        for group in &found.groups {
            table.row([
                group.name.to_owned(),
                group.faps.to_string(),
                group.moving.to_string(),
            ]);
        }
        text.push_str(&table.text());
    }
    if !found.shapes.is_empty() {
        let moves = found.shapes.iter().filter(|s| s.min != s.max).count();
        text.push_str(&format!(
            "\nface: {} blend shapes, {moves} of them move\n",
            found.shapes.len()
        ));
    }
    match &found.stream {
        Some(FaceStreamInspection::Afp1(stream)) => {
            text.push_str(&access_units::text(stream, "parameters"));
        }
        Some(FaceStreamInspection::Afp2(stream)) => {
            text.push_str(&format!(
                "\nstream {}: {}, head of {} bytes\n",
                stream.profile, stream.access_units, stream.bytes_head,
            ));
            text.push_str(&motion_stream::tables(stream));
        }
        None => {}
    }
    if map && !found.shapes.is_empty() {
        let mut table = Table::new(&["blend shape", "min", "max"]);
        for shape in &found.shapes {
            let [min, max] = [shape.min, shape.max].map(|v| format!("{v:.3}"));
            table.row([shape.name.to_owned(), min, max]);
        }
        text.push_str(&format!("\nblend shapes\n{}", table.text()));
    } else if map {
        text.push_str(&format!("\nparameters\n{}", parameters(found).text()));
    }
    text.push_str(&mp4::text(&found.tracks));
    text.push_str(&warnings_text(&found.warnings));
    text
}

fn parameters(found: &DataInspection) -> Table {
    let mut table = Table::new(&["FAP", "name", "unit", "min", "max", "moves"]);
    let number = |value: Option<i32>| value.map_or_else(|| "-".to_owned(), |v| v.to_string());
    for p in &found.parameters {
        table.row([
            p.fap.to_string(),
            p.name.to_owned(),
            p.unit.as_deref().unwrap_or("-").to_owned(),
            number(p.min),
            number(p.max),
            if p.moves { "yes" } else { "no" }.to_owned(),
        ]);
    }
    table
}
