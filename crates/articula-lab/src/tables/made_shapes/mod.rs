//! Blend shapes that are made for heads without them, judged by heads whose own ones were taken away.
//!
//! - `heads`: the heads, with their own and with made shapes
//! - `contours`: contours of lips and lids
//! - `gap`: what a blink leaves open
//! - `faults`: triangles turned over, and triangles that cross
//! - `measured`: what is measured of each shape
//! - `page`: the page

mod contours;
mod faults;
mod gap;
mod heads;
mod measured;
mod page;

use super::Run;
use anyhow::{Context, Result, ensure};
use articula_build::face::MouthMotions;
use clap::Args;
use heads::Head;
use std::path::PathBuf;

/// What is judged.
#[derive(Args)]
pub(crate) struct Choice {
    /// Heads whose name contains this text only, such as ICT; the page is printed and not written.
    #[arg(long, default_value = "")]
    head: String,
    /// Writes the motions of the lower face that the heads with shapes of their own show, and judges nothing.
    #[arg(long, value_name = "FILE")]
    motions: Option<PathBuf>,
}

/// Judges the heads and writes the page.
pub(crate) fn write(run: &Run, choice: &Choice) -> Result<()> {
    if let Some(path) = &choice.motions {
        let all = heads::motions(&run.data)?;
        let what = "the motions are the mean of more heads than the data has";
        ensure!(all.len() == heads::COUNT, what);
        let all = all.into_iter();
        let mean = MouthMotions::mean(&all.map(|(_, motions)| motions).collect::<Vec<_>>());
        return std::fs::write(path, mean.write()).with_context(|| path.display().to_string());
    }
    let heads = Head::all(&run.data, &choice.head)?.into_iter().map(|head| {
        let rows = measured::rows(&head);
        (head, rows)
    });
    let heads: Vec<_> = heads.collect();
    let page = page::page(&heads);
    if !choice.head.is_empty() {
        print!("{page}");
        return Ok(());
    }
    run.save("made-shapes", &page, &page::csv(&heads))
}
