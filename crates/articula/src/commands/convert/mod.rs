//! `articula convert IN... OUT`: between formats, and to a reduced animation; one file or many.

mod job;
mod plan;
mod reduction;
mod report;
mod written;

use crate::arguments::ReadArgs;
use crate::console::Console;
use crate::load::{self, Format};
use crate::play::saved;
use crate::table::counted;
use crate::{fault, files};
use articula_core::joint_state::PassivePolicy;
use clap::Args;
use indicatif::ProgressBar;
use plan::{Job, Plan};
use rayon::prelude::*;
use report::{Batch, Failure, Report};
use std::path::PathBuf;

/// Arguments of `convert`.
#[derive(Debug, Args)]
pub(crate) struct ConvertArgs {
    /// Files to read (.glb, .gltf, .vrm, .vrma, .bvh, ...), or folders of them
    #[arg(value_name = "IN", required = true)]
    inputs: Vec<PathBuf>,
    /// File to write; its extension names the format (.glb, .vrm, .vrma, .bvh, ...). Or the
    /// folder that receives one file for each that is read
    out: PathBuf,
    /// Format of the files in an output folder [default: glb]
    #[arg(long, value_name = "FORMAT", value_parser = format)]
    to: Option<Format>,
    /// Keep this clip alone [default: all; .bvh the first]
    #[arg(long, value_name = "NAME")]
    clip: Option<String>,
    /// Joints that may move, such as "loa(Low) + zone(hands)"; the others are held
    #[arg(long, value_name = "EXPR")]
    loa: Option<String>,
    /// Let every joint above one that may move, move too
    #[arg(long)]
    close_up: bool,
    /// The same from a saved selection
    #[arg(long, value_name = "F.json", conflicts_with = "loa")]
    loa_profile: Option<PathBuf>,
    /// What held joints show: hold, rest, key-pose, blend-to-rest:SECS [default: key-pose]
    #[arg(long, value_name = "POLICY", value_parser = saved::passive)]
    passive: Option<PassivePolicy>,
    #[command(flatten)]
    names: ReadArgs,
}

/// Reads, reduces if asked to, and writes.
pub(crate) fn run(args: &ConvertArgs, console: &Console) -> anyhow::Result<()> {
    args.check()?;
    let plan = Plan::of(args)?;
    let bar = console.progress("converting", plan.inputs());
    match &plan.folder {
        None => {
            let report = job::run(&plan.jobs[0], args)?;
            bar.finish_and_clear();
            console.result(&report, Report::text)
        }
        Some(folder) => {
            let done = all(&plan.jobs, args, &bar);
            bar.finish_and_clear();
            folder_report(files::shown(folder), done, &plan.jobs, console)
        }
    }
}

/// Runs every job whatever becomes of the others; the order is that of the jobs.
fn all(jobs: &[Job], args: &ConvertArgs, bar: &ProgressBar) -> Vec<anyhow::Result<Report>> {
    let one = |job: &Job| {
        let done = job::run(job, args);
        bar.inc(job.inputs.len() as u64);
        done
    };
    jobs.par_iter().map(one).collect()
}

/// Says what was written, then what was not and why.
fn folder_report(
    out: String,
    done: Vec<anyhow::Result<Report>>,
    jobs: &[Job],
    console: &Console,
) -> anyhow::Result<()> {
    let mut batch = Batch {
        out,
        files: Vec::new(),
        failed: Vec::new(),
    };
    let mut faults = Vec::new();
    for (job, done) in jobs.iter().zip(done) {
        match done {
            Ok(report) => batch.files.push(report),
            Err(fault) => {
                let path = &job.inputs[0].path;
                batch.failed.push(Failure::new(path, &fault));
                faults.push(fault);
            }
        }
    }
    console.result(&batch, Batch::text)?;
    ended(&faults, jobs.len(), console)
}

/// One line for each fault, and an error if there is any.
fn ended(faults: &[anyhow::Error], files: usize, console: &Console) -> anyhow::Result<()> {
    if faults.is_empty() {
        return Ok(());
    }
    for fault in faults {
        console.fault(fault);
    }
    let files = counted(files, "file", "files");
    anyhow::bail!("{} of {files} failed; the others are done", faults.len())
}

fn format(name: &str) -> Result<Format, String> {
    Format::of_extension(name).ok_or_else(|| format!("converted are {}", load::conversions()))
}

impl ConvertArgs {
    fn check(&self) -> anyhow::Result<()> {
        let reduces = self.loa.is_some() || self.loa_profile.is_some();
        if (self.passive.is_some() || self.close_up) && !reduces {
            return Err(fault::usage(
                "--passive and --close-up need --loa EXPR or --loa-profile F.json",
            ));
        }
        Ok(())
    }
}
