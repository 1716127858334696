//! Frames of the plaza on one and on two threads, beside the floor on one and on two.
//!
//! Times are wall-clock times: processor time does not show what a thread waits for.

use super::stage::Play;
use super::{Bench, CrowdTables, SEED};
use crate::measure::median;
use crate::peers::floor::{Floor, Sampled};
use anyhow::{Context, Result};
use articula::crowd::{CacheUse, CrowdSection, DISPLAY_HZ, DetailGoal, FramePart, ScenePlayer};
use articula_build::{PLAZA_COUNT, Plaza, plaza};
use rayon::prelude::*;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

/// Gain of two threads that is expected where no memory bus bounds it.
const GAIN: f64 = 1.85;
const THREADS: usize = 2;
/// Parts of a frame for each thread.
const PARTS: usize = 8;
const STEP_SECS: f64 = 1.0 / DISPLAY_HZ;

/// Median milliseconds of a frame on one thread and on two.
#[derive(Clone, Copy)]
struct Times {
    one_ms: f64,
    two_ms: f64,
}

impl Times {
    fn gain(self) -> f64 {
        self.one_ms / self.two_ms.max(1e-9)
    }
}

/// Adds the section.
pub(super) fn add(bench: &Bench, report: &mut CrowdTables) -> Result<()> {
    let (count, more, frames) = match bench.small {
        true => (400, 800, 4),
        false => (PLAZA_COUNT, 10 * PLAZA_COUNT, 300),
    };
    report.heading(
        "On two threads",
        "Milliseconds of wall-clock time of a whole frame of the plaza, tick and evaluation, medians \
         of turns; the floor evaluates every character. Memory bounds the frames that write most, and \
         waking a thread the shortest ones, as they do the floor. So a gain of 1.85 is expected, or that \
         of the floor whose time on one thread is nearest.",
    );
    report.head(&["frame", "characters", "one thread, ms", "two, ms", "gain"]);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(THREADS);
    let pool = pool.build().context("threads")?;
    let mut floors = Vec::new();
    for count in [count, count / 10, count / 20] {
        let times = pool.install(|| floor(bench, count, frames))?;
        row(report, "floor, 3x4 f32", count, times);
        floors.push(times);
    }
    let one = DetailGoal::Tolerance(1.0);
    for (name, count, detail, cache) in [
        (
            "every joint of who is seen",
            count,
            DetailGoal::Tolerance(0.0),
            CacheUse::Never,
        ),
        ("merged levels within 1 px", count, one, CacheUse::Never),
        (
            "cheapest within 1 px, palettes by the CPU",
            count,
            one,
            CacheUse::Cpu,
        ),
        (
            "cheapest within 1 px, records for the GPU",
            count,
            one,
            CacheUse::Gpu,
        ),
        (
            "cheapest within 1 px, records for the GPU",
            more,
            one,
            CacheUse::Gpu,
        ),
    ] {
        let clips = [bench.asset.clips.len()];
        let scene = Arc::new(plaza(count, &clips, SEED, Plaza::Still));
        let play = Play {
            detail,
            cache,
            frames,
        };
        let mut players = [
            bench.scenes.player(&scene, play)?,
            bench.scenes.player(&scene, play)?,
        ];
        let times = pool.install(|| turns(&mut players, frames))?;
        row(report, name, count, times);
        let who = format!("two threads, {name}, {count} characters");
        let apart = |floor: &&Times| (floor.one_ms / times.one_ms).ln().abs();
        let floor = floors.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        let least = floor.map_or(GAIN, |floor| GAIN.min(floor.gain()));
        report.at_least(&who, "gain", round(least), times.gain());
    }
    Ok(())
}

fn row(report: &mut CrowdTables, name: &str, count: usize, times: Times) {
    report.row(&[
        name.to_owned(),
        count.to_string(),
        format!("{:.3}", times.one_ms),
        format!("{:.3}", times.two_ms),
        format!("{:.2}", times.gain()),
    ]);
    report.csv.push_str(&format!(
        "threads,{},{count},two threads: {:.0} ns; gain {:.3},{:.0},,\n",
        name.replace(',', ";"),
        1e6 * times.two_ms,
        times.gain(),
        1e6 * times.one_ms,
    ));
}

/// The floor over all characters, in one half after the other and both at once.
fn floor(bench: &Bench, count: usize, frames: usize) -> Result<Times> {
    let half = count / 2;
    let new = || Floor::new(&bench.asset.rig, bench.clip(), Sampled::Moving);
    let mut floors = [new()?, new()?];
    let mut out = floors
        .each_ref()
        .map(|f| vec![[0.0; 12]; half * f.joints()]);
    let duration = bench.clip().duration_secs();
    let phases = bench.phases(half);
    let (mut one, mut two) = (Vec::new(), Vec::new());
    for frame in 0..frames {
        let at = |phase: &f32| (phase * duration + frame as f32 * STEP_SECS as f32) % duration;
        let secs: Vec<f32> = phases.iter().map(at).collect();
        let [(a, b), (c, d)] = {
            let [f, g] = &mut floors;
            let [o, p] = &mut out;
            [(f, o), (g, p)]
        };
        let start = Instant::now();
        a.store(&secs, b);
        c.store(&secs, d);
        one.push(ms(start));
        let start = Instant::now();
        rayon::join(|| a.store(&secs, b), || c.store(&secs, d));
        two.push(ms(start));
        black_box(&mut out);
    }
    Ok(times(&mut one, &mut two))
}

/// Frames of two equal crowds, by turns: the first on this thread, the second on all.
fn turns([single, spread]: &mut [ScenePlayer; 2], frames: usize) -> Result<Times> {
    let (mut one, mut two) = (Vec::new(), Vec::new());
    for _ in 0..frames {
        let start = Instant::now();
        single.plan(STEP_SECS)?;
        single.evaluate();
        one.push(ms(start));
        let start = Instant::now();
        spread.plan_on(STEP_SECS, |sections, tick| {
            let share = sections.len().div_ceil(PARTS * THREADS).max(1);
            let each = |sections: &mut [CrowdSection]| sections.iter_mut().for_each(tick);
            sections.par_chunks_mut(share).for_each(each);
        })?;
        for crowd in spread.crowds_mut() {
            let mut parts: Vec<FramePart<'_>> = crowd.parts(PARTS * THREADS).collect();
            parts.par_iter_mut().for_each(FramePart::evaluate);
        }
        two.push(ms(start));
    }
    Ok(times(&mut one, &mut two))
}

fn times(one: &mut [f64], two: &mut [f64]) -> Times {
    Times {
        one_ms: median(one),
        two_ms: median(two),
    }
}

/// Two decimal places.
fn round(gain: f64) -> f64 {
    (100.0 * gain).round() / 100.0
}

fn ms(start: Instant) -> f64 {
    1e3 * start.elapsed().as_secs_f64()
}
