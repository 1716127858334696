//! `lod walk.abp --onto FIGURE`: what leaving out parts of a motion stream costs.

use super::LodArgs;
use crate::console::Console;
use crate::fault::{self, clean};
use crate::table::{Table, warnings};
use crate::{files, open};
use articula::evaluate::{LayerOptions, LayerReport, LayersReport, layers};
use articula::{Figure, Format};
use std::path::Path;

/// Whether a file is named as a stream of a motion, or is an MP4 file whose first stream is one.
pub(super) fn is_one(path: &Path) -> anyhow::Result<bool> {
    Ok(match files::format(path) {
        Some(Format::Abp) => true,
        Some(Format::Mp4) => open::data_format(path)?.is_none(),
        _ => false,
    })
}

/// Measures every cut and prints the report.
pub(super) fn run(args: &LodArgs, character: &Path, console: &Console) -> anyhow::Result<()> {
    let path = &args.character.file;
    let name = files::shown(path);
    if args.calibrate.is_some() || args.fap().is_some() {
        return Err(fault::usage(format!(
            "{name}: --calibrate and --write fap choose parameters of a face; a motion stream has none"
        )));
    }
    args.check_distances()?;
    let inputs = args.character.inputs().chain([character]);
    console.files.plan(inputs, None)?;
    let stream = open::stream(path, false)?;
    let mut opened = open::character(&console.files, character, &args.character.names)?;
    opened.keep_meshes(&args.character.only, &args.character.hide)?;
    let figure = Figure::new(opened)?;
    let options = LayerOptions {
        distances_m: args.distances().to_vec(),
        viewport: args.view.viewport(),
    };
    let mut report = console.work(|work| layers(&stream.bytes, &name, &figure, &options, work))?;
    report.warnings.extend(open::warnings(&stream.warnings));
    console.result(&report, text)
}

fn text(found: &LayersReport) -> String {
    let every = match found.every {
        1 => String::new(),
        n => format!(", every {n}th measured"),
    };
    let mut text = format!(
        "{} on {}: clip \"{}\", {} bytes, within {} mm; {} frames at {} Hz{every}, {} vertices\n",
        clean(&found.file),
        clean(&found.character),
        clean(&found.clip),
        found.bytes,
        found.tolerance_mm,
        found.frames,
        found.rate_hz,
        found.vertices,
    );
    let tables = [
        ("cut to a tier", "tier", &found.tiers),
        ("cut to levels of articulation", "up to LoA", &found.levels),
        (
            "one group cut to a tier, or left out",
            "group",
            &found.groups,
        ),
    ];
    for (title, column, rows) in tables {
        let distances = found.distances_m.iter().map(|m| format!("px at {m} m"));
        let columns: Vec<String> = [column, "bytes", "max error mm", "mean error mm"]
            .into_iter()
            .map(str::to_owned)
            .chain(distances)
            .chain(["worst vertex".to_owned()])
            .collect();
        let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
        let mut table = Table::new(&columns);
        for row in rows {
            table.row(cells(row, column));
        }
        text.push_str(&format!("\n{title}\n{}", table.text()));
    }
    text.push_str(&warnings(&found.warnings));
    text
}

fn cells(row: &LayerReport, column: &str) -> Vec<String> {
    let tier = row
        .finest_tier
        .map_or_else(|| "none".to_owned(), |tier| tier.to_string());
    let loa = row.loa.map_or_else(String::new, |loa| loa.to_string());
    let name = match column {
        "tier" => tier,
        "group" => {
            let parts = [row.region.as_deref(), row.joint.as_deref()];
            let parts = parts.into_iter().flatten().map(clean);
            let group: Vec<String> = std::iter::once(format!(
                "{}LoA {loa}",
                if row.is_face { "face " } else { "" }
            ))
            .chain(parts)
            .collect();
            format!("{}, tier {tier}", group.join(" "))
        }
        _ => loa,
    };
    let worst = row.worst.as_ref().map_or_else(String::new, |worst| {
        format!(
            "{} ({}, {:.2} s)",
            worst.vertex,
            clean(&worst.joint),
            worst.at_secs
        )
    });
    let mut cells = vec![
        name,
        row.bytes.to_string(),
        format!("{:.3}", row.error_mm_max),
        format!("{:.4}", row.error_mm_mean),
    ];
    cells.extend(row.px.iter().map(|px| format!("{px:.2}")));
    cells.push(worst);
    cells
}
