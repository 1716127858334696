//! Conversion to 2D: what each profile weighs and how far it is off, beside the thesis' own form.
//!
//! Source: `docs/methods/vector.md` 4, 9 and 10. One file for each section of the page.

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

/// Which part of the table is run.
#[derive(clap::Args, Default)]
pub(crate) struct Choice {
    /// Cases whose names contain this, and no others.
    #[arg(long)]
    only: Option<String>,
    /// Folder that receives the files that were written, and pictures of them.
    #[arg(long)]
    files: Option<PathBuf>,
}

/// What was found of one case.
struct Found {
    case: Case,
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
    let figure = case.figure(&run.data)?;
    let framed = case.framed(&figure)?;
    let clip = framed.clip()?;
    let prepared = orders::Orders::prepare(&clip)?;
    let files = choice
        .files
        .as_ref()
        .map(|f| f.join(case.name.replace([' ', ',', '°'], "_")));
    Ok(Found {
        case: *case,
        triangles: framed.triangles.len(),
        orders: orders::Orders::of(&clip, &prepared)?,
        profiles: profiles::rows(&framed, &prepared, run.small, files.as_deref())?,
        stills: profiles::stills(&framed, &clip)?,
    })
}
