//! A mixed scene: several characters, two views, walls and roles under one budget, beside update rates by
//! ranks of distance in the same time.
//!
//! - [`stage`]: the scene
//! - [`by_ranks`]: what a policy of ranks shows of the same characters
//!
//! This file plays both and writes the page.

mod by_ranks;
mod stage;

use super::Run;
use super::targets::{Target, section};
use crate::peers::ranks::{Beyond, Ranks};
use anyhow::{Context, Result};
use articula::Executor;
use articula::crowd::{
    CacheUse, CrowdAsset, DISPLAY_HZ, DetailGoal, ErrorSample, ErrorSummary, Hiders,
    MeasureOptions, SceneOptions, measure_scene, write_scene,
};
use articula_report::FRAME_CLOCKS;
use by_ranks::Held;
use clap::Args;
use stage::Stage;
use std::fmt::Write as _;
use std::path::PathBuf;

const SEED: u64 = 1;
const FRAMES: usize = 240;
/// Frames of a small run.
const FEW_FRAMES: usize = 16;
/// Time of a frame, milliseconds.
const BUDGET_MS: f64 = 1.5;
/// Maximum errors in pixels: 95th percentile over visible characters, and maximum within 20 m.
const MOST_PX: (f64, f64) = (1.0, 2.0);
/// Maximum of the 95th percentile over frames of the time beyond the budget, per cent.
const OVERRUN: f64 = 5.0;

/// What the page is about.
#[derive(Debug, Clone, Args)]
pub(crate) struct Choice {
    /// Write the scene to a file for `crowd --scene`; it names the characters by their files.
    #[arg(long, value_name = "F.json")]
    scene: Option<PathBuf>,
}

/// One way to play the scene.
struct Played {
    name: String,
    /// Milliseconds of a frame: median, and 95th percentile.
    ms: [f64; 2],
    /// Characters that are evaluated or written in a frame: the median, of ranks the mean.
    shown: f64,
    looks: Vec<ErrorSample>,
    /// Errors of the characters of the main role.
    main: ErrorSummary,
    overrun: Option<f64>,
}

/// Runs the table and writes it.
pub(crate) fn write(run: &Run, choice: &Choice) -> Result<()> {
    let stage = Stage::new(run)?;
    if let Some(path) = &choice.scene {
        let files = stage.files(run)?;
        let cast = stage.cast.iter().zip(&files);
        let cast: Vec<_> = cast.map(|(member, file)| member.of_file(file)).collect();
        let json = write_scene(&stage.scene, &cast);
        std::fs::write(path, json).with_context(|| path.display().to_string())?;
        println!("{}", path.display());
    }
    let frames = if run.small { FEW_FRAMES } else { FRAMES };
    let assets: Vec<CrowdAsset> = stage.cast.iter().map(|c| c.asset.clone()).collect();
    let mut rows = Vec::new();
    let mut seen = Vec::new();
    for (name, detail, cache) in [
        (
            "Articula, every joint of who is seen",
            DetailGoal::Tolerance(0.0),
            CacheUse::Never,
        ),
        (
            "Articula, within 1 px",
            DetailGoal::Tolerance(1.0),
            CacheUse::Cpu,
        ),
        (
            "Articula, budget, palettes by the CPU",
            budget(),
            CacheUse::Cpu,
        ),
        (
            "Articula, budget, records for the GPU",
            budget(),
            CacheUse::Gpu,
        ),
    ] {
        let played = ours(&stage, &assets, (name, detail, cache), frames)?;
        // Others are measured on the same characters at the same times.
        if seen.is_empty() {
            seen.clone_from(&played.looks);
        }
        rows.push(played);
    }
    let held = Held::new(&stage, &assets)?;
    let baked = Beyond::Baked { hz: 30.0 };
    for (what, beyond) in [("frozen", Beyond::Frozen), ("baked at 30 Hz", baked)] {
        let usual = Ranks {
            beyond,
            ..Ranks::default()
        };
        rows.push(held.play(
            (&format!("8 full, 32 at 20 Hz, the rest {what}"), usual),
            &seen,
            frames,
        )?);
        let more = held.within(usual, BUDGET_MS);
        let name = format!(
            "equal time: {} full, {} at 20 Hz, the rest {what}",
            more.full, more.reduced
        );
        rows.push(held.play((&name, more), &seen, frames)?);
    }
    run.save("crowd-scene", &page(&stage, &rows, frames)?, &csv(&rows)?)
}

fn budget() -> DetailGoal {
    DetailGoal::Budget {
        ms: BUDGET_MS as f32,
        cap_px: MOST_PX.0 as f32,
    }
}

/// Plays the scene by Articula.
fn ours(
    stage: &Stage,
    assets: &[CrowdAsset],
    (name, detail, cache): (&str, DetailGoal, CacheUse),
    frames: usize,
) -> Result<Played> {
    let options = MeasureOptions {
        scene: SceneOptions {
            detail,
            cache,
            hiders: Hiders::Walls,
        },
        threads: 1,
        frames,
        seed: SEED,
    };
    let work = Executor::default();
    let found = measure_scene(assets, &stage.scene, &options, FRAME_CLOCKS, &work)?;
    Ok(Played {
        name: name.to_owned(),
        ms: [found.frame_ms.median, found.frame_ms.p95],
        shown: found.visible as f64,
        main: of_main(stage, &found.samples),
        looks: found.samples,
        overrun: found.overrun_p95.map(|over| 100.0 * over),
    })
}

/// Errors of the members that begin in the main role.
fn of_main(stage: &Stage, looks: &[ErrorSample]) -> ErrorSummary {
    let looks = looks.iter().map(|look| ErrorSample {
        secs: look.secs,
        characters: look
            .characters
            .iter()
            .filter(|c| stage.is_main(c.character))
            .map(|c| articula::crowd::CharacterError {
                is_sampled: true,
                ..*c
            })
            .collect(),
    });
    ErrorSummary::of(&looks.collect::<Vec<_>>())
}

fn page(stage: &Stage, rows: &[Played], frames: usize) -> Result<String> {
    let mut page = format!(
        "# A mixed scene under one budget\n\n\
         Made by `cargo run --release -p articula-lab -- crowd-scene`; with `--scene F.json` it writes the scene, which \
         `articula crowd --scene F.json` plays and draws. {} characters of {} kinds ({}), each 1.8 m high, in rows 2 m \
         apart; {} walls; two views of 1920 x 1080 pixels, one of which drives through the crowd while the other looks \
         down from a balcony; {} of the characters have the role *main* (importance 4) and half of the others \
         *audience* (0.5). One thread, {frames} frames at {DISPLAY_HZ} Hz.\n\n",
        stage.scene.members.len(),
        stage.cast.len(),
        stage
            .cast
            .iter()
            .map(|c| c.name)
            .collect::<Vec<_>>()
            .join(", "),
        stage.scene.walls.len(),
        stage.mains(),
    );
    let mut targets = Vec::new();
    for row in rows.iter().filter(|row| row.overrun.is_some()) {
        let error = ErrorSummary::of(&row.looks);
        targets.extend([
            Target::at_most([&row.name, "median frame, ms"], BUDGET_MS, row.ms[0]),
            Target::at_most(
                [&row.name, "p95 overrun, %"],
                OVERRUN,
                row.overrun.unwrap_or(0.0),
            ),
            Target::at_most([&row.name, "p95 error, px"], MOST_PX.0, error.p95),
            Target::at_most(
                [&row.name, "max error within 20 m, px"],
                MOST_PX.1,
                error.near_max,
            ),
        ]);
    }
    page.push_str(&section(
        &format!(
            "A budget of {BUDGET_MS} ms for the whole frame: what hides, clocks, views, levels and poses of all characters. Errors as \
         in docs/metrics.md, in the view that shows most of them."
        ),
        &["what", "quantity"],
        &targets,
    ));
    page.push_str(
        "\n## Beside ranks of distance\n\n*Ranks*: the nearest characters to either camera are evaluated in every frame, \
         the next ones at 20 Hz with their pose held, the rest stay frozen or show a pose baked beforehand; several \
         engines ship such ranks. Their time is that of evaluating all joints in Articula's batches; ranking, culling and \
         baked poses cost nothing. *Equal time*: as many, in the same proportion, as the budget pays for. All methods are \
         measured on the same characters at the same times: all within 20 m of a camera that sees them, and a sample of \
         the others. *Main*: the characters of that role.\n\n\
         | method | ms | p95 of frames, ms | p95, px | max within 20 m, px | worst vertex, px | main, p95, px | main, max, px |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for row in rows {
        let error = ErrorSummary::of(&row.looks);
        writeln!(
            page,
            "| {} | {:.3} | {:.3} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} |",
            row.name,
            row.ms[0],
            row.ms[1],
            error.p95,
            error.near_max,
            error.worst_vertex,
            row.main.p95,
            row.main.max
        )?;
    }
    Ok(page)
}

fn csv(rows: &[Played]) -> Result<String> {
    let mut csv = String::from(
        "method,ms,p95_ms,shown,p95_px,near_max_px,worst_vertex_px,main_p95_px,main_max_px\n",
    );
    for row in rows {
        let error = ErrorSummary::of(&row.looks);
        writeln!(
            csv,
            "{},{:.4},{:.4},{:.1},{:.4},{:.4},{:.4},{:.4},{:.4}",
            row.name.replace(',', ";"),
            row.ms[0],
            row.ms[1],
            row.shown,
            error.p95,
            error.near_max,
            error.worst_vertex,
            row.main.p95,
            row.main.max
        )?;
    }
    Ok(csv)
}
