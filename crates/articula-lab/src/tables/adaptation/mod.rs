//! Digital items adapted to contexts: the joint choice beside cuts of single parts, sizes and costs of
//! levels, and what is shown over traces of bandwidth (docs/methods/adaptation.md, docs/adaptation.md).

mod cases;
mod levels;
mod sweep;
mod traces;

use super::Run;
use super::targets::{Target, section};
use anyhow::Result;
use cases::{CASES, Packaged};
use std::fmt::Write as _;

/// Writes the page, its CSV file, the plot and the pictures.
pub(crate) fn write(run: &Run) -> Result<()> {
    let mut page = HEAD.to_owned();
    let mut csv = String::from("item,distance_m,bytes_allowed,way,error_px\n");
    let mut items = Vec::new();
    for case in CASES.iter().filter(|case| !run.small || case.is_small) {
        if let Some(packaged) = Packaged::new(run, case)? {
            eprintln!("adaptation: {}", case.name);
            items.push(packaged);
        }
    }
    levels::write(&items, &mut page)?;
    let sweeps = sweep::write(run, &items, &mut page, &mut csv)?;
    let traces = traces::write(run, &items, &mut page)?;
    let targets = [
        Target::at_most(
            ["choices above the best of single and equal cuts"],
            0.0,
            sweeps.worse as f64,
        ),
        Target::at_least(
            ["sweep points where the joint choice has strictly less error, %"],
            50.0,
            sweeps.strictly_percent(),
        ),
        Target::at_most(
            ["error above that of exhaustive search, %"],
            2.0,
            sweeps.above_exhaustive_percent,
        ),
        Target::at_most(
            ["error of the chosen combination, posed, above its bound, %"],
            0.0,
            sweeps.posed_above_bound_percent,
        ),
        Target::at_most(
            ["traces on which the joint choice stalls more than the thesis' ratio"],
            0.0,
            traces.stalling as f64,
        ),
        Target::at_most(
            ["traces on which its error is not lower than that of the thesis' ratio"],
            0.0,
            traces.not_lower as f64,
        ),
    ];
    page.push_str(&section(
        "What the joint choice must keep, over all items, distances and budgets of the sweep, and over all traces.",
        &["quantity"],
        &targets,
    ));
    writeln!(
        page,
        "\nThe joint choice beside the best of the others: {}.",
        sweeps.summary()
    )?;
    run.save("adaptation", &page, &csv)
}

const HEAD: &str = "# Adaptation

Made by `cargo run --release -p articula-lab -- adaptation`. Characters packaged as [digital items](../formats/item.md), and
adapted to budgets and contexts by the [joint choice](../methods/adaptation.md#3-the-joint-choice). Errors are those of the
manifest, in pixels of 1280 x 720 at 45 degrees: they add up to a bound, which posing the chosen combination checks. Times are
of one thread of a 2-core x86-64 cloud machine. The [chain](../adaptation.md) is explained elsewhere; speeds of cuts by index, by
description and by xsltproc are those of `cargo bench -p articula-stream --no-default-features --bench cut`.
";
