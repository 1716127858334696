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
use anyhow::Result;
use heads::Head;

/// Judges all heads and writes the page.
pub(crate) fn write(run: &Run) -> Result<()> {
    let heads = Head::all(&run.data)?.into_iter().map(|head| {
        let rows = measured::rows(&head);
        (head, rows)
    });
    let heads: Vec<_> = heads.collect();
    run.save("made-shapes", &page::page(&heads), &page::csv(&heads))
}
