//! Pose cache: baked palettes at key poses of every clip and level of a character, to be blended
//! linearly.
//!
//! Source: `docs/methods/motion-lod.md` part 6, `docs/methods/runtime.md` part 4.1. Each clip and
//! level has as few keys as its tolerance allows. The tolerance is a share of the error of the
//! level itself in that clip, since the two errors add up; fast clips are allowed more as long as
//! the next level alone is worse. Errors are measured on the result, through [`PoseCache`] itself,
//! at twice the rate at which keys were chosen. The cache is filled from the coarsest level up,
//! since most of a crowd is far away.

mod farthest;
mod keys;
mod measure;
mod skins;

use crate::character::Asset;
use crate::joint_lods::MergedLevels;
use articula_core::batch::{BatchEvaluator, BatchPose, LANES};
use articula_core::{
    Backend, CachedKeys, CachedRows, ClipSet, Mismatch, PaletteForm, PaletteMap, PaletteRows,
    PoseCache,
};
use keys::{Ticks, choose};
use measure::measure;
use skins::Skins;

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
    /// f32 palettes of at most 16 MiB; a quarter of the level's own error, but at least 0.5 mm at
    /// level 0, 1 mm at level 1 and so on; the 700 vertices that level errors are measured on.
    fn default() -> Self {
        Self {
            form: PaletteForm::Matrix,
            share: 0.25,
            min_metres: 0.5e-3,
            palette_bytes: 16 << 20,
            vertices: 700,
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
    /// Size of their palettes in bytes.
    pub bytes: usize,
    /// Tolerance that the keys were chosen for, in metres.
    pub tolerance_metres: f32,
    /// Error that the cache states, the larger of the 95th percentile over vertices and half of the
    /// maximum, in metres; 0 if not cached.
    pub error_metres: f32,
    /// The same where the palette of the nearest key is shown as it is.
    pub step_error_metres: f32,
    /// Maximum error over all vertices, in metres; 0 if not cached.
    pub worst_metres: f32,
}

/// A pose cache and a report of its contents.
#[derive(Debug, Clone, PartialEq)]
pub struct CachedPoses {
    /// The cache.
    pub cache: PoseCache,
    /// Keys of each clip at each level, from which [`cache_of_keys`] makes the same cache; `None`
    /// where poses are evaluated.
    pub keys: Vec<Vec<Option<CachedKeys>>>,
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
    let mut plans = Vec::with_capacity(clips.clips());
    for (clip, ticks) in ticks.iter().enumerate() {
        plans.push(planned(levels, clips, (clip, ticks), &mut skins, opts)?);
    }
    allot(&mut plans, opts.palette_bytes);
    let mut keys = placed_keys(&plans, map);
    let rows = bake(&baker, clips, &keys, opts.form)?;
    let unmeasured = PoseCache::new(clips, map, &keys, rows.clone())?;
    for (clip, ticks) in ticks.iter().enumerate() {
        let errors = measure(&unmeasured, clips, (clip, ticks), map, &mut skins)?;
        for (level, error) in errors.into_iter().enumerate() {
            let Some(keys) = &mut keys[clip][level] else {
                continue;
            };
            let report = &mut plans[clip][level].report;
            keys.error_metres = error.blended.judged_metres();
            keys.step_error_metres = Some(error.stepped.judged_metres());
            report.error_metres = keys.error_metres;
            report.step_error_metres = error.stepped.judged_metres();
            report.worst_metres = error.blended.worst_metres;
        }
    }
    Ok(CachedPoses {
        cache: PoseCache::new(clips, map, &keys, rows)?,
        keys,
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

/// Keys of one clip at every level.
fn planned(
    levels: &MergedLevels,
    clips: &ClipSet,
    (clip, ticks): (usize, &Ticks),
    skins: &mut Skins,
    opts: &CacheOptions,
) -> Result<Vec<Plan>, Mismatch> {
    let own = levels.errors.clips.get(clip);
    let own: Vec<f32> = own.map_or(Vec::new(), |e| e.judged().collect());
    let tolerances: Vec<Vec<f32>> = (0..levels.joint_lods.levels())
        .map(|level| opts.tolerances_metres(level, &own))
        .collect();
    let map = &levels.skins.palette;
    let chosen = choose(clips, (clip, ticks), map, skins, &tolerances)?;
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
            step_error_metres: 0.0,
            worst_metres: 0.0,
        };
        Plan {
            times_secs: chosen.times_secs,
            report,
        }
    });
    Ok(plans.collect())
}

/// Drops what does not fit; the coarsest levels come first.
fn allot(plans: &mut [Vec<Plan>], most_bytes: usize) {
    let mut left = most_bytes;
    let levels = plans.first().map_or(0, Vec::len);
    for level in (0..levels).rev() {
        for report in plans.iter_mut().map(|of_clip| &mut of_clip[level].report) {
            if report.decision == CacheDecision::Cached {
                match left.checked_sub(report.bytes) {
                    Some(rest) => left = rest,
                    None => report.decision = CacheDecision::NoRoom,
                }
            }
        }
    }
}

/// Keys of everything that is cached, and the positions of their palettes: the coarsest level comes
/// first.
fn placed_keys(plans: &[Vec<Plan>], map: &PaletteMap) -> Vec<Vec<Option<CachedKeys>>> {
    let mut keys = vec![vec![None; map.levels()]; plans.len()];
    let mut first_matrix = 0;
    for level in (0..map.levels()).rev() {
        for (clip, plan) in plans.iter().map(|of_clip| &of_clip[level]).enumerate() {
            if plan.report.decision == CacheDecision::Cached {
                keys[clip][level] = Some(CachedKeys {
                    times_secs: plan.times_secs.clone(),
                    first_matrix: first_matrix as u32,
                    error_metres: 0.0,
                    step_error_metres: None,
                });
                first_matrix += plan.times_secs.len() * map.len(level);
            }
        }
    }
    keys
}

/// Evaluates the palettes of all keys.
fn bake(
    baker: &BatchEvaluator<'_>,
    clips: &ClipSet,
    keys: &[Vec<Option<CachedKeys>>],
    form: PaletteForm,
) -> Result<CachedRows, Mismatch> {
    let matrices = |level, keys: &CachedKeys| keys.times_secs.len() * baker.rows(level) / 3;
    let each = || {
        let levels = keys.iter().enumerate();
        levels.flat_map(|(clip, of_clip)| {
            let of_level = of_clip.iter().enumerate();
            of_level.filter_map(move |(level, keys)| Some((clip, level, keys.as_ref()?)))
        })
    };
    let count: usize = each().map(|(_, level, keys)| matrices(level, keys)).sum();
    let is_outside = |level, keys: &CachedKeys| {
        let first = keys.first_matrix as usize;
        first.saturating_add(matrices(level, keys)) > count
    };
    if let Some((clip, level, _)) = each().find(|(_, level, keys)| is_outside(*level, keys)) {
        let what = format!("the palettes exceed the {count} matrices of all keys");
        return Err(Mismatch::new(
            format!("keys[{clip}][{level}].first_matrix"),
            what,
        ));
    }
    let mut rows = match form.is_half() {
        true => CachedRows::Half(vec![[0; 4]; 3 * count]),
        false => CachedRows::Float(vec![[0.0; 4]; 3 * count]),
    };
    let mut scratch = baker.scratch();
    for (clip, level, keys) in each() {
        let mut from = 3 * keys.first_matrix as usize;
        for times in keys.times_secs.chunks(LANES) {
            let shown: Vec<BatchPose> = times
                .iter()
                .map(|t| clips.cursor(clip, *t).into())
                .collect();
            let to = from + shown.len() * baker.rows(level);
            let out = match &mut rows {
                CachedRows::Float(rows) => PaletteRows::Float(&mut rows[from..to]),
                CachedRows::Half(rows) => PaletteRows::Half(&mut rows[from..to]),
            };
            baker.evaluate(level, &shown, out, &mut scratch);
            from = to;
        }
    }
    Ok(rows)
}

/// Makes the pose cache of known keys, such as those that an asset stores: evaluates their palettes.
///
/// # Errors
/// A [`Mismatch`] if keys, clips and palette do not belong together, or the form cannot be blended
/// linearly.
pub fn cache_of_keys(
    clips: &ClipSet,
    map: &PaletteMap,
    keys: &[Vec<Option<CachedKeys>>],
    form: PaletteForm,
) -> Result<PoseCache, Mismatch> {
    if form.is_rigid() {
        let what = "quaternions do not blend linearly; choose a matrix form";
        return Err(Mismatch::new("form", what));
    }
    let levels = clips.joint_lods().levels();
    if keys.len() != clips.clips() || keys.iter().any(|k| k.len() != levels) {
        let what = format!("expected {levels} levels of {} clips", clips.clips());
        return Err(Mismatch::new("keys", what));
    }
    let baker = BatchEvaluator::new(clips, map, form, Backend::best())?;
    let rows = bake(&baker, clips, keys, form)?;
    PoseCache::new(clips, map, keys, rows)
}
