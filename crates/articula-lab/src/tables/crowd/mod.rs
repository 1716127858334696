//! Cost of a crowd, measured in one run: Articula, the floor and other evaluators.
//!
//! Source: `docs/methods/runtime.md` parts 1 and 4, thesis 6.3.1. One module for each section of
//! the page; every section adds to one [`CrowdTables`]. All times are processor time of one thread.

mod access;
mod evaluation;
mod frame_order;
mod joints;
mod ours;
mod plaza;
mod ranks;
mod screen_error;
mod skinning;
mod stage;
mod threads;

use super::Run;
use super::targets::{self, Target};
use crate::data;
use crate::measure::Timing;
use anyhow::{Context, Result};
use articula_build::Asset;
use articula_build::{Plaza, plaza};
use articula_core::crowd::Crowd;
use articula_core::{Backend, Clip};
use stage::SceneBench;
use std::path::PathBuf;

const FILE: &str = "glb/pab_arnaud.glb";
const CLIP: &str = "walk";
const SEED: u64 = 1;
/// Clips of a small run, that which is measured among them.
const FEW_CLIPS: usize = 2;

/// Inputs of every section.
struct Bench {
    asset: Asset,
    /// Index of the clip.
    clip: usize,
    /// The character as a crowd, for sections with scenes.
    scenes: SceneBench,
    /// The file, for evaluators that open it themselves.
    file: PathBuf,
    small: bool,
}

impl Bench {
    fn clip(&self) -> &Clip {
        &self.asset.clips[self.clip]
    }

    /// Number of rounds of a race.
    fn rounds(&self) -> usize {
        if self.small { 2 } else { 21 }
    }

    /// Numbers of characters, each with the number of frames per round.
    fn counts(&self) -> Vec<(usize, usize)> {
        if self.small {
            vec![(100, 2)]
        } else {
            vec![(100, 160), (1000, 16), (4000, 4)]
        }
    }

    /// The middle number of characters, for sections that vary something else.
    fn usual(&self) -> (usize, usize) {
        if self.small { (100, 2) } else { (1000, 16) }
    }

    /// Phase in the clip at which each character starts, 0 to 1.
    fn phases(&self, count: usize) -> Vec<f32> {
        let members = plaza(count, &[1], SEED, Plaza::Still).members;
        members.iter().map(|m| m.play.phase).collect()
    }
}

/// The page, its CSV file and its plots, filled by the sections.
#[derive(Default)]
struct CrowdTables {
    page: String,
    csv: String,
    plots: Vec<(&'static str, String)>,
    targets: Vec<Target>,
}

/// One row of the CSV file.
struct Line<'a> {
    section: &'a str,
    who: &'a str,
    count: usize,
    /// Property that the section varies.
    variant: &'a str,
    timing: Timing,
    /// Time of the floor with which the row is compared.
    floor_ns: f64,
}

impl CrowdTables {
    fn heading(&mut self, title: &str, text: &str) {
        self.page.push_str(&format!("\n## {title}\n\n{text}\n\n"));
    }

    fn row(&mut self, cells: &[String]) {
        self.page.push_str(&format!("| {} |\n", cells.join(" | ")));
    }

    fn head(&mut self, cells: &[&str]) {
        let cells: Vec<String> = cells.iter().map(|c| (*c).to_owned()).collect();
        self.row(&cells);
        self.row(&vec!["---".to_owned(); cells.len()]);
    }

    fn at_most(&mut self, who: &str, what: &str, most: f64, found: f64) {
        self.targets.push(Target::at_most([who, what], most, found));
    }

    fn at_least(&mut self, who: &str, what: &str, least: f64, found: f64) {
        let target = Target::at_least([who, what], least, found);
        self.targets.push(target);
    }

    fn line(&mut self, line: &Line<'_>) {
        let Timing {
            median_ns,
            least_ns,
        } = line.timing;
        let ratio = median_ns / line.floor_ns;
        self.csv.push_str(&format!(
            "{},{},{},{},{median_ns:.1},{least_ns:.1},{ratio:.3}\n",
            line.section,
            line.who.replace(',', ";"),
            line.count,
            line.variant
        ));
    }
}

/// Runs all sections and writes the page.
pub(crate) fn write(run: &Run) -> Result<()> {
    let mut asset = data::asset_on_the_spot(&run.data, FILE)?;
    if run.small {
        asset.clips.truncate(FEW_CLIPS);
    }
    let clip = asset.clips.iter().position(|c| c.name == CLIP);
    let bench = Bench {
        clip: clip.with_context(|| format!("{FILE} has no clip called {CLIP}"))?,
        scenes: SceneBench::new(asset.clone())?,
        asset,
        file: run.data.join(FILE),
        small: run.small,
    };
    let mut report = CrowdTables {
        csv: "section,who,characters,variant,median_ns,least_ns,ratio_to_floor\n".to_owned(),
        ..CrowdTables::default()
    };
    let state_bytes = Crowd::BYTES_PER_CHARACTER as f64;
    report.at_most("state", "bytes per character", 64.0, state_bytes);
    evaluation::add(&bench, &mut report)?;
    access::add(&bench, &mut report)?;
    joints::add(&bench, &mut report)?;
    skinning::add(&bench, &mut report)?;
    let ours = plaza::add(&bench, &mut report)?;
    threads::add(&bench, &mut report)?;
    ranks::add(&bench, &mut report, &ours)?;
    for (name, svg) in &report.plots {
        run.save_text(name, "svg", svg)?;
    }
    let head = format!(
        "# Cost of a crowd\n\n{HEAD} {} joints, {} frames at {} Hz; Articula's batches run on {}.\n",
        bench.asset.rig.len(),
        bench.clip().frames(),
        bench.clip().rate_hz(),
        Backend::best(),
    );
    let targets = targets::section(TARGETS, &["what", "quantity"], &report.targets);
    run.save("crowd", &(head + &targets + &report.page), &report.csv)
}

const TARGETS: &str = "The bounds of docs/methods/runtime.md, part 4; those in milliseconds and nanoseconds are for the
class of machine named there.";

const HEAD: &str = "Made by `cargo run --release -p articula-lab -- crowd`. Nanoseconds of processor time of one thread
per character and frame: the median over rounds in which all evaluators take turns, in brackets the
minimum. Times of one run are comparable, times of two runs are not. The *floor* is a minimal evaluator
without scales, blending, looping and levels (docs/methods/runtime.md, part 3). *Quoted* figures were
measured on another machine and are divided by the floor of that machine. `pab_arnaud.glb`, clip `walk`,
distinct phases, 1/60 s from frame to frame;";
