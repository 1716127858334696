//! Mesh levels: errors and bytes, beside other simplifiers and codecs.
//!
//! Source: `docs/methods/clustered-mesh.md` parts 9 and 10. One module for each section of the
//! page.

mod characters;
mod contestants;
mod errors;
mod page;
mod progressive;
mod sheet;
mod sizes;
mod targets;

use super::Run;
use crate::peers::draco;
use anyhow::Result;
use articula_build::SkinPoseSource;
use articula_build::{SimplifyOptions, simplify};
use articula_report::thread_ns;
use characters::{CHARACTERS, Entry, PICTURED, SMALL};
use contestants::{Contestant, Posed};
use sheet::Extent;
use std::path::PathBuf;

/// Fractions of the triangles in coding order, coarsest first, as in all lists of levels here.
/// Written files number levels from the finest, 0.
const SHARES: [&str; 5] = ["1.5 %", "10 %", "25 %", "50 %", "100 %"];

/// The level of 25 % of the triangles, to which a target applies.
const QUARTER: usize = 2;

/// Number of poses for measuring.
const POSES: usize = 24;
/// Number of rounds, of which the minimum time is kept.
const ROUNDS: usize = 3;
/// Number of poses of a small run.
const SMALL_POSES: usize = 6;

/// The part of the table to run.
#[derive(clap::Args, Default)]
pub(crate) struct Choice {
    /// Run only characters whose names contain this text.
    #[arg(long)]
    only: Option<String>,
    /// Folder for a sheet of each character at every level.
    #[arg(long)]
    sheets: Option<PathBuf>,
    /// File for the picture of the page.
    #[arg(long)]
    picture: Option<PathBuf>,
}

/// Results of one character.
struct Found {
    name: &'static str,
    /// Source of its poses.
    source: SkinPoseSource,
    /// Number of poses for measuring.
    poses: usize,
    /// Nominal height, metres.
    height_metres: f32,
    /// Seconds of one thread for simplification by Articula, without the tables of poses.
    simplify_secs: f64,
    errors: Vec<errors::Row>,
    sizes: sizes::Sizes,
}

/// Runs the table and writes it.
pub(crate) fn write(run: &Run, choice: &Choice) -> Result<()> {
    let shown = |e: &&Entry| match &choice.only {
        Some(only) => e.name.contains(only.as_str()),
        None => !run.small || e.name == SMALL,
    };
    let mut all = Vec::new();
    for entry in CHARACTERS.iter().filter(shown) {
        all.push(found(run, entry, choice)?);
    }
    if all
        .iter()
        .any(|f| f.sizes.levels.iter().any(|l| l.draco.is_none()))
    {
        println!("skipped: {}", draco::MISSING);
    }
    run.save("mesh-levels", &page::page(&all)?, &page::errors_csv(&all)?)?;
    run.save_csv("mesh-levels-bytes", &page::bytes_csv(&all)?)
}

fn found(run: &Run, entry: &Entry, choice: &Choice) -> Result<Found> {
    let (poses, rounds) = if run.small {
        (SMALL_POSES, 1)
    } else {
        (POSES, ROUNDS)
    };
    let subject = entry.open(&run.data)?;
    let posed = Posed::of(&subject, poses)?;
    let opts = SimplifyOptions::default();
    let start = thread_ns();
    let mut ours = simplify(&subject.asset.mesh, &posed.shaping, &opts)?.levels;
    let simplify_secs = 1e-9 * (thread_ns() - start) as f64;
    ours.reverse();
    if let Some(folder) = &choice.sheets {
        std::fs::create_dir_all(folder)?;
        let path = folder.join(subject.name.replace([' ', ','], "_"));
        let path = path.with_extension("png");
        sheet::write(&subject, &posed, &ours, Extent::Full, &path)?;
    }
    if let Some(path) = choice.picture.as_ref().filter(|_| entry.name == PICTURED) {
        sheet::write(&subject, &posed, &ours, Extent::Page, path)?;
    }
    Ok(Found {
        name: subject.name,
        source: posed.source,
        poses: posed.measuring.len(),
        height_metres: subject.told_height_metres,
        simplify_secs,
        errors: errors::rows(&subject, &posed, &ours, &Contestant::ALL)?,
        sizes: sizes::sizes(&subject, &ours, rounds)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data;

    /// A real character meets the targets of the page; Draco's sizes are checked where node is
    /// available.
    #[test]
    fn a_real_character_holds_the_targets() {
        let Some(data) = data::folder(None, true).unwrap() else {
            println!("skipped: no data");
            return;
        };
        let run = Run {
            data,
            out: PathBuf::new(),
            small: true,
        };
        let entry = CHARACTERS.iter().find(|e| e.name == SMALL).unwrap();
        let found = found(&run, entry, &Choice::default()).unwrap();
        let error = found.ratio(QUARTER).unwrap();
        assert!(
            error < 0.6,
            "{error} of meshoptimizer's error in motion at 25 %"
        );
        assert!(found.to_meshopt().unwrap() < 0.6);
        assert!(
            found.to_own().unwrap() < 1.35,
            "target of docs/methods/clustered-mesh.md"
        );
        if let Some(draco) = found.to_draco() {
            assert!(
                draco < 1.1,
                "target of docs/methods/clustered-mesh.md, found {draco}"
            );
            assert!(found.to_draco_levels().unwrap() < 0.55);
        }
        // Triangles decrease, and levels with more triangles are closer to the original.
        for level in 1..SHARES.len() - 1 {
            let row = |l| found.row(Contestant::Ours, l).unwrap();
            assert!(row(level).triangles > row(level - 1).triangles);
            assert!(row(level).motion.max < row(level - 1).motion.max);
            assert!(row(level).motion.mean < row(level - 1).motion.mean);
        }
    }
}
