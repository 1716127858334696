//! What a crowd of anybody costs, character by character: preparation, the whole frame, and budgets.

use super::Run;
use super::paired_frames::without_and_with;
use super::targets::{Target, section};
use anyhow::{Context, Result};
use articula::crowd::{
    BudgetUse, CacheUse, CrowdAsset, CrowdOptions, CrowdPlayer, Culling, DetailGoal, FrameSummary,
    Hiders, MeasureOptions, SceneMeasurement, SceneOptions, measure_scene,
};
use articula::{Executor, Figure};
use articula_build::{Plaza, Scene, plaza};
use articula_formats::gltf::Document;
use articula_human::HumanOptions;
use articula_report::{FRAME_CLOCKS, crowd_for_sizes, thread_ns};
use clap::Args;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::slice::from_ref;
use std::sync::Arc;

/// Characters of the plaza, and its frames: two seconds; under a budget ten, since costs are learned from them.
const COUNT: usize = 10_000;
const FRAMES: usize = 120;
const BUDGET_FRAMES: usize = 5 * FRAMES;
const SEED: u64 = 1;
/// Tolerance in pixels; the worst vertex and those who are near are expected within twice of it.
const PX: f32 = 1.0;
/// Percent by which a frame may be above the floor where the budget is below it.
const FLOOR_OVERRUN: f64 = 10.0;
/// Budgets, as shares of the character's own median frame without one.
const SHARES: [f64; 4] = [2.0, 1.0, 0.75, 0.5];

/// Files of the data: short and long clips, many clips, one mesh and many, 19 to 163 joints, faces.
const CHARACTERS: [&str; 14] = [
    "glb/KayKit_Knight.glb",
    "glb/KayKit_Mage.glb",
    "glb/mh_female_dance.glb",
    "glb/mh_male_cmu31.glb",
    "glb/pab_arnaud.glb",
    "glb/RobotExpressive.glb",
    "glb/mannequiny.glb",
    "glb/Quaternius_cyberpunk_pack__Character.glb",
    "glb/Quaternius_modular_men__Suit.glb",
    "glb/Quaternius_modular_women__Casual.glb",
    "glb/Quaternius_single_knight_pack__KnightCharacter.glb",
    "glb/Quaternius_platformer_game_pack__Character.glb",
    "glb/CesiumMan.glb",
    "glb/ict_head_talk_554.glb",
];
/// Name of the reference human, which is measured too.
const HUMAN: &str = "reference_human";
/// The character of a small run, its number of characters, and its frames, without and with a budget.
const SMALL: &str = "glb/Quaternius_single_knight_pack__KnightCharacter.glb";
const SMALL_COUNT: usize = 60;
const SMALL_FRAMES: [usize; 2] = [10, 10];

/// Which characters are measured.
#[derive(Debug, Clone, Args)]
pub(crate) struct Choice {
    /// Only characters whose file name contains one of these, for a look at a few of them.
    #[arg(long, value_name = "PART")]
    only: Vec<String>,
}

/// A character and what was measured of it.
struct Found {
    name: String,
    joints: usize,
    clips: usize,
    vertices: usize,
    /// Processor milliseconds from opening the file to a first frame in full detail.
    first_frame_ms: f64,
    /// Processor seconds of preparation.
    prepared_secs: f64,
    frame: FrameSummary,
    /// What a frame takes more with a budget of twice its time, as a part of it.
    idle_budget: f64,
    /// Median milliseconds of a frame under a budget of nothing: the least that a budget can have.
    floor_ms: f64,
    budgets: Vec<Budgeted>,
}

/// A frame under a budget.
struct Budgeted {
    share: f64,
    ms: f64,
    /// 95th percentile of the time beyond the budget, or beyond the floor if that is more, as a part of it.
    overrun_p95: f64,
    frame: FrameSummary,
    used: BudgetUse,
}

/// Runs the table and writes it.
pub(crate) fn write(run: &Run, choice: &Choice) -> Result<()> {
    let names: &[&str] = if run.small { &[SMALL] } else { &CHARACTERS };
    let is_chosen = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        choice.only.is_empty() || choice.only.iter().any(|part| name.contains(part.as_str()))
    };
    let made = tempfile::tempdir()?;
    let mut paths: Vec<PathBuf> = names.iter().map(|name| run.data.join(name)).collect();
    if !run.small {
        let path = made.path().join(HUMAN).with_extension("glb");
        let human = articula_human::human(&HumanOptions::default())?;
        std::fs::write(&path, Document::from_character(&human)?.write_glb()?)?;
        paths.push(path);
    }
    paths.retain(is_chosen);
    let size = match run.small {
        true => (SMALL_COUNT, SMALL_FRAMES),
        false => (COUNT, [FRAMES, BUDGET_FRAMES]),
    };
    let mut found = Vec::with_capacity(paths.len());
    for path in &paths {
        let of = of(path, size).with_context(|| path.display().to_string())?;
        eprintln!("{}: {:.3} ms", of.name, of.frame.ms);
        found.push(of);
    }
    run.save("crowd-characters", &page(&found)?, &csv(&found)?)
}

fn of(path: &Path, (count, [frames, budget_frames]): (usize, [usize; 2])) -> Result<Found> {
    let start = thread_ns();
    let figure = Figure::new(articula::fs::open(path)?)?;
    let options = CrowdOptions::default();
    let plain = CrowdAsset::at_once(&figure, &options)?;
    let mut player = CrowdPlayer::new(&plain, 1)?;
    player.plan(0.0, Culling::Off, &mut |_| ());
    player.evaluate();
    let first_frame_ms = (thread_ns() - start) as f64 / 1e6;
    let start = thread_ns();
    let asset = CrowdAsset::new(&figure, &options, &Executor::default())?;
    let prepared_secs = (thread_ns() - start) as f64 / 1e9;
    let frame = measured(&asset, DetailGoal::Tolerance(PX), (count, frames))?.frame();
    let scene = scene_of(&asset, count);
    let idle = (SHARES[0] * frame.ms, PX);
    let [without_ms, with_ms] = without_and_with(&asset, &scene, PLAYED, idle, budget_frames)?;
    let within = |ms: f64| {
        let goal = DetailGoal::Budget {
            ms: ms as f32,
            cap_px: PX,
        };
        measured(&asset, goal, (count, budget_frames))
    };
    let floor_ms = within(0.0)?.frame().ms;
    let budget = |share: f64| {
        let ms = share * frame.ms;
        let measured = within(ms)?;
        // A time beyond the budget is one beyond the floor less what lies between.
        let over = measured.overrun_p95.context("no overrun")?;
        let overrun_p95 = ((1.0 + over) * ms / ms.max(floor_ms) - 1.0).max(0.0);
        Ok(Budgeted {
            share,
            ms,
            overrun_p95,
            frame: measured.frame(),
            used: measured.budget.context("no budget")?,
        })
    };
    let stem = path.file_stem().unwrap_or_default();
    Ok(Found {
        name: stem.to_string_lossy().into_owned(),
        joints: figure.asset.rig.len(),
        clips: figure.asset.clips.len(),
        vertices: figure.asset.mesh.len(),
        first_frame_ms,
        prepared_secs,
        frame,
        idle_budget: with_ms / without_ms - 1.0,
        floor_ms,
        budgets: SHARES.into_iter().map(budget).collect::<Result<_>>()?,
    })
}

/// How the plaza is played, but for the detail.
const PLAYED: SceneOptions = SceneOptions {
    detail: DetailGoal::Full,
    cache: CacheUse::Cpu,
    hiders: Hiders::Nothing,
};

/// The plaza with so many of a character.
fn scene_of(asset: &CrowdAsset, count: usize) -> Arc<Scene> {
    let scene = plaza(count, &[asset.clips().len()], SEED, Plaza::Still);
    let scene = crowd_for_sizes(scene, std::iter::once(asset.full()));
    Arc::new(scene)
}

/// Plays the plaza on one thread.
fn measured(
    asset: &CrowdAsset,
    detail: DetailGoal,
    (count, frames): (usize, usize),
) -> Result<SceneMeasurement> {
    let options = MeasureOptions {
        scene: SceneOptions { detail, ..PLAYED },
        threads: 1,
        frames,
        seed: SEED,
    };
    let scene = scene_of(asset, count);
    let work = Executor::default();
    Ok(measure_scene(
        from_ref(asset),
        &scene,
        &options,
        FRAME_CLOCKS,
        &work,
    )?)
}

/// The targets of a character.
fn targets(found: &Found) -> Vec<Target> {
    let of = |what: &str, most: f64, value: f64| {
        Target::at_most([found.name.as_str(), what], most, value)
    };
    let frame = &found.frame;
    let px = f64::from(PX);
    let mut targets = vec![
        of("whole frame, ms", 0.5, frame.ms),
        of("triangles, millions", 3.0, frame.triangles / 1e6),
        of("draws", 60.0, frame.draws),
        of("p95 over characters, px", px, frame.error_p95_px),
        of("within 20 m, px", 2.0 * px, frame.error_near_px),
        of("worst vertex, px", 2.0 * px, frame.worst_vertex_px),
        of("first frame, processor ms", 300.0, found.first_frame_ms),
        of("more with a budget of 2, %", 5.0, 100.0 * found.idle_budget),
    ];
    for budget in &found.budgets {
        let named = |what: &str| format!("budget of {:.2}: {what}", budget.share);
        let is_above_floor = found.floor_ms <= budget.ms;
        let near = budget.frame.error_near_px;
        targets.push(of(&named("within 20 m, px"), 2.0 * px, near));
        let over = 100.0 * budget.overrun_p95;
        if is_above_floor {
            targets.push(of(&named("p95 overrun, %"), 5.0, over));
            targets.push(of(
                &named("p95 over characters, px"),
                px,
                budget.frame.error_p95_px,
            ));
        } else {
            targets.push(of(&named("p95 over the floor, %"), FLOOR_OVERRUN, over));
        }
    }
    targets
}

fn page(all: &[Found]) -> Result<String> {
    let mut page = HEAD.to_owned();
    let worst = |of: &dyn Fn(&Found) -> f64| {
        let most = all.iter().max_by(|a, b| of(a).total_cmp(&of(b)));
        most.map_or((String::new(), 0.0), |f| (f.name.clone(), of(f)))
    };
    let least = all.iter().map(|f| f.frame.ms).fold(f64::INFINITY, f64::min);
    let (ms, triangles) = (worst(&|f| f.frame.ms), worst(&|f| f.frame.triangles / 1e6));
    let prepared = worst(&|f| f.prepared_secs);
    writeln!(
        page,
        "\n{} characters: {least:.3} to {:.3} ms of one thread for a frame (most: {}), at most {:.1} million triangles ({}), at most {:.1} s of one core to prepare ({}).",
        all.len(),
        ms.1,
        ms.0,
        triangles.1,
        triangles.0,
        prepared.1,
        prepared.0
    )?;
    let targets: Vec<Target> = all.iter().flat_map(targets).collect();
    page.push_str(FRAMES_TABLE);
    for found in all {
        let frame = &found.frame;
        writeln!(
            page,
            "| {} | {} | {} | {} | {:.0} | {:.1} | {:.3} | {:.1} | {:.0} | {:.2} | {:.2} | {:.2} | {:.2} | {:.1} |",
            found.name,
            found.joints,
            found.clips,
            found.vertices,
            found.first_frame_ms,
            found.prepared_secs,
            frame.ms,
            frame.triangles / 1e6,
            frame.draws,
            frame.bytes / 1e6,
            frame.error_p95_px,
            frame.error_near_px,
            frame.worst_vertex_px,
            100.0 * found.idle_budget
        )?;
    }
    page.push_str(BUDGET_TABLE);
    for (found, b) in all
        .iter()
        .flat_map(|f| f.budgets.iter().map(move |b| (f, b)))
    {
        writeln!(
            page,
            "| {} | {:.2} | {:.3} | {:.3} | {:.3} | {:.3} | {:.1} | {:.2} | {:.2} | {:.2} | {:.1} | {} |",
            found.name,
            b.share,
            b.ms,
            b.frame.ms,
            found.floor_ms,
            b.used.floor_ms,
            100.0 * b.overrun_p95,
            b.used.tolerance_px.median,
            b.frame.error_p95_px,
            b.frame.error_near_px,
            b.frame.triangles / 1e6,
            given_up(&b.used)
        )?;
    }
    page.push_str(&section(TARGETS, &["character", "quantity"], &targets));
    Ok(page)
}

/// What was given up in any frame.
fn given_up(used: &BudgetUse) -> String {
    let gave = used.sacrificed;
    let each = [
        ("triangles", gave.triangles),
        ("pixels", gave.pixels),
        ("time", gave.time),
    ];
    let each = each.into_iter().filter(|(_, frames)| *frames > 0);
    let each: Vec<&str> = each.map(|(what, _)| what).collect();
    match each.is_empty() {
        true => "nothing".to_owned(),
        false => each.join(", "),
    }
}

const HEAD: &str = "# What a crowd of anybody costs

Made by `cargo run --release -p articula-lab -- crowd-characters`: files of the data as they are and the
reference human, 10,000 of each on the plaza (docs/methods/runtime.md part 4), 1920 x 1080 px, with default options, two
seconds at 60 Hz. Times are processor time of one thread; on a machine that others use too they are longer and vary more
than on a quiet one. Errors are those of joints, mesh and cached poses together, as in docs/metrics.md.
";

const FRAMES_TABLE: &str = "
## Preparation and whole frame

*First frame*: from opening the file to a frame in full detail, which needs no preparation. *Prepared*: all levels, errors
and cached poses. *Frame*: the median, within 1 px. *Budget*: what a frame takes more with a budget of twice its time, in which
nothing has to be given up; frames with and without it take turns.

| character | joints | clips | vertices | first frame, ms | prepared, s | frame, ms | million triangles | draws | MB written | p95, px | within 20 m, px | worst vertex, px | budget, % |
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |
";

const BUDGET_TABLE: &str = "
## Under a budget

Budgets as shares of the character's own frame, over ten seconds, in the first frames of which costs are learned. *Floor*:
the least time, with everyone at the cheapest that a budget allows, measured with a budget of nothing; *told* is what the
budget expects it to be. *Overrun*: beyond the budget, or beyond the floor where that is more. What is given up is told in
docs/methods/runtime.md part 4.4.

| character | share | budget, ms | used, ms | floor, ms | told, ms | overrun p95, % | tolerance, px | p95, px | within 20 m, px | million triangles | given up |
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |
";

const TARGETS: &str = "The limits hold for each character; those of the percentile under a budget for budgets above its floor.";

fn csv(all: &[Found]) -> Result<String> {
    let mut csv = String::from(
        "character,joints,clips,vertices,first_frame_ms,prepared_s,share,budget_ms,ms,p95_overrun,floor_ms,told_floor_ms,tolerance_px,triangles,draws,bytes,p95_px,near_px,worst_vertex_px\n",
    );
    for found in all {
        let head = format!(
            "{},{},{},{},{:.1},{:.3}",
            found.name,
            found.joints,
            found.clips,
            found.vertices,
            found.first_frame_ms,
            found.prepared_secs
        );
        let frame = |f: &FrameSummary| {
            format!(
                "{:.0},{:.0},{:.0},{:.4},{:.4},{:.4}",
                f.triangles, f.draws, f.bytes, f.error_p95_px, f.error_near_px, f.worst_vertex_px
            )
        };
        let own = &found.frame;
        writeln!(csv, "{head},,,{:.4},,,,{PX},{}", own.ms, frame(own))?;
        for b in &found.budgets {
            writeln!(
                csv,
                "{head},{},{:.4},{:.4},{:.4},{:.4},{:.4},{:.3},{}",
                b.share,
                b.ms,
                b.frame.ms,
                b.overrun_p95,
                found.floor_ms,
                b.used.floor_ms,
                b.used.tolerance_px.median,
                frame(&b.frame)
            )?;
        }
    }
    Ok(csv)
}
