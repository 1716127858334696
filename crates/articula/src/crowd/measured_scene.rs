//! Cost and error of a scene: played twice, once timed and once measured.
//!
//! The second pass repeats every decision of the first, so it shows the same palettes; measuring
//! takes no time and no cache from the timed pass.

use super::asset::CrowdAsset;
use super::budget_use::{BudgetUse, Sacrificed};
use super::level_use::{DrawCost, LevelStatistics, LevelTally};
use super::lod_error::{CharacterError, ErrorMeter, ErrorSample, ErrorSummary};
use super::measure_options::{FrameClocks, MeasureOptions};
use super::morph_use::{MorphTally, MorphUse};
use super::palette_hash::PaletteHash;
use super::role_errors::RoleTally;
use super::scene_measurement::{CrowdMemory, DISPLAY_HZ, PoseUse, SceneMeasurement};
use super::scene_player::DetailGoal;
use super::spread::Spread;
use super::timed_scene::TimedScene;
use crate::error::Result;
use crate::work::Executor;
use articula_build::Scene;
use articula_core::crowd::{Allowance, Budget, BudgetReport, Crowd, CrowdReport};
use std::sync::Arc;

/// Frames before the first one that counts, at a standstill, in which levels and caches settle
/// and costs are learnt.
const WARM_UP_FRAMES: usize = 30;

/// Number of frames at which true errors are measured, spread over the run.
const SAMPLED_FRAMES: usize = 16;

/// Times of one frame.
#[derive(Debug, Clone, Copy)]
struct FrameTime {
    cpu_ns: f64,
    wall_ns: f64,
    tick_ns: f64,
}

/// Plays a scene twice, once for its time and once for its errors, after a standstill of half a second.
/// `characters` has the asset of each character of the scene.
///
/// The executor runs the parts of a frame as jobs if the options have several threads; times do not
/// depend on other programs as long as `clocks.thread_ns` is the processor time of a thread.
///
/// # Errors
/// Those of [`ScenePlayer::new`](super::ScenePlayer::new) and [`ScenePlayer::plan`](super::ScenePlayer::plan), and
/// [`Error::Cancelled`](crate::Error::Cancelled).
pub fn measure_scene(
    characters: &[CrowdAsset],
    scene: &Arc<Scene>,
    options: &MeasureOptions,
    clocks: FrameClocks<'_>,
    work: &Executor<'_>,
) -> Result<SceneMeasurement> {
    let mut timed = TimedScene::new(characters, scene, options, clocks, work)?;
    work.step("playing", 0, 1)?;
    let (times, budgets) = play(&mut timed, options, clocks.wall_ns)?;
    let allowed: Vec<Allowance> = budgets.iter().map(|b| b.shown).collect();
    let shown = TimedScene::new(characters, scene, options, clocks, work)?;
    let mut pass = MeasuredPass::new(characters, shown, options);
    pass.run(&allowed, work)?;
    Ok(pass.measurement(&times, budget_of(&budgets)))
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

/// Times and budgets of the frames.
fn play(
    timed: &mut TimedScene<'_>,
    options: &MeasureOptions,
    wall_ns: &dyn Fn() -> u64,
) -> Result<(Vec<FrameTime>, Vec<BudgetReport>)> {
    let mut budget = match options.scene.detail {
        DetailGoal::Budget { ms, cap_px } => Some(Budget::new(1e6 * f64::from(ms), cap_px)),
        _ => None,
    };
    let mut budgets = Vec::new();
    let mut times = Vec::with_capacity(options.frames);
    // A budget is a part of the next frame that it is told of.
    let mut observing_ns = 0.0;
    for frame in 0..WARM_UP_FRAMES + options.frames {
        let (wall, start) = (wall_ns(), timed.thread_ns());
        let allowed = budget.as_ref().map(Budget::allowance);
        let (_, others_ns) = timed.plan(step_secs(frame), allowed)?;
        if let Some(budget) = &mut budget {
            timed.player.add_to(budget);
        }
        let tick_ns = (timed.thread_ns() - start + others_ns) as f64;
        let evaluate_ns = timed.evaluate() as f64;
        let start = timed.thread_ns();
        if let Some(budget) = &mut budget {
            budgets.push(budget.observe(tick_ns + observing_ns, evaluate_ns));
        }
        observing_ns = (timed.thread_ns() - start) as f64;
        let tick_ns = tick_ns + observing_ns;
        if frame >= WARM_UP_FRAMES {
            times.push(FrameTime {
                cpu_ns: tick_ns + evaluate_ns,
                wall_ns: (wall_ns() - wall) as f64,
                tick_ns,
            });
        }
    }
    Ok((times, budgets))
}

/// The second pass, and what it has found so far.
struct MeasuredPass<'a> {
    timed: TimedScene<'a>,
    options: &'a MeasureOptions,
    characters: Vec<MeasuredCharacter<'a>>,
    hash: PaletteHash,
    roles: RoleTally,
    samples: Vec<ErrorSample>,
    frames: Vec<FrameUse>,
}

/// Use of one frame.
struct FrameUse {
    report: CrowdReport,
    occluded: usize,
    /// Bytes of palettes, records, draws and weights.
    bytes: usize,
    /// Those of weights alone.
    weight_bytes: usize,
}

impl<'a> MeasuredPass<'a> {
    fn new(
        characters: &'a [CrowdAsset],
        timed: TimedScene<'a>,
        options: &'a MeasureOptions,
    ) -> Self {
        let measured = |asset| MeasuredCharacter::new(asset, options.seed);
        Self {
            characters: characters.iter().map(measured).collect(),
            hash: PaletteHash::default(),
            roles: RoleTally::new(timed.player.scene()),
            samples: Vec::new(),
            frames: Vec::with_capacity(options.frames),
            timed,
            options,
        }
    }

    fn run(&mut self, allowed: &[Allowance], work: &Executor<'_>) -> Result<()> {
        let frames = self.options.frames;
        let count = frames.min(SAMPLED_FRAMES);
        for frame in 0..WARM_UP_FRAMES + frames {
            let allowance = allowed.get(frame).copied();
            let (report, _) = self.timed.plan(step_secs(frame), allowance)?;
            let Some(counted) = frame.checked_sub(WARM_UP_FRAMES) else {
                continue;
            };
            self.timed.evaluate();
            self.add(report);
            // The first frame, then at even intervals.
            let done = self.samples.len();
            if counted * count / frames >= done && done < count {
                work.step("measuring errors", done, count)?;
                self.sample()?;
            }
        }
        Ok(())
    }

    /// Adds an evaluated frame.
    fn add(&mut self, report: CrowdReport) {
        let player = &self.timed.player;
        let (mut bytes, mut weight_bytes) = (0, 0);
        for (character, crowd) in self.characters.iter_mut().zip(player.crowds()) {
            self.hash.add(crowd);
            character.levels.add(crowd);
            character.morphs.add(crowd);
            let form = crowd.asset().model().parts().form;
            let drawn = size_of_val(crowd.records()) + size_of_val(crowd.stepped());
            let drawn = drawn + size_of_val(crowd.impostors());
            bytes += crowd.crowd().draw_list().matrices * form.bytes() + drawn;
            weight_bytes += size_of_val(crowd.morph_weights());
        }
        self.frames.push(FrameUse {
            report,
            occluded: player.hidden(),
            bytes: bytes + weight_bytes,
            weight_bytes,
        });
    }

    /// Measures all crowds; the characters of the sample are the members of the scene.
    fn sample(&mut self) -> Result<()> {
        let player = &self.timed.player;
        let secs = player.secs();
        let mut all = ErrorSample {
            secs,
            characters: Vec::new(),
        };
        for (c, (character, crowd)) in self.characters.iter_mut().zip(player.crowds()).enumerate() {
            let sample = character
                .meter
                .measure(crowd, secs, &player.error_views(c)?);
            let members = sample.characters.iter().map(|error| CharacterError {
                character: player.member(c, error.character),
                ..*error
            });
            all.characters.extend(members);
            character.samples.push(sample);
        }
        self.roles.add(player, &all);
        self.samples.push(all);
        Ok(())
    }

    fn measurement(self, times: &[FrameTime], budget: Option<BudgetUse>) -> SceneMeasurement {
        let scene = self.timed.player.scene();
        let frames = &self.frames;
        let of = |value: &dyn Fn(&FrameUse) -> f64| Spread::of(frames.iter().map(value));
        let count = |value: &dyn Fn(&FrameUse) -> usize| {
            of(&|frame| value(frame) as f64).median.round() as usize
        };
        let ms = |of: &dyn Fn(&FrameTime) -> f64| Spread::of(times.iter().map(|t| of(t) / 1e6));
        let characters = scene.members.len();
        let visible = count(&|f| f.report.visible);
        let occluded = count(&|f| f.occluded);
        // Who is occluded counts as in the margin for a frame.
        let in_cull_margin = count(&|f| f.report.in_margin).saturating_sub(occluded);
        let frame_ms = ms(&|t| t.cpu_ns);
        let per_character = |ms: f64| ms * 1e6 / characters.max(1) as f64;
        let budget_ms = match self.options.scene.detail {
            DetailGoal::Budget { ms, .. } => Some(ms),
            _ => None,
        };
        let bound = frames.iter().map(|f| f.report.bound_px).fold(0.0, f32::max);
        let levels = self.characters.iter().map(MeasuredCharacter::levels);
        let levels: Vec<Vec<LevelStatistics>> = levels.collect();
        let weight_bytes = frames.iter().map(|f| f.weight_bytes).max().unwrap_or(0);
        let morphs = self.characters.iter().map(|c| c.morphs.means(c.asset));
        let time = |(i, t): (usize, &FrameTime)| (i as f64 / DISPLAY_HZ, t.cpu_ns / 1e6);
        SceneMeasurement {
            characters,
            visible,
            in_cull_margin,
            hidden: characters.saturating_sub(visible + in_cull_margin + occluded),
            occluded,
            frames: self.options.frames,
            display_hz: DISPLAY_HZ,
            threads: self.options.threads,
            ns_per_character: Spread {
                median: per_character(frame_ms.median),
                p95: per_character(frame_ms.p95),
            },
            characters_per_ms: characters as f64 / frame_ms.median.max(1e-9),
            frame_ms,
            wall_ms: ms(&|t| t.wall_ns),
            tick_ms: ms(&|t| t.tick_ns),
            written_mb: of(&|f| f.bytes as f64 / 1e6),
            working_set: memory(&self.characters, scene, frames),
            poses: pose_use(frames),
            morphs: MorphUse::of(morphs, weight_bytes),
            error_px: ErrorSummary::of(&self.samples),
            roles: self.roles.roles(scene),
            error_bound_px: (self.options.scene.detail != DetailGoal::Full).then_some(bound),
            budget_ms,
            overrun_p95: budget_ms.map(|ms| overrun_p95(times, ms)),
            budget,
            renderer: DrawCost::sum(levels.iter().flatten()),
            levels,
            palette_hash: self.hash.text(),
            over_time: times.iter().enumerate().map(time).collect(),
            samples: self.samples,
        }
    }
}

/// What is noted about the crowd of one character.
struct MeasuredCharacter<'a> {
    asset: &'a CrowdAsset,
    meter: ErrorMeter,
    levels: LevelTally,
    morphs: MorphTally,
    /// Errors at the sampled frames.
    samples: Vec<ErrorSample>,
}

impl<'a> MeasuredCharacter<'a> {
    fn new(asset: &'a CrowdAsset, seed: u64) -> Self {
        Self {
            asset,
            meter: ErrorMeter::new(asset, seed),
            levels: LevelTally::new(asset),
            morphs: MorphTally::new(asset),
            samples: Vec::new(),
        }
    }

    fn levels(&self) -> Vec<LevelStatistics> {
        self.levels.levels(self.asset, &self.samples)
    }
}

fn memory(characters: &[MeasuredCharacter<'_>], scene: &Scene, frames: &[FrameUse]) -> CrowdMemory {
    let parts = || characters.iter().map(|c| c.asset.model().parts());
    let caches = parts().filter_map(|p| Some(p.cache.as_ref()?.bytes()));
    CrowdMemory {
        clips_bytes: parts().map(|p| p.clips.bytes()).sum(),
        output_bytes: frames.iter().map(|f| f.bytes).max().unwrap_or(0),
        cache_bytes: caches.sum(),
        state_bytes: Crowd::BYTES_PER_CHARACTER * scene.members.len(),
        state_bytes_per_character: Crowd::BYTES_PER_CHARACTER,
    }
}

fn pose_use(frames: &[FrameUse]) -> PoseUse {
    let mean = |value: &dyn Fn(&CrowdReport) -> usize| {
        let sum: f64 = frames.iter().map(|f| value(&f.report) as f64).sum();
        sum / frames.len().max(1) as f64
    };
    PoseUse {
        own: mean(&|r| r.own),
        blended: mean(&|r| r.blended),
        cached: mean(&|r| r.cached),
        stepped: mean(&|r| r.stepped),
    }
}

fn overrun_p95(times: &[FrameTime], budget_ms: f32) -> f64 {
    let over = |t: &FrameTime| (t.cpu_ns / 1e6 / f64::from(budget_ms) - 1.0).max(0.0);
    Spread::of(times.iter().map(over)).p95
}

/// Sums up the reports of a budget over the frames that count; `None` without a budget.
fn budget_of(reports: &[BudgetReport]) -> Option<BudgetUse> {
    let reports = reports.get(WARM_UP_FRAMES..)?;
    let count = |is: &dyn Fn(&BudgetReport) -> bool| reports.iter().filter(|r| is(r)).count();
    let mean_ms = |ns: &dyn Fn(&BudgetReport) -> f64| {
        let sum: f64 = reports.iter().map(ns).sum();
        sum / reports.len().max(1) as f64 / 1e6
    };
    let satisfied = count(&|r| r.is_satisfied());
    Some(BudgetUse {
        budget_satisfied: satisfied == reports.len(),
        satisfied,
        expected_ms: mean_ms(&|r| r.expected_ns),
        floor_ms: mean_ms(&|r| r.floor_ns),
        tolerance_px: Spread::of(reports.iter().map(|r| f64::from(r.shown.px))),
        worst_px: reports.iter().map(|r| r.shown.px).fold(0.0, f32::max),
        near_px: reports
            .iter()
            .map(|r| r.shown.px_of_near())
            .fold(0.0, f32::max),
        overloaded: count(&|r| r.is_overloaded()),
        sacrificed: Sacrificed {
            triangles: count(&|r| r.sacrifice().triangles),
            pixels: count(&|r| r.sacrifice().pixels),
            time: count(&|r| r.sacrifice().time),
        },
    })
}
