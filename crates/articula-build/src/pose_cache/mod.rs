//! Pose cache: baked palettes at key poses of every clip and level of a character, to be blended
//! linearly.
//!
//! Source: `docs/methods/motion-lod.md` part 6, `docs/methods/runtime.md` part 4.1. Each clip and
//! level has as few keys as its tolerance allows. The tolerance is a share of the error of the
//! level itself in that clip, since the two errors add up; fast clips are allowed more as long as
//! the next level alone is worse. Errors are measured on the result, through [`PoseCache`] itself,
//! at twice the rate at which keys were chosen. The cache is filled from the coarsest level up,
//! since most of a crowd is far away.
//!
//! A coarser level keeps the first joints of a finer one, and poses them alike, so its palette is the
//! beginning of the finer one's. Levels of a clip therefore share palettes: those of the finest level
//! that there is room for, at its times, which are as close as it needs.
//!
//! Beside keys, levels have palettes at equal distances in time, each to be shown as it is
//! ([`CachedSteps`]): so many that they too are within the tolerance, or two for each frame of a
//! display. A renderer that blends may blend two of these as well, whose error is measured too.

mod bake;
mod keys;
mod level_error;
mod looks;
mod measure;
mod skins;
mod steps;

use crate::character::Asset;
use crate::joint_lods::MergedLevels;
use articula_core::batch::BatchEvaluator;
use articula_core::{
    Backend, CachedKeys, CachedSteps, ClipSet, Mismatch, PaletteForm, PaletteMap, PoseCache,
};
use bake::{Keys, Steps, bake, bytes_of};
use keys::{Chosen, Ticks, choose};
use measure::{measure_blends, measure_steps};
use skins::Skins;
use steps::wanted_steps;

/// Maximum number of times that a tolerance is doubled for a fast clip.
const MAX_DOUBLINGS: u32 = 3;

/// Options of [`cached_poses`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CacheOptions {
    /// Form of the palettes: [`PaletteForm::Matrix`] or [`PaletteForm::HalfMatrix`], which can be
    /// blended linearly.
    pub form: PaletteForm,
    /// Error that blending may add, as a fraction of the level's own error in the clip. Where keys
    /// would be too close, it is doubled up to three times, as long as both errors together do not
    /// exceed that of the next level.
    pub share: f32,
    /// Error that blending may always add at level 0, in metres; doubled at each further level.
    pub min_metres: f32,
    /// Maximum size of all palettes together, in bytes.
    pub palette_bytes: usize,
    /// Number of vertices that errors are measured on.
    pub vertices: usize,
    /// Seed of the sample of vertices.
    pub seed: u64,
}

impl Default for CacheOptions {
    /// f32 palettes of at most 32 MB; a quarter of the level's own error, but at least 0.5 mm at
    /// level 0, 1 mm at level 1 and so on; 256 of the 700 vertices that level errors are measured on.
    fn default() -> Self {
        Self {
            form: PaletteForm::Matrix,
            share: 0.25,
            min_metres: 0.5e-3,
            palette_bytes: 32_000_000,
            vertices: 256,
            seed: 1,
        }
    }
}

impl CacheOptions {
    /// Tolerances for blending at a level, tightest first, given the errors of all levels of the
    /// clip: the share or the minimum, then doubled as long as both errors together do not exceed
    /// that of the next level.
    pub(crate) fn tolerances_metres(&self, level: usize, errors_metres: &[f32]) -> Vec<f32> {
        let own = errors_metres.get(level).copied().unwrap_or(0.0);
        let next = errors_metres.get(level + 1).copied().unwrap_or(0.0);
        let first = (self.share * own).max(self.min_metres * (1u32 << level) as f32);
        let wider = (1..=MAX_DOUBLINGS).map(|i| first * (1u32 << i) as f32);
        let wider = wider.take_while(|t| own + t <= next);
        std::iter::once(first).chain(wider).collect()
    }
}

/// Whether a clip is cached at a level, and the reason if not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CacheDecision {
    /// In the cache.
    Cached,
    /// Not cached: keys would be two display frames apart or less, or the clip jumps.
    TooFast,
    /// Not cached: not enough space left.
    NoRoom,
}

/// Caching decision, keys and size for one clip at one level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CacheReport {
    /// Index of the clip.
    pub clip: usize,
    /// Index of the level.
    pub level: usize,
    /// Whether the clip is cached at this level.
    pub decision: CacheDecision,
    /// Number of keys that the tolerance requires.
    pub keys: usize,
    /// Size of their palettes in bytes; 0 if they are those of a finer level.
    pub bytes: usize,
    /// Tolerance that the level's own keys are chosen for, in metres; those of a finer level are within a
    /// tighter one.
    pub tolerance_metres: f32,
    /// Error that the cache states, the larger of the 95th percentile over vertices and half of the
    /// maximum, in metres; 0 if not cached.
    pub error_metres: f32,
    /// Maximum error over all vertices, in metres; 0 if not cached.
    pub worst_metres: f32,
    /// Number of palettes at equal distances in time, to be shown as they are; 0 if there are none.
    pub steps: usize,
    /// Size of these palettes in bytes; 0 if they are those of a finer level.
    pub step_bytes: usize,
    /// Error of showing the nearest of them, as of `error_metres`.
    pub step_error_metres: f32,
    /// Error of a blend of the two of them around a time, as of `error_metres`.
    pub step_blend_metres: f32,
    /// Maximum error of such a blend over all vertices, in metres.
    pub step_blend_worst_metres: f32,
}

/// A pose cache and a report of its contents.
#[derive(Debug, Clone, PartialEq)]
pub struct CachedPoses {
    /// The cache.
    pub cache: PoseCache,
    /// Keys of each clip at each level, from which [`cache_of_keys`] makes the same cache; `None`
    /// where poses are evaluated.
    pub keys: Vec<Vec<Option<CachedKeys>>>,
    /// The same of palettes that are shown as they are.
    pub steps: Vec<Vec<Option<CachedSteps>>>,
    /// One entry per clip and level, ordered by clip.
    pub report: Vec<CacheReport>,
}

/// Chooses keys, bakes their palettes with the evaluator of the frame loop and measures the result.
///
/// `clips` are the clips of the character, in the order of its joint LODs. A character without a
/// mesh has no palette, so nothing is cached.
///
/// # Errors
/// A [`Mismatch`] if clips, levels and character do not belong together, the form cannot be blended
/// linearly, or an option is negative or not finite.
pub fn cached_poses(
    asset: &Asset,
    levels: &MergedLevels,
    clips: &ClipSet,
    opts: &CacheOptions,
) -> Result<CachedPoses, Mismatch> {
    check(asset, levels, clips, opts)?;
    let map = &levels.skins.palette;
    let baker = BatchEvaluator::new(clips, map, opts.form, Backend::best())?;
    let mut skins = Skins::new(asset, levels, opts);
    let ticks = ticks_of(asset, clips);
    let mut plan = |reach| -> Result<Vec<Vec<Plan>>, Mismatch> {
        let each = ticks.iter().enumerate();
        let each = each.map(|at| planned(levels, clips, at, (&mut skins, reach), opts));
        each.collect()
    };
    let mut plans = plan(Reach::Finest)?;
    if plans
        .iter()
        .map(|of_clip| finest_bytes(of_clip))
        .sum::<usize>()
        > opts.palette_bytes
    {
        plans = plan(Reach::Every)?;
    }
    allot(&mut plans, opts.palette_bytes);
    let (mut keys, mut steps) = placed(&plans, map);
    let rows = bake(&baker, clips, (&keys, &steps), opts.form)?;
    let unmeasured = PoseCache::new(clips, map, &keys, rows.clone())?.with_steps(clips, &steps)?;
    let all = levels.joint_lods.levels();
    for (clip, ticks) in ticks.iter().enumerate() {
        // The finest level with palettes shares them with all coarser ones.
        let owner = keys[clip].iter().position(Option::is_some).unwrap_or(all);
        let of = (&skins, owner..all);
        let errors = match owner < all {
            true => measure_blends(
                &unmeasured,
                clips,
                (clip, ticks),
                map,
                of,
                PoseCache::locate,
            )?,
            false => Vec::new(),
        };
        let cached = keys[clip].iter_mut().zip(&mut plans[clip]).skip(owner);
        for ((keys, plan), error) in cached.zip(errors) {
            let Some(keys) = keys else { continue };
            keys.error_metres = error.judged_metres();
            plan.report.error_metres = keys.error_metres;
            plan.report.worst_metres = error.worst_metres;
        }
        let owner = steps[clip].iter().position(Option::is_some).unwrap_or(all);
        let count = steps[clip].get(owner).and_then(Option::as_ref);
        let Some(count) = count.map(|steps| steps.count as usize) else {
            continue;
        };
        let ticks = Ticks::of_steps(count, clips.duration_secs(clip));
        let of = (&skins, owner..all);
        let errors = measure_steps(&unmeasured, clips, (clip, &ticks), map, of.clone())?;
        let between = PoseCache::between_steps;
        let blends = measure_blends(&unmeasured, clips, (clip, &ticks), map, of, between)?;
        let stepped = steps[clip].iter_mut().zip(&mut plans[clip]).skip(owner);
        for ((steps, plan), (error, blend)) in stepped.zip(errors.into_iter().zip(blends)) {
            let Some(steps) = steps else { continue };
            steps.error_metres = error.judged_metres();
            steps.blend_error_metres = Some(blend.judged_metres());
            plan.report.step_error_metres = steps.error_metres;
            plan.report.step_blend_metres = blend.judged_metres();
            plan.report.step_blend_worst_metres = blend.worst_metres;
        }
    }
    Ok(CachedPoses {
        cache: PoseCache::new(clips, map, &keys, rows)?.with_steps(clips, &steps)?,
        keys,
        steps,
        report: plans.iter().flatten().map(|p| p.report).collect(),
    })
}

fn check(
    asset: &Asset,
    levels: &MergedLevels,
    clips: &ClipSet,
    opts: &CacheOptions,
) -> Result<(), Mismatch> {
    if clips.joint_lods() != &levels.joint_lods
        || levels.joint_lods.joints().len() != asset.rig.len()
    {
        return Err(Mismatch::new(
            "clips",
            "the clip set was built for other joint LODs",
        ));
    }
    let ends: Vec<f32> = (0..clips.clips()).map(|c| clips.duration_secs(c)).collect();
    let own = asset
        .clips
        .iter()
        .map(|c| (c.frames() - 1) as f32 / c.rate_hz());
    if !own.eq(ends.iter().copied().take(asset.clips.len()))
        || ends.len() != asset.clips.len().max(1)
    {
        return Err(Mismatch::new(
            "clips",
            "the clips are not those of the character",
        ));
    }
    if levels
        .skins
        .levels
        .iter()
        .any(|s| s.positions.len() != asset.mesh.len())
    {
        return Err(Mismatch::new(
            "levels.skins",
            "the skins must belong to the mesh of the character",
        ));
    }
    if opts.form.is_rigid() {
        let what = "quaternions do not blend linearly; choose a matrix form";
        return Err(Mismatch::new("form", what));
    }
    let numbers = [("share", opts.share), ("min_metres", opts.min_metres)];
    for (name, value) in numbers {
        if !value.is_finite() || value < 0.0 {
            return Err(Mismatch::new(name, "must be finite and at least 0"));
        }
    }
    Ok(())
}

/// The time grid of each clip; a single time for a rig without clips.
fn ticks_of(asset: &Asset, clips: &ClipSet) -> Vec<Ticks> {
    let of = |clip: usize| match asset.clips.get(clip) {
        None => Ticks::single(),
        Some(own) => Ticks::new(own.rate_hz(), own.frames(), clips.duration_secs(clip)),
    };
    (0..clips.clips()).map(of).collect()
}

/// Keys of one clip at one level.
struct Plan {
    times_secs: Vec<f32>,
    report: CacheReport,
}

impl Plan {
    /// Bytes of the palettes that it would have, to be blended and to be shown as they are; `None` where it
    /// has none.
    fn wanted_bytes(&self) -> [Option<usize>; 2] {
        let CacheReport {
            decision,
            bytes,
            steps,
            step_bytes,
            ..
        } = self.report;
        let is_cached = decision == CacheDecision::Cached;
        [
            is_cached.then_some(bytes),
            (steps > 0).then_some(step_bytes),
        ]
    }
}

/// Levels of a clip whose keys are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Reach {
    /// Up to the finest whose keys pay, which it shares with coarser ones where there is room.
    Finest,
    Every,
}

/// Keys of one clip at every level that is reached.
fn planned(
    levels: &MergedLevels,
    clips: &ClipSet,
    (clip, ticks): (usize, &Ticks),
    (skins, reach): (&mut Skins, Reach),
    opts: &CacheOptions,
) -> Result<Vec<Plan>, Mismatch> {
    let own = levels.errors.clips.get(clip);
    let own: Vec<f32> = own.map_or(Vec::new(), |e| e.judged().collect());
    let tolerances: Vec<Vec<f32>> = (0..levels.joint_lods.levels())
        .map(|level| opts.tolerances_metres(level, &own))
        .collect();
    let map = &levels.skins.palette;
    let of = (clip, ticks);
    let mut chosen = Vec::with_capacity(tolerances.len());
    if reach == Reach::Every {
        chosen = choose(clips, of, map, skins, (0, &tolerances))?;
    }
    let pays = |of_level: &Vec<Chosen>| of_level.iter().any(|c| c.follows);
    while chosen.len() < tolerances.len() && !chosen.iter().any(pays) {
        let level = chosen.len();
        let of_level = &tolerances[level..=level];
        chosen.extend(choose(clips, of, map, skins, (level, of_level))?);
    }
    // Left to the keys of the finer one that pay.
    let left = tolerances[chosen.len()..].iter();
    chosen.extend(left.map(|of| vec![Chosen::default(); of.len()]));
    let plans = chosen.into_iter().enumerate().map(|(level, mut chosen)| {
        // The tightest tolerance whose keys pay, or else the tightest.
        let at = chosen.iter().position(|c| c.follows).unwrap_or(0);
        let tolerance_metres = tolerances[level][at];
        let chosen = chosen.swap_remove(at);
        let (keys, matrices) = (chosen.times_secs.len(), map.len(level));
        let pays = chosen.follows && matrices > 0;
        let report = CacheReport {
            clip,
            level,
            decision: if pays {
                CacheDecision::Cached
            } else {
                CacheDecision::TooFast
            },
            keys,
            bytes: keys * matrices * opts.form.bytes(),
            tolerance_metres,
            error_metres: 0.0,
            worst_metres: 0.0,
            steps: 0,
            step_bytes: 0,
            step_error_metres: 0.0,
            step_blend_metres: 0.0,
            step_blend_worst_metres: 0.0,
        };
        Plan {
            times_secs: chosen.times_secs,
            report,
        }
    });
    let mut plans: Vec<Plan> = plans.collect();
    let speed = levels.errors.clips.get(clip);
    let speed = speed.map_or(0.0, |e| e.speed_metres_per_sec);
    let way = (clips.duration_secs(clip), speed);
    for (level, steps) in wanted_steps(&own, &tolerances, way) {
        let report = &mut plans[level].report;
        if map.len(level) > 0 {
            report.steps = steps;
            report.step_bytes = steps * map.len(level) * opts.form.bytes();
        }
    }
    Ok(plans)
}

/// Bytes of a clip's palettes if those of its finest levels are taken.
fn finest_bytes(of_clip: &[Plan]) -> usize {
    let finest = |list: usize| of_clip.iter().find_map(|plan| plan.wanted_bytes()[list]);
    [0, 1].map(|list| finest(list).unwrap_or(0)).iter().sum()
}

/// Gives the levels of each clip palettes, those of the finest level that fits; the coarsest levels come
/// first, and at each those to be blended.
fn allot(plans: &mut [Vec<Plan>], most_bytes: usize) {
    let levels = plans.first().map_or(0, Vec::len);
    let mut left = most_bytes;
    // Of each clip the levels whose palettes are taken.
    let mut shared: Vec<[Option<usize>; 2]> = vec![[None; 2]; plans.len()];
    for level in (0..levels).rev() {
        for list in 0..2 {
            for (of_clip, shared) in plans.iter().zip(&mut shared) {
                let bytes = |level: usize| of_clip[level].wanted_bytes()[list];
                let Some(wanted) = bytes(level) else { continue };
                let held = shared[list].and_then(bytes).unwrap_or(0);
                if let Some(rest) = (left + held).checked_sub(wanted) {
                    left = rest;
                    shared[list] = Some(level);
                }
            }
        }
    }
    for (of_clip, [keys, steps]) in plans.iter_mut().zip(shared) {
        share_keys(of_clip, keys);
        share_steps(of_clip, steps);
    }
}

/// Gives a level and all coarser ones its keys.
fn share_keys(of_clip: &mut [Plan], owner: Option<usize>) {
    let taken = owner.map(|owner| (owner, of_clip[owner].times_secs.clone()));
    for (level, plan) in of_clip.iter_mut().enumerate() {
        let report = &mut plan.report;
        match &taken {
            Some((owner, times_secs)) if level >= *owner => {
                report.decision = CacheDecision::Cached;
                report.keys = times_secs.len();
                if level > *owner {
                    report.bytes = 0;
                    plan.times_secs.clone_from(times_secs);
                }
            }
            _ if report.decision == CacheDecision::Cached => {
                report.decision = CacheDecision::NoRoom;
            }
            _ => {}
        }
    }
}

/// Gives a level and all coarser ones its palettes at equal distances in time.
fn share_steps(of_clip: &mut [Plan], owner: Option<usize>) {
    let taken = owner.map(|owner| (owner, of_clip[owner].report.steps));
    for (level, plan) in of_clip.iter_mut().enumerate() {
        let report = &mut plan.report;
        match taken {
            Some((owner, _)) if level == owner => {}
            Some((owner, steps)) if level > owner => (report.steps, report.step_bytes) = (steps, 0),
            _ => (report.steps, report.step_bytes) = (0, 0),
        }
    }
}

/// An entry for each clip, and in it one for each level.
type ByClipAndLevel<T> = Vec<Vec<Option<T>>>;

/// Keys and steps of everything that is cached, and the positions of their palettes.
fn placed(
    plans: &[Vec<Plan>],
    map: &PaletteMap,
) -> (ByClipAndLevel<CachedKeys>, ByClipAndLevel<CachedSteps>) {
    let mut keys = vec![vec![None; map.levels()]; plans.len()];
    let mut steps = vec![vec![None; map.levels()]; plans.len()];
    let mut end = 0;
    for (clip, of_clip) in plans.iter().enumerate() {
        // The finest level comes first: the palettes are its own.
        let mut first_matrix = None;
        for (level, plan) in of_clip.iter().enumerate() {
            if plan.report.decision == CacheDecision::Cached {
                let first_matrix = *first_matrix.get_or_insert_with(|| {
                    let first = end;
                    end += plan.times_secs.len() * map.len(level);
                    first as u32
                });
                keys[clip][level] = Some(CachedKeys {
                    times_secs: plan.times_secs.clone(),
                    first_matrix,
                    error_metres: 0.0,
                });
            }
        }
        let mut first_matrix = None;
        for (level, plan) in of_clip.iter().enumerate() {
            if plan.report.steps > 0 {
                let first_matrix = *first_matrix.get_or_insert_with(|| {
                    let first = end;
                    end += plan.report.steps * map.len(level);
                    first as u32
                });
                steps[clip][level] = Some(CachedSteps {
                    count: plan.report.steps as u32,
                    first_matrix,
                    error_metres: 0.0,
                    blend_error_metres: None,
                });
            }
        }
    }
    (keys, steps)
}

/// Makes the pose cache of known keys and steps, such as those that an asset stores: evaluates their
/// palettes.
///
/// # Errors
/// A [`Mismatch`] if keys, steps, clips and palette do not belong together, their palettes take more
/// than [`CacheOptions::palette_bytes`], or the form cannot be blended linearly.
pub fn cache_of_keys(
    clips: &ClipSet,
    map: &PaletteMap,
    (keys, steps): (&Keys, &Steps),
    opts: &CacheOptions,
) -> Result<PoseCache, Mismatch> {
    let form = opts.form;
    if form.is_rigid() {
        let what = "quaternions do not blend linearly; choose a matrix form";
        return Err(Mismatch::new("form", what));
    }
    let levels = clips.joint_lods().levels();
    let is_wrong =
        |lens: Vec<usize>| lens.len() != clips.clips() || lens.iter().any(|len| *len != levels);
    let all = [
        ("keys", is_wrong(keys.iter().map(Vec::len).collect())),
        ("steps", is_wrong(steps.iter().map(Vec::len).collect())),
    ];
    if let Some((name, _)) = all.iter().find(|(_, is_wrong)| *is_wrong) {
        let what = format!("expected {levels} levels of {} clips", clips.clips());
        return Err(Mismatch::new(*name, what));
    }
    let baker = BatchEvaluator::new(clips, map, form, Backend::best())?;
    let bytes = bytes_of(map, (keys, steps), form);
    if bytes > opts.palette_bytes {
        let what = format!(
            "the palettes take {bytes} bytes, at most {}",
            opts.palette_bytes
        );
        return Err(Mismatch::new("keys", what));
    }
    let rows = bake(&baker, clips, (keys, steps), form)?;
    PoseCache::new(clips, map, keys, rows)?.with_steps(clips, steps)
}
