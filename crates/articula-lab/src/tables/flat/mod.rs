//! Conversion to 2D: size and error of each profile, beside the thesis' form.
//!
//! Source: `docs/methods/vector.md` parts 4, 9 and 10. One module for each section of the page.

mod cases;
mod orders;
mod page;
mod portraits;
mod profiles;
mod targets;

use super::Run;
use anyhow::Result;
use cases::{CASES, Case};
use std::path::PathBuf;

/// The part of the table to run.
#[derive(clap::Args, Default)]
pub(crate) struct Choice {
    /// Run only cases whose names contain this text.
    #[arg(long)]
    only: Option<String>,
    /// Folder for the written files and pictures of them.
    #[arg(long)]
    files: Option<PathBuf>,
}

/// Results of one case.
struct Found {
    case: Case,
    /// Names of the meshes of the file that are not drawn.
    hidden: Vec<String>,
    frames: usize,
    triangles: usize,
    orders: orders::Orders,
    profiles: Vec<profiles::Row>,
    stills: profiles::Stills,
}

/// Runs the table and writes it.
pub(crate) fn write(run: &Run, choice: &Choice) -> Result<()> {
    let shown = |(c, case): &(usize, &Case)| match &choice.only {
        Some(only) => case.name.contains(only.as_str()),
        None => !run.small || *c == 0,
    };
    let mut all = Vec::new();
    for (_, case) in CASES.iter().enumerate().filter(shown) {
        println!("{}", case.name);
        all.push(found(run, case, choice)?);
    }
    let portraits = portraits::rows(run)?;
    run.save("flat", &page::page(&all, &portraits)?, &page::csv(&all)?)?;
    run.save_csv("flat-portraits", &page::portraits_csv(&portraits)?)
}

fn found(run: &Run, case: &Case, choice: &Choice) -> Result<Found> {
    let (figure, hidden) = case.figure(&run.data)?;
    let framed = case.framed(&figure)?;
    let clip = framed.clip()?;
    let prepared = orders::Orders::prepare(&clip)?;
    let files = choice
        .files
        .as_ref()
        .map(|f| f.join(case.name.replace([' ', ',', '°'], "_")));
    Ok(Found {
        case: *case,
        hidden,
        frames: framed.frame_times_secs.len(),
        triangles: framed.triangles.len(),
        orders: orders::Orders::of(&clip, &prepared)?,
        profiles: profiles::rows(&framed, &prepared, run.small, files.as_deref())?,
        stills: profiles::stills(&framed, &clip)?,
    })
}
