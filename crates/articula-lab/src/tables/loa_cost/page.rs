//! The page of the cost of levels of articulation, its CSV files and its plots.

use super::measure::StageNs;
use super::{FIGURES, Figures, Found, Level, PerJoint, Selector};
use anyhow::Result;
use articula_core::Backend;
use articula_report::{BarSeries, PlotOptions, Scale, Series, bar_plot, line_plot};
use std::fmt::Write as _;
use std::thread::available_parallelism;

const HEAD: &str = "# Cost of levels of articulation

Made by `cargo run --release -p articula-lab -- loa-cost`. The measurements of the thesis' 6.3.1 and of its
figures 6.14 and 6.15, in bytes and milliseconds: which joints of a level are animated, what a frame costs,
and what the animation takes when only they move. The thesis' own numbers are illegible in the scan.

The playback that ships (docs/methods/motion-lod.md, 2.2) shows every frame of the clip; joints of the level
follow it, all others, the root too, hold the rest pose. *Transforms*: sampling, and the model matrices of
what changed and of what is below it. *Skinning*: the vertices that a changed matrix or morph weight moves.
Each frame is timed apart in the processor time of one thread, the first frame, in which everything is
new, is left out; the levels take turns, the median over the rounds counts for each frame, and the mean over
frames is stated. Bytes are those of key times and values as 32-bit floats, where joints that do not move
keep one key (docs/methods/motion-lod.md, 2); *per frame* is divided by the frames of the clip.
";

/// The Markdown page.
pub(super) fn page(all: &[Found], crowd: &[Figures]) -> Result<String> {
    let mut page = String::from(HEAD);
    let cores = available_parallelism().map_or(1, usize::from);
    writeln!(
        page,
        "\nMeasured on one thread of a machine with {cores} {} cores; skinning in groups runs on {}.",
        std::env::consts::ARCH,
        Backend::best(),
    )?;
    fits(&mut page, all)?;
    for found in all {
        levels(&mut page, found)?;
    }
    over_frames(&mut page, all)?;
    figures(&mut page, crowd)?;
    Ok(page)
}

/// Microseconds of a time.
fn us(ns: f64) -> String {
    format!("{:.2}", 1e-3 * ns)
}

/// The cost formulas of the thesis.
fn fits(page: &mut String, all: &[Found]) -> Result<()> {
    page.push_str(
        "
## Cost of a joint and frame

The thesis' formulas `s = Σ (s_i - s_0) / (n_i d) / m` and `c = Σ (t_i - t_0) / (n_i d) / m`: over the `m` levels
with joints, size or time less that of no joint, for each of its `n_i` joints and the `d` frames. In brackets
the least and the greatest of the levels. *Slope*: least squares through the levels with joints, what one more
joint adds where others move already; bytes, and nanoseconds of both stages.

The thesis finds cost proportional to joints. That holds for bytes. It does not hold for time here, because a
joint that moves renews the matrices of all joints below it and the vertices of all of these: a level with the
root in it skins the whole body, so that a handful of joints costs nearly as much as all. Levels save time where the
joints that they drop are merged with their ancestors ([crowd](crowd.md), [merged levels](merged-levels.md)).

| character | levels | bytes | transforms, ns | skinning, ns | both, ns | slope, bytes | slope, ns |
| --- | --- | --- | --- | --- | --- | --- | --- |
",
    );
    for found in all {
        for selector in Selector::ALL {
            let fit = |cost: &dyn Fn(&Level) -> f64| {
                let levels: Vec<_> = found.of(selector).map(|l| (l.joints, cost(l))).collect();
                PerJoint::fit(&levels)
            };
            let cell = |fit: Option<PerJoint>| match fit {
                Some(fit) => format!("{:.1} ({:.1} to {:.1})", fit.mean, fit.least, fit.most),
                None => "–".to_owned(),
            };
            let slope = |fit: Option<PerJoint>| match fit {
                Some(fit) => format!("{:.1}", fit.slope),
                None => "–".to_owned(),
            };
            let frames = found.frames as f64;
            let bytes = fit(&|l| l.bytes as f64 / frames);
            let both = fit(&|l| l.ns().sum());
            let cells = [
                cell(bytes),
                cell(fit(&|l| l.ns().transforms)),
                cell(fit(&|l| l.ns().skinning)),
                cell(both),
                slope(bytes),
                slope(both),
            ];
            let (name, selector) = (found.subject.name, selector.name());
            writeln!(page, "| {name} | {selector} | {} |", cells.join(" | "))?;
        }
    }
    Ok(())
}

/// Every level of one character.
fn levels(page: &mut String, found: &Found) -> Result<()> {
    let subject = found.subject;
    writeln!(
        page,
        "
## {}, {}

`{}`: {} joints, {} vertices, {} frames at {} Hz. Times in microseconds a frame; *less none* is the time of both
stages less that of the level without joints.

| levels | level | joints | transforms | matrices | vertices | bytes | bytes per frame | transforms, µs | skinning, µs | less none, µs |
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |",
        subject.name,
        subject.clip,
        subject.file,
        found.joints,
        found.vertices,
        found.frames,
        found.rate_hz,
    )?;
    for selector in Selector::ALL {
        let idle = found.of(selector).find(|l| l.joints == 0);
        let idle = idle.map_or(0.0, |l| l.ns().sum());
        for level in found.of(selector) {
            let ns = level.ns();
            let counts = level.counts;
            writeln!(
                page,
                "| {} | {} | {} | {:.0} | {:.1} | {:.0} | {} | {:.1} | {} | {} | {} |",
                selector.name(),
                level.name,
                level.joints,
                counts.transforms,
                counts.matrices,
                counts.vertices,
                level.bytes,
                level.bytes as f64 / found.frames as f64,
                us(ns.transforms),
                us(ns.skinning),
                us(ns.sum() - idle),
            )?;
        }
    }
    Ok(())
}

/// Spread over the frames of the first character's clip: figure 6.14 on the right.
fn over_frames(page: &mut String, all: &[Found]) -> Result<()> {
    let Some(found) = all.first() else {
        return Ok(());
    };
    writeln!(
        page,
        "
## Over the frames of a clip

{}, {}: milliseconds of both stages in each frame, by level of complexity; least, median and greatest here,
every frame in the CSV and the plot.

![Time of each frame by level of complexity](loa-cost-frames.svg)

| level | joints | least, ms | median, ms | greatest, ms |
| --- | --- | --- | --- | --- |",
        found.subject.name, found.subject.clip
    )?;
    for level in found.of(Selector::Complexity) {
        let mut ns: Vec<f64> = level.frames.iter().map(|f| f.sum()).collect();
        let median = crate::measure::median(&mut ns);
        let ms = |ns: Option<f64>| 1e-6 * ns.unwrap_or_default();
        let (least, most) = (ms(ns.first().copied()), ms(ns.last().copied()));
        writeln!(
            page,
            "| {} | {} | {least:.4} | {:.4} | {most:.4} |",
            level.name,
            level.joints,
            1e-6 * median
        )?;
    }
    page.push_str(
        "
![Time by zone](loa-cost-zones.svg)

![Time by level of complexity](loa-cost-complexity.svg)

![Time by depth](loa-cost-depths.svg)
",
    );
    Ok(())
}

/// Several figures at the same time: figure 6.15 on the right.
fn figures(page: &mut String, crowd: &[Figures]) -> Result<()> {
    let shown = crowd.first().map_or(0, |f| f.frame_ns.len());
    let counts = FIGURES[..shown].iter();
    let heads: Vec<String> = counts.map(|n| format!("{n}")).collect();
    writeln!(
        page,
        "
## Several figures

The first character, that many times in the same frame: milliseconds a frame of both stages, and in brackets
of transforms alone. For crowds there are batches and merged levels, which cost less ([crowd](crowd.md)).

![Time by number of figures and level of complexity](loa-cost-figures.svg)

| level | {} |
| --- |{}",
        heads.join(" | "),
        " --- |".repeat(shown)
    )?;
    for level in crowd {
        let ms = |ns: &StageNs| format!("{:.3} ({:.3})", 1e-6 * ns.sum(), 1e-6 * ns.transforms);
        let cells: Vec<String> = level.frame_ns.iter().map(ms).collect();
        writeln!(page, "| {} | {} |", level.level, cells.join(" | "))?;
    }
    Ok(())
}

/// Every level of every character as CSV.
pub(super) fn csv(all: &[Found]) -> Result<String> {
    let mut csv = String::from(
        "character,clip,levels,level,joints,transforms,matrices,vertices,bytes,frames,transforms_ms,skinning_ms\n",
    );
    for found in all {
        for level in &found.levels {
            let (counts, ns) = (level.counts, level.ns());
            writeln!(
                csv,
                "{},{},{},{},{},{:.2},{:.2},{:.1},{},{},{:.6},{:.6}",
                found.subject.name,
                found.subject.clip,
                level.selector.name(),
                level.name,
                level.joints,
                counts.transforms,
                counts.matrices,
                counts.vertices,
                level.bytes,
                found.frames,
                1e-6 * ns.transforms,
                1e-6 * ns.skinning
            )?;
        }
    }
    Ok(csv)
}

/// The time of every frame by level of complexity as CSV.
pub(super) fn frames_csv(all: &[Found]) -> Result<String> {
    let mut csv = String::from("character,clip,level,frame,transforms_ms,skinning_ms\n");
    for found in all.iter().take(1) {
        for level in found.of(Selector::Complexity) {
            for (f, ns) in level.frames.iter().enumerate() {
                writeln!(
                    csv,
                    "{},{},{},{},{:.6},{:.6}",
                    found.subject.name,
                    found.subject.clip,
                    level.name,
                    f + 1,
                    1e-6 * ns.transforms,
                    1e-6 * ns.skinning
                )?;
            }
        }
    }
    Ok(csv)
}

/// The times with several figures as CSV.
pub(super) fn figures_csv(crowd: &[Figures]) -> Result<String> {
    let mut csv = String::from("level,figures,transforms_ms,skinning_ms\n");
    for level in crowd {
        for (figures, ns) in FIGURES.iter().zip(&level.frame_ns) {
            writeln!(
                csv,
                "{},{figures},{:.6},{:.6}",
                level.level,
                1e-6 * ns.transforms,
                1e-6 * ns.skinning
            )?;
        }
    }
    Ok(csv)
}

/// The plots of the page, with their names.
pub(super) fn plots(all: &[Found], crowd: &[Figures]) -> Vec<(&'static str, String)> {
    let Some(found) = all.first() else {
        return Vec::new();
    };
    let bars = |selector: Selector, title: &str| {
        let names: Vec<String> = found
            .of(selector)
            .map(|l| format!("{}/{}", l.name, l.joints))
            .collect();
        let series = |name: &str, of: fn(StageNs) -> f64| BarSeries {
            name: name.to_owned(),
            values: found.of(selector).map(|l| 1e-6 * of(l.ns())).collect(),
        };
        let stages = [
            series("transforms", |ns| ns.transforms),
            series("skinning", |ns| ns.skinning),
        ];
        bar_plot(&options(title, ""), &names, &stages)
    };
    let over_frames: Vec<Series> = found
        .of(Selector::Complexity)
        .map(|level| Series {
            name: level.name.clone(),
            points: (1..).zip(&level.frames).map(point).collect(),
            dashed: false,
        })
        .collect();
    let by_figures: Vec<Series> = crowd
        .iter()
        .map(|level| Series {
            name: level.level.clone(),
            points: FIGURES
                .into_iter()
                .zip(&level.frame_ns)
                .map(point)
                .collect(),
            dashed: false,
        })
        .collect();
    let logarithmic = PlotOptions {
        x: Scale::Logarithmic,
        ..options("Several figures at the same time", "figures")
    };
    vec![
        ("loa-cost-zones", bars(Selector::Zone, "Zone / its joints")),
        (
            "loa-cost-complexity",
            bars(Selector::Complexity, "Level of complexity / its joints"),
        ),
        (
            "loa-cost-depths",
            bars(Selector::Depth, "Depth / its joints"),
        ),
        (
            "loa-cost-frames",
            line_plot(&options("Over the clip", "frame"), &over_frames),
        ),
        ("loa-cost-figures", line_plot(&logarithmic, &by_figures)),
    ]
}

fn options(title: &str, x_label: &str) -> PlotOptions {
    PlotOptions {
        title: title.to_owned(),
        x_label: x_label.to_owned(),
        y_label: "ms a frame".to_owned(),
        ..PlotOptions::default()
    }
}

/// A point of a line: both stages, milliseconds.
fn point((x, ns): (usize, &StageNs)) -> (f64, f64) {
    (x as f64, 1e-6 * ns.sum())
}
