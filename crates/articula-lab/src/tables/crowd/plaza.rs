//! The plaza at each kind of level: time of a whole frame of 10,000 characters, and its error.

use super::stage::{Play, selection_share};
use super::{Bench, CrowdTables, SEED};
use anyhow::Result;
use articula::crowd::{CacheUse, DISPLAY_HZ, DetailGoal, SceneMeasurement};
use articula_build::{PLAZA_COUNT, Plaza, Scene, plaza};
use std::sync::Arc;

/// Columns of the section on scenes.
const SCENE_COLUMNS: [&str; 11] = [
    "scene and levels",
    "median, ms",
    "p95, ms",
    "selection",
    "visible",
    "hidden",
    "poses",
    "MB written",
    "MB resident",
    "p95, px",
    "max within 20 m, px",
];

/// Frame time and errors at one pixel, the reference for other policies.
pub(super) struct AtOnePixel {
    pub(super) ms: f64,
    pub(super) p95_px: f64,
    pub(super) near_px: f64,
}

/// Adds the section; returns the frame of merged levels.
pub(super) fn add(bench: &Bench, report: &mut CrowdTables) -> Result<AtOnePixel> {
    let count = if bench.small { 400 } else { PLAZA_COUNT };
    let clips = bench.asset.clips.len();
    let still = Arc::new(plaza(count, &[clips], SEED, Plaza::Still));
    let kept: Vec<String> = bench.scenes.kept().iter().map(usize::to_string).collect();
    report.heading(
        "The plaza by level",
        &format!(
            "{count} characters with all clips of the file, one thread, skinning palettes as 3x4 f32; levels \
             keep {} joints. Times include the work for all characters, visible or not. Selection: \
             clocks, views, levels and sorting, as a fraction of the evaluation time. Error: on the \
             screen, against all joints of the plain path, for all characters within 20 m and a \
             sample of the others. Resident: clips, characters and palettes.",
            kept.join(", ")
        ),
    );
    report.head(&SCENE_COLUMNS);
    let at = |detail| Play {
        detail,
        cache: CacheUse::Never,
        frames: if bench.small { 8 } else { 240 },
    };
    let one = DetailGoal::Tolerance(1.0);
    let merged = bench.scenes.play(&still, at(one))?;
    for (name, detail, most_ms) in [
        (
            "every joint of who is seen",
            DetailGoal::Tolerance(0.0),
            None,
        ),
        ("merged levels within 1 px", one, Some(0.8)),
    ] {
        let outcome = bench.scenes.play(&still, at(detail))?;
        let name = format!("plaza, {name}");
        row(report, count, &name, &outcome);
        targets(report, &name, &outcome, most_ms);
        let percent = 100.0 * selection_share(&outcome);
        report.at_most(&name, "selection / evaluation, %", 10.0, percent);
    }
    for (name, cache, most_ms) in [
        (
            "cheapest within 1 px, palettes by the CPU",
            CacheUse::Cpu,
            0.8,
        ),
        (
            "cheapest within 1 px, records for the GPU",
            CacheUse::Gpu,
            0.25,
        ),
    ] {
        let play = Play { cache, ..at(one) };
        let outcome = bench.scenes.play(&still, play)?;
        let name = format!("plaza, {name}");
        row(report, count, &name, &outcome);
        targets(report, &name, &outcome, Some(most_ms));
    }
    moving(bench, report, at(one))?;
    many(bench, report, at(one))?;
    budget(bench, report, &still, &merged)?;
    Ok(AtOnePixel {
        ms: merged.frame_ms.median,
        p95_px: merged.error_px.p95,
        near_px: merged.error_px.near_max,
    })
}

/// The plaza with a moving camera and cross-fades, with phases that differ and that agree.
fn moving(bench: &Bench, report: &mut CrowdTables, usual: Play) -> Result<()> {
    let count = if bench.small { 400 } else { PLAZA_COUNT };
    for (name, kind) in [("distinct", Plaza::Moving), ("equal", Plaza::InPhase)] {
        let moving = Arc::new(plaza(count, &[bench.asset.clips.len()], SEED, kind));
        let play = Play {
            frames: lap_frames(bench, &moving),
            cache: CacheUse::Cpu,
            ..usual
        };
        let outcome = bench.scenes.play(&moving, play)?;
        let name = format!("plaza-2, cheapest within 1 px, {name} phases");
        row(report, count, &name, &outcome);
        targets(report, &name, &outcome, Some(1.0));
        let ratio = outcome.frame_ms.p95 / outcome.frame_ms.median;
        report.at_most(&name, "p95 of frames / median", 1.5, ratio);
    }
    Ok(())
}

/// The plaza with ten and a hundred times as many characters, as records.
fn many(bench: &Bench, report: &mut CrowdTables, usual: Play) -> Result<()> {
    let mut select_ms = Vec::new();
    for (times, most_ms) in [(1, 0.25), (10, 2.5), (100, 16.0)] {
        let count = times * if bench.small { 40 } else { PLAZA_COUNT };
        let clips = [bench.asset.clips.len()];
        let scene = Arc::new(plaza(count, &clips, SEED, Plaza::Still));
        let play = Play {
            frames: if bench.small { 8 } else { 120 },
            cache: CacheUse::Gpu,
            ..usual
        };
        let outcome = bench.scenes.play(&scene, play)?;
        select_ms.push(outcome.tick_ms.median);
        if times == 1 {
            continue;
        }
        let name = format!("plaza of {count}, records for the GPU");
        row(report, count, &name, &outcome);
        report.at_most(&name, "median frame, ms", most_ms, outcome.frame_ms.median);
        errors(report, &name, &outcome);
    }
    let growth = select_ms[1] / select_ms[0].max(1e-9);
    report.at_most(
        "plaza, records for the GPU",
        "selection, ten times as many characters",
        12.0,
        growth,
    );
    Ok(())
}

/// Frames of one lap of the camera at 60 Hz, or of a part of it in a small run.
fn lap_frames(bench: &Bench, scene: &Scene) -> usize {
    if bench.small {
        8
    } else {
        (DISPLAY_HZ * scene.loop_secs()) as usize
    }
}

/// Bounds on a scene; `most_ms` bounds the median time of a frame.
fn targets(report: &mut CrowdTables, name: &str, outcome: &SceneMeasurement, most_ms: Option<f64>) {
    if let Some(most_ms) = most_ms {
        report.at_most(name, "median frame, ms", most_ms, outcome.frame_ms.median);
    }
    report.at_most(name, "selection, ms", 0.1, outcome.tick_ms.median);
    errors(report, name, outcome);
}

/// Bounds on the error at a tolerance of one pixel.
fn errors(report: &mut CrowdTables, name: &str, outcome: &SceneMeasurement) {
    let (p95, near) = (outcome.error_px.p95, outcome.error_px.near_max);
    report.at_most(name, "p95 error, px", 1.0, p95);
    report.at_most(name, "max error within 20 m, px", 2.0, near);
}

fn row(report: &mut CrowdTables, count: usize, name: &str, outcome: &SceneMeasurement) {
    let (median, p95) = (outcome.frame_ms.median, outcome.frame_ms.p95);
    let least = outcome.over_time.iter().map(|(_, ms)| *ms);
    let memory = outcome.working_set;
    let resident =
        memory.state_bytes + memory.clips_bytes + memory.output_bytes + memory.cache_bytes;
    report.row(&[
        name.to_owned(),
        format!("{median:.3}"),
        format!("{p95:.3}"),
        format!("{:.0} %", 100.0 * selection_share(outcome)),
        outcome.visible.to_string(),
        (count - outcome.visible).to_string(),
        format!("{:.0}", outcome.poses.own),
        format!("{:.1}", outcome.written_mb.median),
        format!("{:.1}", 1e-6 * resident as f64),
        format!("{:.2}", outcome.error_px.p95),
        format!("{:.2}", outcome.error_px.near_max),
    ]);
    report.csv.push_str(&format!(
        "plaza,{},{count},frame of all; p95 {:.3} px; near {:.3} px; {:.2} MB,{:.0},{:.0},\n",
        name.replace(',', ";"),
        outcome.error_px.p95,
        outcome.error_px.near_max,
        outcome.written_mb.median,
        1e6 * median,
        1e6 * least.fold(f64::INFINITY, f64::min),
    ));
}

/// The same crowd under budgets of evaluation time, and the overruns of its frames.
fn budget(
    bench: &Bench,
    report: &mut CrowdTables,
    scene: &Arc<Scene>,
    merged: &SceneMeasurement,
) -> Result<()> {
    report.heading(
        "Under a budget",
        "The same plaza with a budget for the whole frame, as a fraction of the time of a frame of \
         merged levels within 1 px. Overrun: 95th percentile over frames of the time beyond the \
         budget.",
    );
    report.head(&[
        "palettes",
        "share",
        "budget, ms",
        "used, ms",
        "overrun, p95",
        "p95, px",
        "max within 20 m, px",
    ]);
    let demand_ms = merged.frame_ms.median;
    let uses = [("by the CPU", CacheUse::Cpu), ("as records", CacheUse::Gpu)];
    let shares = [2.0, 1.0, 0.75, 0.5, 0.3];
    let all = uses.into_iter().flat_map(|u| shares.map(|s| (u, s)));
    for ((palettes, cache), share) in all {
        let budget_ms = share * demand_ms;
        let play = Play {
            detail: DetailGoal::Budget {
                ms: budget_ms as f32,
                cap_px: 1.0,
            },
            cache,
            frames: if bench.small { 8 } else { 240 },
        };
        let outcome = bench.scenes.play(scene, play)?;
        let over = outcome.overrun_p95.unwrap_or(0.0);
        let used_ms = outcome.frame_ms.median;
        let name = format!("budget of {share:.2}, palettes {palettes}");
        report.at_most(&name, "p95 overrun, %", 5.0, 100.0 * over);
        errors(report, &name, &outcome);
        report.row(&[
            palettes.to_owned(),
            format!("{share:.2}"),
            format!("{budget_ms:.3}"),
            format!("{used_ms:.3}"),
            format!("{:+.1} %", 100.0 * over),
            format!("{:.2}", outcome.error_px.p95),
            format!("{:.2}", outcome.error_px.near_max),
        ]);
        report.csv.push_str(&format!(
            "budget,ours,{},palettes {palettes}; share {share}; overrun {:.4}; p95 {:.3} px; near {:.3} px,{:.0},,\n",
            scene.members.len(),
            over,
            outcome.error_px.p95,
            outcome.error_px.near_max,
            1e6 * used_ms
        ));
    }
    Ok(())
}
