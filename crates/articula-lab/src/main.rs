//! Evaluation runs of Articula, one subcommand for each published table.
//!
//! Results are written to `docs/results` as a Markdown page and a CSV file; all their numbers
//! come from one run of the command named at the head of the page.

#![allow(
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a program that reads files, writes files and reports"
)]

mod data;
mod measure;
mod open;
mod peers;
#[cfg(test)]
mod small;
mod subdivide;
mod tables;
mod wire_mesh;

use anyhow::Result;
use clap::{Parser, Subcommand};
use std::path::PathBuf;
use tables::flat;
use tables::merged_levels::Sheets;
use tables::mesh_levels::Choice;
use tables::retargets::Pictures;

/// Evaluation runs of Articula.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    #[command(subcommand)]
    table: Table,
    /// Folder of the real characters [default: `ARTICULA_DATA` or `../shared/data`].
    #[arg(long, global = true)]
    data: Option<PathBuf>,
    /// Folder for the pages and CSV files.
    #[arg(long, global = true, default_value = "docs/results")]
    out: PathBuf,
    /// Quick run: one clip instead of four, small files only.
    #[arg(long, global = true)]
    small: bool,
}

#[derive(Subcommand)]
enum Table {
    /// Joint-update gain of every method at one pixel, over distance (docs/methods/motion-lod.md,
    /// part 11).
    MotionLod,
    /// Gain over distance, threshold and beta (the thesis' table 6.8).
    ThesisGrid,
    /// Cost of a crowd beside the floor and other evaluators (docs/methods/runtime.md).
    Crowd,
    /// Contents of every data file, and round trips through every writer.
    RoundTrips,
    /// Quality of retargeted motions of every kind on characters of every kind.
    Retargets(Pictures),
    /// Error of merged levels by joints kept, also on clips not used for the joint order.
    MergedLevels(Sheets),
    /// Mesh levels: error in motion, bytes and speed, beside meshoptimizer and Draco.
    MeshLevels(Choice),
    /// Conversion to 2D: bytes and errors of every profile, beside the thesis' form.
    Flat(flat::Choice),
    /// All tables.
    All,
}

fn main() -> Result<()> {
    run(Arguments::parse())
}

fn run(arguments: Arguments) -> Result<()> {
    let Some(data) = data::folder(arguments.data.as_deref(), arguments.small)? else {
        println!("skipped: no data (see docs/data.md; --small runs on the repository's own files)");
        return Ok(());
    };
    let run = tables::Run {
        data,
        out: arguments.out,
        small: arguments.small,
    };
    match arguments.table {
        Table::MotionLod => tables::motion_lod::write(&run),
        Table::ThesisGrid => tables::thesis_grid::write(&run),
        Table::Crowd => tables::crowd::write(&run),
        Table::MergedLevels(sheets) => tables::merged_levels::write(&run, &sheets),
        Table::MeshLevels(choice) => tables::mesh_levels::write(&run, &choice),
        Table::Flat(choice) => flat::write(&run, &choice),
        Table::RoundTrips => tables::round_trips::write(&run),
        Table::Retargets(pictures) => tables::retargets::write(&run, &pictures),
        Table::All => {
            tables::crowd::write(&run)?;
            tables::round_trips::write(&run)?;
            tables::retargets::write(&run, &Pictures::default())?;
            tables::motion_lod::write(&run)?;
            tables::thesis_grid::write(&run)?;
            tables::merged_levels::write(&run, &Sheets::default())?;
            tables::mesh_levels::write(&run, &Choice::default())?;
            flat::write(&run, &flat::Choice::default())
        }
    }
}
