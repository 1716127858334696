//! The two passes over a scene: timed, then measured.
//!
//! The second pass repeats every decision of the first, so it shows the same palettes; measuring
//! takes no time and no cache from the timed pass.

use super::faces::{MorphTally, MorphUse};
use super::roles::{RoleError, RoleTally};
use super::stage::{DISPLAY_HZ, Settings, TimedCrowd};
use super::timing::{Spread, thread_ns};
use crate::console::Console;
use articula::build::Scene;
use articula::crowd::{
    Budget, BudgetReport, CharacterError, Crowd, CrowdAsset, CrowdReport, DetailGoal, ErrorMeter,
    ErrorSample, ErrorSummary, LevelStatistics, LevelTally, PaletteHash, ScenePlayer,
};
use serde::Serialize;
use std::sync::Arc;
use std::time::Instant;

/// Frames before the first one that counts, at a standstill, in which levels and caches settle
/// and costs are learnt.
const WARM_UP_FRAMES: usize = 30;

/// Number of frames at which true errors are measured, spread over the run.
const LOOKS: usize = 16;

/// Times of one frame.
#[derive(Debug, Clone, Copy)]
struct FrameTime {
    cpu_ns: f64,
    wall_ns: f64,
    tick_ns: f64,
}

/// Result of a run.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) frames: usize,
    pub(crate) visible: Spread,
    pub(crate) in_cull_margin: Spread,
    /// Characters that are wholly hidden by others or by walls.
    pub(crate) occluded: Spread,
    /// Processor time of a frame, all threads together, milliseconds.
    pub(crate) frame_ms: Spread,
    /// Wall-clock time of a frame, milliseconds.
    pub(crate) wall_ms: Spread,
    /// Processor time of a frame before evaluation, milliseconds.
    pub(crate) tick_ms: Spread,
    /// Time beyond the budget as a fraction of it, 95th percentile over frames.
    pub(crate) overrun_p95: Option<f64>,
    pub(crate) budget: Option<BudgetFound>,
    pub(crate) written_mb: Spread,
    pub(crate) memory: Memory,
    pub(crate) poses: Poses,
    pub(crate) morphs: MorphUse,
    /// Maximum error in pixels by which levels and sources of poses were chosen.
    pub(crate) bound_px: Option<f32>,
    /// Levels of each character of the cast.
    pub(crate) tiers: Vec<Vec<LevelStatistics>>,
    pub(crate) error: ErrorSummary,
    pub(crate) roles: Vec<RoleError>,
    pub(crate) hash: String,
    /// Time of the scene in seconds and time of the frame in milliseconds, for each frame.
    pub(crate) over_time: Vec<(f64, f64)>,
    /// Errors at the sampled frames.
    pub(crate) looks: Vec<ErrorSample>,
}

/// Poses evaluated in a frame, on average.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub(crate) struct Poses {
    /// Evaluated.
    pub(crate) own: f64,
    /// Evaluated poses that blend two clips.
    pub(crate) blended: f64,
    /// Poses blended from the pose cache, by the CPU or by the GPU.
    pub(crate) cached: f64,
    /// Shown from the cache as they are.
    pub(crate) stepped: f64,
}

/// Memory of a crowd.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Memory {
    pub(crate) clips_bytes: usize,
    /// The pose cache.
    pub(crate) cache_bytes: usize,
    /// Palettes, records and morph target weights of the largest frame.
    pub(crate) output_bytes: usize,
    pub(crate) state_bytes: usize,
    pub(crate) state_bytes_per_character: usize,
}

/// Result of a budget over the frames that count.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub(crate) struct BudgetFound {
    /// Expected time of a frame, mean, milliseconds.
    pub(crate) expected_ms: f64,
    /// Tolerance of a frame, pixels.
    pub(crate) tolerance_px: Spread,
    /// Greatest tolerance of any frame, pixels.
    pub(crate) worst_px: f32,
    /// Frames for which the budget did not suffice for the error cap.
    pub(crate) overloaded: usize,
}

/// Plays a scene twice: once for its time, once for its errors.
pub(crate) fn run(
    cast: &[CrowdAsset],
    scene: &Arc<Scene>,
    settings: Settings,
    seed: u64,
    console: &Console,
) -> anyhow::Result<Run> {
    let (times, budgets) = timed(cast, scene, settings, console)?;
    let tolerances: Vec<f32> = budgets.iter().map(|b| b.px).collect();
    let mut found = looked_at(cast, scene, settings, &tolerances, (seed, console))?;
    found.budget = budget_of(&budgets);
    let ms = |of: &dyn Fn(&FrameTime) -> f64| Spread::of(times.iter().map(|t| of(t) / 1e6));
    found.frame_ms = ms(&|t| t.cpu_ns);
    found.wall_ms = ms(&|t| t.wall_ns);
    found.tick_ms = ms(&|t| t.tick_ns);
    let frame = |(i, t): (usize, &FrameTime)| (i as f64 / DISPLAY_HZ, t.cpu_ns / 1e6);
    found.over_time = times.iter().enumerate().map(frame).collect();
    if let DetailGoal::Budget { ms, .. } = settings.detail {
        let over = |t: &FrameTime| (t.cpu_ns / 1e6 / f64::from(ms) - 1.0).max(0.0);
        found.overrun_p95 = Some(Spread::of(times.iter().map(over)).p95);
    }
    Ok(found)
}

/// Time since the previous frame, seconds.
fn step_secs(frame: usize) -> f64 {
    // No time passes during warm-up; the first frame that counts is that of time 0.
    if frame > WARM_UP_FRAMES {
        1.0 / DISPLAY_HZ
    } else {
        0.0
    }
}

fn timed(
    cast: &[CrowdAsset],
    scene: &Arc<Scene>,
    settings: Settings,
    console: &Console,
) -> anyhow::Result<(Vec<FrameTime>, Vec<BudgetReport>)> {
    let mut stage = TimedCrowd::new(cast, scene.clone(), settings)?;
    let budget = match settings.detail {
        DetailGoal::Budget { ms, cap_px } => Some(Budget::new(1e6 * f64::from(ms), cap_px)),
        _ => None,
    };
    let bar = console.progress("playing", 1);
    let played = stage.on_threads(|stage| play(stage, budget, settings.frames));
    bar.finish_and_clear();
    played
}

/// Times and budgets of the frames.
fn play(
    stage: &mut TimedCrowd,
    mut budget: Option<Budget>,
    frames: usize,
) -> anyhow::Result<(Vec<FrameTime>, Vec<BudgetReport>)> {
    let mut budgets = Vec::new();
    let mut times = Vec::with_capacity(frames);
    for frame in 0..WARM_UP_FRAMES + frames {
        let (clock, start) = (Instant::now(), thread_ns());
        let px = budget.as_ref().map(Budget::px);
        let (_, others_ns) = stage.plan(step_secs(frame), px)?;
        if let Some(budget) = &mut budget {
            stage.scene.add_to(budget);
        }
        let tick_ns = (thread_ns() - start + others_ns) as f64;
        let evaluate_ns = stage.evaluate() as f64;
        let start = thread_ns();
        if let Some(budget) = &mut budget {
            budgets.push(budget.observe(tick_ns, evaluate_ns));
        }
        let tick_ns = tick_ns + (thread_ns() - start) as f64;
        if frame >= WARM_UP_FRAMES {
            times.push(FrameTime {
                cpu_ns: tick_ns + evaluate_ns,
                wall_ns: clock.elapsed().as_nanos() as f64,
                tick_ns,
            });
        }
    }
    Ok((times, budgets))
}

fn looked_at(
    cast: &[CrowdAsset],
    scene: &Arc<Scene>,
    settings: Settings,
    tolerances: &[f32],
    (seed, console): (u64, &Console),
) -> anyhow::Result<Run> {
    let mut stage = TimedCrowd::new(cast, scene.clone(), settings)?;
    let mut watched: Vec<Watched<'_>> = cast.iter().map(|a| Watched::new(a, seed)).collect();
    let mut hash = PaletteHash::default();
    let mut roles = RoleTally::new(scene);
    let mut morph_bytes = 0;
    let mut occluded = Vec::with_capacity(settings.frames);
    let mut reports = Vec::with_capacity(settings.frames);
    let looks = settings.frames.min(LOOKS);
    let mut looked = Vec::with_capacity(looks);
    let bar = console.progress("measuring errors", looks);
    for frame in 0..WARM_UP_FRAMES + settings.frames {
        let px = tolerances.get(frame).copied();
        let (report, _) = stage.on_threads(|stage| stage.plan(step_secs(frame), px))?;
        let Some(counted) = frame.checked_sub(WARM_UP_FRAMES) else {
            continue;
        };
        stage.on_threads(TimedCrowd::evaluate);
        occluded.push(stage.scene.hidden() as f64);
        let (mut bytes, mut weights) = (0, 0);
        for (watched, player) in watched.iter_mut().zip(stage.scene.crowds()) {
            hash.add(player);
            watched.tally.add(player);
            watched.faces.add(player);
            let list = player.crowd().draw_list();
            let form = player.asset().model().parts().form;
            let drawn = size_of_val(player.records()) + size_of_val(player.stepped());
            let drawn = drawn + size_of_val(player.impostors());
            bytes += list.matrices * form.bytes() + drawn;
            weights += size_of_val(player.morph_weights());
        }
        morph_bytes = weights.max(morph_bytes);
        reports.push((report, bytes + weights));
        // The first frame, then at even intervals.
        if counted * looks / settings.frames >= looked.len() && looked.len() < looks {
            let sample = look(&stage.scene, &mut watched)?;
            roles.add(&stage.scene, &sample);
            looked.push(sample);
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    let of = |value: &dyn Fn(&CrowdReport) -> f64| Spread::of(reports.iter().map(|r| value(&r.0)));
    let mean = |value: &dyn Fn(&CrowdReport) -> usize| {
        reports.iter().map(|r| value(&r.0) as f64).sum::<f64>() / reports.len().max(1) as f64
    };
    let bound = reports.iter().map(|r| r.0.bound_px).fold(0.0, f32::max);
    Ok(Run {
        frames: settings.frames,
        visible: of(&|r| r.visible as f64),
        in_cull_margin: of(&|r| r.in_margin as f64),
        occluded: Spread::of(occluded),
        frame_ms: Spread::default(),
        wall_ms: Spread::default(),
        tick_ms: Spread::default(),
        overrun_p95: None,
        budget: None,
        written_mb: Spread::of(reports.iter().map(|r| r.1 as f64 / 1e6)),
        memory: memory(cast, scene, reports.iter().map(|r| r.1).max().unwrap_or(0)),
        poses: Poses {
            own: mean(&|r| r.own),
            blended: mean(&|r| r.blended),
            cached: mean(&|r| r.cached),
            stepped: mean(&|r| r.stepped),
        },
        morphs: MorphUse::of(watched.iter().map(Watched::faces), morph_bytes),
        // In full detail nothing is chosen by its error.
        bound_px: (settings.detail != DetailGoal::Full).then_some(bound),
        tiers: watched.iter().map(Watched::levels).collect(),
        error: ErrorSummary::of(&looked),
        roles: roles.roles(scene),
        hash: hash.text(),
        over_time: Vec::new(),
        looks: looked,
    })
}

/// What is noted about the crowd of one character.
struct Watched<'a> {
    asset: &'a CrowdAsset,
    meter: ErrorMeter,
    tally: LevelTally,
    faces: MorphTally,
    /// Errors at the sampled frames.
    looks: Vec<ErrorSample>,
}

impl<'a> Watched<'a> {
    fn new(asset: &'a CrowdAsset, seed: u64) -> Self {
        Self {
            asset,
            meter: ErrorMeter::new(asset, seed),
            tally: LevelTally::new(asset),
            faces: MorphTally::new(asset),
            looks: Vec::new(),
        }
    }

    fn levels(&self) -> Vec<LevelStatistics> {
        self.tally.levels(self.asset, &self.looks)
    }

    fn faces(&self) -> MorphUse {
        self.faces.means(self.asset)
    }
}

/// Measures all crowds of a scene; the characters of the sample are the members of the scene.
fn look(scene: &ScenePlayer, watched: &mut [Watched<'_>]) -> anyhow::Result<ErrorSample> {
    let secs = scene.secs();
    let mut all = ErrorSample {
        secs,
        characters: Vec::new(),
    };
    for (c, (watched, player)) in watched.iter_mut().zip(scene.crowds()).enumerate() {
        let sample = watched.meter.measure(player, secs, &scene.error_views(c)?);
        let members = sample.characters.iter().map(|e| CharacterError {
            character: scene.member(c, e.character),
            ..*e
        });
        all.characters.extend(members);
        watched.looks.push(sample);
    }
    Ok(all)
}

fn memory(cast: &[CrowdAsset], scene: &Scene, output_bytes: usize) -> Memory {
    let parts = || cast.iter().map(|asset| asset.model().parts());
    Memory {
        clips_bytes: parts().map(|p| p.clips.bytes()).sum(),
        output_bytes,
        cache_bytes: parts()
            .filter_map(|p| Some(p.cache.as_ref()?.bytes()))
            .sum(),
        state_bytes: Crowd::BYTES_PER_CHARACTER * scene.members.len(),
        state_bytes_per_character: Crowd::BYTES_PER_CHARACTER,
    }
}

/// Sums up the reports of a budget over the frames that count; `None` without a budget.
fn budget_of(reports: &[BudgetReport]) -> Option<BudgetFound> {
    let reports = reports.get(WARM_UP_FRAMES..)?;
    let expected: f64 = reports.iter().map(|r| r.expected_ns).sum();
    Some(BudgetFound {
        expected_ms: expected / reports.len().max(1) as f64 / 1e6,
        tolerance_px: Spread::of(reports.iter().map(|r| f64::from(r.px))),
        worst_px: reports.iter().map(|r| r.px).fold(0.0, f32::max),
        overloaded: reports.iter().filter(|r| r.is_overloaded()).count(),
    })
}
