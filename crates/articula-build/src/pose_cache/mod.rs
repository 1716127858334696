//! Pose keys for all clips and levels of a character, baked into one cache.
//!
//! Source: `docs/methods/motion-lod.md` part 6 with its cautions, `docs/methods/runtime.md` 4.1. For each clip and
//! level as few whole poses are kept as the level's tolerance allows. Differs: the tolerance is a
//! share of what the level itself costs in that clip, because the two errors add up, and fast
//! clips get more as long as the next level alone is worse; what is measured is what the frame shows, through [`PoseCache`] itself, at twice the rate that keys
//! were chosen at; and the cache is filled from the coarsest level up, since most of a crowd is
//! far away.

mod keys;
mod measure;
mod skins;

use crate::character::Asset;
use crate::joint_lods::MergedLevels;
use articula_core::batch::{BatchEvaluator, BatchPose, LANES};
use articula_core::{
    Backend, CachedKeys, CachedRows, ClipSet, Mismatch, PaletteForm, PaletteRows, PoseCache,
};
use keys::{Ticks, choose};
use measure::measure;
use skins::Skins;

/// How often a tolerance may be doubled for a clip that is too fast for it.
const MAX_DOUBLINGS: u32 = 3;

/// How a cache is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CacheOptions {
    /// How palettes are written: [`PaletteForm::Matrix`] or [`PaletteForm::HalfMatrix`], the two
    /// that may be blended linearly.
    pub form: PaletteForm,
    /// Error that blending may add, as a part of the level's own error in the clip; more for fast
    /// clips, see `CacheOptions::tolerances_metres`.
    pub share: f32,
    /// Error that blending may add at level 0 however small the level's own is, metres; twice as
    /// much at each further level.
    pub least_metres: f32,
    /// Most bytes of all palettes together.
    pub palette_bytes: usize,
    /// Watched vertices.
    pub vertices: usize,
    /// Seed of the watched vertices.
    pub seed: u64,
}

impl Default for CacheOptions {
    /// f32 palettes of at most 16 MiB; a quarter of the level's own error, but 0.5 mm at level 0,
    /// 1 mm at level 1 and so on; the 700 vertices that level errors are measured with.
    fn default() -> Self {
        Self {
            form: PaletteForm::Matrix,
            share: 0.25,
            least_metres: 0.5e-3,
            palette_bytes: 16 << 20,
            vertices: 700,
            seed: 1,
        }
    }
}

impl CacheOptions {
    /// What blending may cost at a level, by the errors of all levels of the clip: the share or
    /// the least, and where keys would stand too close for that, twice as much and again, as long
    /// as the two errors together stay below the next level's own.
    pub(crate) fn tolerances_metres(&self, level: usize, levels_metres: &[f32]) -> Vec<f32> {
        let own = levels_metres.get(level).copied().unwrap_or(0.0);
        let next = levels_metres.get(level + 1).copied().unwrap_or(0.0);
        let first = (self.share * own).max(self.least_metres * (1u32 << level) as f32);
        let wider = (1..=MAX_DOUBLINGS).map(|i| first * (1u32 << i) as f32);
        let wider = wider.take_while(|t| own + t <= next);
        std::iter::once(first).chain(wider).collect()
    }
}

/// What became of a clip at a level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CacheDecision {
    /// It is in the cache.
    Cached,
    /// Evaluate: keys would stand two display frames apart or less, or the clip jumps.
    TooFast,
    /// Evaluate: what was cached before left no room.
    NoRoom,
}

/// One clip at one level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CacheReport {
    /// The clip.
    pub clip: usize,
    /// The level.
    pub level: usize,
    /// What became of it.
    pub fate: CacheDecision,
    /// Keys that the tolerance asks for.
    pub keys: usize,
    /// Bytes of their palettes.
    pub bytes: usize,
    /// The tolerance that keys were chosen for.
    pub tolerance_metres: f32,
    /// Error as the cache states it; 0 where nothing is cached.
    pub error_metres: f32,
    /// The same with the greatest over the watched vertices.
    pub worst_metres: f32,
}

/// A cache, and what is in it and what is not.
#[derive(Debug, Clone, PartialEq)]
pub struct CachedPoses {
    /// For the frame.
    pub cache: PoseCache,
    /// One entry for each clip and level, clip by clip.
    pub report: Vec<CacheReport>,
}

/// Chooses keys, bakes their palettes with the evaluator of the frame and measures the result.
///
/// `clips` are the character's in the order of its ladder. A character without mesh has no
/// palette, so all its poses are to be evaluated.
///
/// # Errors
/// A [`Mismatch`] if clips, levels and character do not belong together, the form cannot be
/// blended, or an option is no number.
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
    let (mut keys, rows) = bake(&baker, clips, &plans, opts.form);
    let unmeasured = PoseCache::new(clips, map, &keys, rows.clone())?;
    for (clip, ticks) in ticks.iter().enumerate() {
        let errors = measure(&unmeasured, clips, (clip, ticks), map, &mut skins)?;
        for (level, error) in errors.into_iter().enumerate() {
            let Some(keys) = &mut keys[clip][level] else {
                continue;
            };
            let report = &mut plans[clip][level].report;
            keys.error_metres = error.percentile_metres;
            report.error_metres = error.percentile_metres;
            report.worst_metres = error.worst_metres;
        }
    }
    Ok(CachedPoses {
        cache: PoseCache::new(clips, map, &keys, rows)?,
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
            "they are laid out for another ladder",
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
        return Err(Mismatch::new("clips", "they are not the character's"));
    }
    if levels
        .skins
        .levels
        .iter()
        .any(|s| s.positions.len() != asset.mesh.len())
    {
        return Err(Mismatch::new("levels.skins", "they are of another mesh"));
    }
    if opts.form.is_rigid() {
        let what = "quaternions do not blend linearly; take a matrix form";
        return Err(Mismatch::new("form", what));
    }
    let numbers = [("share", opts.share), ("least_metres", opts.least_metres)];
    for (name, value) in numbers {
        if !value.is_finite() || value < 0.0 {
            return Err(Mismatch::new(name, "must be a number, not negative"));
        }
    }
    Ok(())
}

/// The grid of each clip; a single moment for a rig without clips.
fn ticks_of(asset: &Asset, clips: &ClipSet) -> Vec<Ticks> {
    let of = |clip: usize| match asset.clips.get(clip) {
        None => Ticks::single(),
        Some(own) => Ticks::new(own.rate_hz(), own.frames(), clips.duration_secs(clip)),
    };
    (0..clips.clips()).map(of).collect()
}

/// The keys that one clip needs at one level.
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
    let own = own.map_or(&[][..], |e| &e.levels_metres);
    let tolerances: Vec<Vec<f32>> = (0..levels.joint_lods.levels())
        .map(|level| opts.tolerances_metres(level, own))
        .collect();
    let map = &levels.skins.palette;
    let chosen = choose(clips, (clip, ticks), map, skins, &tolerances)?;
    let plans = chosen.into_iter().enumerate().map(|(level, mut chosen)| {
        // The tightest one that is worth it, or else the tightest.
        let at = chosen.iter().position(|c| c.follows).unwrap_or(0);
        let tolerance_metres = tolerances[level][at];
        let chosen = chosen.swap_remove(at);
        let (keys, matrices) = (chosen.times_secs.len(), map.len(level));
        let pays = chosen.follows && matrices > 0;
        let report = CacheReport {
            clip,
            level,
            fate: if pays {
                CacheDecision::Cached
            } else {
                CacheDecision::TooFast
            },
            keys,
            bytes: keys * matrices * opts.form.bytes(),
            tolerance_metres,
            error_metres: 0.0,
            worst_metres: 0.0,
        };
        Plan {
            times_secs: chosen.times_secs,
            report,
        }
    });
    Ok(plans.collect())
}

/// Leaves out what does not fit, the coarsest levels served first.
fn allot(plans: &mut [Vec<Plan>], most_bytes: usize) {
    let mut left = most_bytes;
    let levels = plans.first().map_or(0, Vec::len);
    for level in (0..levels).rev() {
        for report in plans.iter_mut().map(|of_clip| &mut of_clip[level].report) {
            if report.fate == CacheDecision::Cached {
                match left.checked_sub(report.bytes) {
                    Some(rest) => left = rest,
                    None => report.fate = CacheDecision::NoRoom,
                }
            }
        }
    }
}

/// Palettes at all keys, the coarsest level first, and where they stand.
fn bake(
    baker: &BatchEvaluator<'_>,
    clips: &ClipSet,
    plans: &[Vec<Plan>],
    form: PaletteForm,
) -> (Vec<Vec<Option<CachedKeys>>>, CachedRows) {
    let levels = clips.joint_lods().levels();
    let mut keys = vec![vec![None; levels]; plans.len()];
    let mut rows = match form.is_half() {
        true => CachedRows::Half(Vec::new()),
        false => CachedRows::Float(Vec::new()),
    };
    let mut scratch = baker.scratch();
    let mut written = 0;
    for level in (0..levels).rev() {
        for (clip, plan) in plans.iter().map(|of_clip| &of_clip[level]).enumerate() {
            if plan.report.fate != CacheDecision::Cached {
                continue;
            }
            keys[clip][level] = Some(CachedKeys {
                times_secs: plan.times_secs.clone(),
                first_matrix: (written / 3) as u32,
                error_metres: 0.0,
            });
            for times in plan.times_secs.chunks(LANES) {
                let shown: Vec<BatchPose> = times
                    .iter()
                    .map(|t| clips.cursor(clip, *t).into())
                    .collect();
                let from = written;
                let to = from + shown.len() * baker.rows(level);
                written = to;
                let out = match &mut rows {
                    CachedRows::Float(rows) => {
                        rows.resize(to, [0.0; 4]);
                        PaletteRows::Float(&mut rows[from..])
                    }
                    CachedRows::Half(rows) => {
                        rows.resize(to, [0; 4]);
                        PaletteRows::Half(&mut rows[from..])
                    }
                };
                baker.evaluate(level, &shown, out, &mut scratch);
            }
        }
    }
    (keys, rows)
}
