//! Evaluation runs of Articula, one subcommand for each published table.
//!
//! Results are written to `docs/results` as a Markdown page and a CSV file; all their numbers
//! come from one run of the command named at the head of the page.

#![allow(
    clippy::print_stderr,
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

use anyhow::{Context, Result};
use clap::{CommandFactory, Parser, Subcommand};
use std::path::PathBuf;
use std::time::Instant;
use tables::crowd_characters;
use tables::crowd_scene;
use tables::devices;
use tables::flat;
use tables::impostors;
use tables::merged_levels::Sheets;
use tables::mesh_levels::Choice;
use tables::optimize;
use tables::retargets::Pictures;
use tables::sessions;

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
    /// Bytes and time of levels of articulation, by zone, depth and complexity (the thesis' 6.3.1).
    LoaCost,
    /// Cost of a crowd beside the floor and other evaluators (docs/methods/runtime.md).
    Crowd,
    /// What a crowd of anybody costs: preparation, the whole frame and budgets, character by character.
    CrowdCharacters(crowd_characters::Choice),
    /// Impostors and far levels beside near levels, at equal error.
    Impostors(impostors::Sheet),
    /// Error of a crowd at one pixel, for every character of the data.
    CrowdErrors,
    /// A mixed scene under one budget: several characters, two views, walls and roles.
    CrowdScene(crowd_scene::Choice),
    /// Contents of every data file, and round trips through every writer.
    RoundTrips,
    /// Quality of retargeted motions of every kind on characters of every kind.
    Retargets(Pictures),
    /// Error of merged levels by joints kept, also on clips not used for the joint order.
    MergedLevels(Sheets),
    /// Mesh levels: error in motion, bytes and speed, beside meshoptimizer and Draco.
    MeshLevels(Choice),
    /// Lighter files: bytes at equal error in motion, beside other optimisers.
    Optimize(optimize::Choice),
    /// Levels of articulation of faces: parameters, errors and time (the thesis' 3.1.3 and 6.1).
    FaceLevels,
    /// Mesh levels of faces: feature points that survive, and errors while the face moves.
    FaceMeshLevels,
    /// Conversion to 2D: bytes and errors of every profile, beside the thesis' form.
    Flat(flat::Choice),
    /// Facial animation parameters on portraits, beside the projected head (the thesis' annex C).
    PortraitParameters,
    /// Faces without a graphics card: three meshes beside two portraits (the thesis' table 6.6).
    PortraitTimes,
    /// Blend shapes through facial animation parameters: what is lost.
    FaceBridges,
    /// Feature points of faces: errors on random heads with landmarks.
    FacePoints,
    /// Face animation tables made from feature points alone, beside the expressions of the faces.
    FaceTables,
    /// Blend shapes made for heads whose own were taken away, beside these.
    MadeShapes(tables::made_shapes::Choice),
    /// Visemes of a voice beside other libraries; with `train` the network that hears them.
    Speech(tables::speech::Choice),
    /// Motion streams: bytes at equal error beside other forms, layers and speeds.
    Streams,
    /// Digital items: the joint choice beside cuts of single parts, sizes and costs of levels.
    Adaptation,
    /// A server under load: many sessions and their latency, objects beside nginx.
    Sessions(sessions::Choice),
    /// The bandwidth of a client changes while it plays: what it shows, and how soon.
    Slider(devices::Builds),
    /// Frame rates on unlike devices made of this machine, and which tests predict an application.
    Devices(devices::Builds),
    /// All tables, one after the other; names and times go to standard error.
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
        Table::All => all(&run),
        table => one(&run, &table),
    }
}

/// Runs one table.
fn one(run: &tables::Run, table: &Table) -> Result<()> {
    match table {
        Table::MotionLod => tables::motion_lod::write(run),
        Table::ThesisGrid => tables::thesis_grid::write(run),
        Table::LoaCost => tables::loa_cost::write(run),
        Table::Crowd => tables::crowd::write(run),
        Table::CrowdCharacters(choice) => crowd_characters::write(run, choice),
        Table::CrowdErrors => tables::crowd_errors::write(run),
        Table::CrowdScene(choice) => crowd_scene::write(run, choice),
        Table::Impostors(sheets) => impostors::write(run, sheets),
        Table::MergedLevels(sheets) => tables::merged_levels::write(run, sheets),
        Table::MeshLevels(choice) => tables::mesh_levels::write(run, choice),
        Table::Optimize(choice) => optimize::write(run, choice),
        Table::FaceLevels => tables::face_levels::write(run),
        Table::FaceMeshLevels => tables::face_mesh_levels::write(run),
        Table::Flat(choice) => flat::write(run, choice),
        Table::RoundTrips => tables::round_trips::write(run),
        Table::Retargets(pictures) => tables::retargets::write(run, pictures),
        Table::PortraitParameters => tables::portrait_parameters::write(run),
        Table::PortraitTimes => tables::portrait_times::write(run),
        Table::FaceBridges => tables::face_bridges::write(run),
        Table::FacePoints => tables::face_points::write(run),
        Table::FaceTables => tables::face_tables::write(run),
        Table::MadeShapes(choice) => tables::made_shapes::write(run, choice),
        Table::Speech(choice) => tables::speech::write(run, choice),
        Table::Streams => tables::streams::write(run),
        Table::Adaptation => tables::adaptation::write(run),
        Table::Sessions(choice) => sessions::write(run, choice),
        Table::Slider(builds) => tables::slider::write(run, builds),
        Table::Devices(builds) => devices::write(run, builds),
        Table::All => all(run),
    }
}

/// Runs every table, and reports each one's name and time.
fn all(run: &tables::Run) -> Result<()> {
    let names = every_table();
    let (count, start) = (names.len(), Instant::now());
    for (i, name) in names.iter().enumerate() {
        let begun = Instant::now();
        eprintln!("{} of {count}: {name}", i + 1);
        let table = Arguments::try_parse_from(["articula-lab", name])?.table;
        one(run, &table).with_context(|| name.clone())?;
        let (secs, since) = (begun.elapsed().as_secs(), start.elapsed().as_secs());
        eprintln!(
            "{} of {count}: {name} took {secs} s, {since} s so far",
            i + 1
        );
    }
    Ok(())
}

/// Names of all subcommands that make a table, in the order in which they are declared.
fn every_table() -> Vec<String> {
    let command = Arguments::command();
    let names = command.get_subcommands().map(|c| c.get_name().to_owned());
    names.filter(|name| name != ALL).collect()
}

/// Name of the subcommand that runs all others.
const ALL: &str = "all";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_runs_every_table_that_has_a_page() {
        let results = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/results");
        let names = every_table();
        assert!(!names.iter().any(|name| name == ALL));
        for page in std::fs::read_dir(results).unwrap() {
            let path = page.unwrap().path();
            let stem = path.file_stem().unwrap().to_str().unwrap();
            if path.extension().is_none_or(|e| e != "md") || NOT_OF_THE_LAB.contains(&stem) {
                continue;
            }
            assert!(
                names.iter().any(|n| n == stem),
                "{stem} is not in {names:?}"
            );
        }
        for name in &names {
            let words = ["articula-lab", name];
            assert!(Arguments::try_parse_from(words).is_ok(), "{name}");
        }
    }

    /// Pages made by chores of `cargo xtask`, and the list of pages.
    const NOT_OF_THE_LAB: [&str; 5] = ["fuzz", "mutants", "web", "web-sizes", "README"];
}
