//! Evaluation of the palettes of a cache.

use super::keys::Ticks;
use articula_core::batch::{BatchEvaluator, BatchPose};
use articula_core::{
    CachedKeys, CachedRows, CachedSteps, ClipSet, Mismatch, PaletteForm, PaletteMap, PaletteRows,
};

/// By clip and level, keys of palettes to be blended.
pub(super) type Keys = [Vec<Option<CachedKeys>>];
/// The same of those that are shown as they are.
pub(super) type Steps = [Vec<Option<CachedSteps>>];

/// Palettes of one clip at one level, the first of which has its first matrix at an index.
struct Run {
    clip: usize,
    level: usize,
    times_secs: Vec<f32>,
    first_matrix: usize,
    /// Name of the list that it is of.
    list: &'static str,
}

/// The first of the levels of a clip that share palettes, at each level: the finest one, whose palettes
/// begin with those of the others.
fn owners<T>(of_clip: &[Option<T>], first: impl Fn(&T) -> u32) -> Vec<usize> {
    let firsts: Vec<Option<u32>> = of_clip.iter().map(|of| of.as_ref().map(&first)).collect();
    let owner = |level: usize| {
        let same = |f: &Option<u32>| f.is_some() && *f == firsts[level];
        firsts.iter().position(same).unwrap_or(level)
    };
    (0..of_clip.len()).map(owner).collect()
}

/// The entries of a clip whose palettes are their own, with their levels.
fn owned<T>(of_clip: &[Option<T>], first: impl Fn(&T) -> u32) -> impl Iterator<Item = (usize, &T)> {
    let owners = owners(of_clip, first);
    let all = of_clip.iter().enumerate().zip(owners);
    all.filter_map(|((level, of), owner)| Some((level, of.as_ref().filter(|_| owner == level)?)))
}

/// All runs of palettes of a cache.
fn runs(clips: &ClipSet, keys: &Keys, steps: &Steps) -> Vec<Run> {
    let mut runs = Vec::new();
    for (clip, of_clip) in keys.iter().enumerate() {
        runs.extend(owned(of_clip, |k| k.first_matrix).map(|(level, keys)| Run {
            clip,
            level,
            times_secs: keys.times_secs.clone(),
            first_matrix: keys.first_matrix as usize,
            list: "keys",
        }));
    }
    for (clip, of_clip) in steps.iter().enumerate() {
        let end_secs = clips.duration_secs(clip);
        runs.extend(owned(of_clip, |s| s.first_matrix).map(|(level, steps)| {
            let ticks = Ticks::of_steps(steps.count as usize, end_secs);
            Run {
                clip,
                level,
                times_secs: ticks.steps_secs(steps.count as usize),
                first_matrix: steps.first_matrix as usize,
                list: "steps",
            }
        }));
    }
    runs
}

/// Size in bytes of the palettes of all keys and steps, whose levels are those of the palette.
pub(super) fn bytes_of(
    map: &PaletteMap,
    (keys, steps): (&Keys, &Steps),
    form: PaletteForm,
) -> usize {
    // A palette without matrices has a time.
    let len = |level: usize| {
        form.bytes()
            .saturating_mul(map.len(level))
            .max(size_of::<f32>())
    };
    let of_keys = keys
        .iter()
        .flat_map(|of_clip| owned(of_clip, |k| k.first_matrix));
    let of_keys = of_keys.map(|(level, k)| (level, k.times_secs.len()));
    let of_steps = steps
        .iter()
        .flat_map(|of_clip| owned(of_clip, |s| s.first_matrix));
    let of_steps = of_steps.map(|(level, s)| (level, s.count as usize));
    let all = of_keys.chain(of_steps);
    all.fold(0, |sum: usize, (level, palettes)| {
        sum.saturating_add(len(level).saturating_mul(palettes))
    })
}

/// Evaluates the palettes of all keys and steps.
pub(super) fn bake(
    baker: &BatchEvaluator<'_>,
    clips: &ClipSet,
    (keys, steps): (&Keys, &Steps),
    form: PaletteForm,
) -> Result<CachedRows, Mismatch> {
    let matrices = |run: &Run| run.times_secs.len() * baker.rows(run.level) / 3;
    let runs = runs(clips, keys, steps);
    let count: usize = runs.iter().map(matrices).sum();
    let is_outside = |run: &&Run| run.first_matrix.saturating_add(matrices(run)) > count;
    if let Some(Run {
        clip, level, list, ..
    }) = runs.iter().find(is_outside)
    {
        let what = format!("the palettes exceed the {count} matrices of all keys and steps");
        let at = format!("{list}[{clip}][{level}].first_matrix");
        return Err(Mismatch::new(at, what));
    }
    let mut rows = match form.is_half() {
        true => CachedRows::Half(vec![[0; 4]; 3 * count]),
        false => CachedRows::Float(vec![[0.0; 4]; 3 * count]),
    };
    let mut scratch = baker.scratch();
    for run in &runs {
        let mut from = 3 * run.first_matrix;
        for times in run.times_secs.chunks(baker.lanes()) {
            let shown: Vec<BatchPose> = times
                .iter()
                .map(|t| clips.cursor(run.clip, *t).into())
                .collect();
            let to = from + shown.len() * baker.rows(run.level);
            let out = match &mut rows {
                CachedRows::Float(rows) => PaletteRows::Float(&mut rows[from..to]),
                CachedRows::Half(rows) => PaletteRows::Half(&mut rows[from..to]),
            };
            baker.evaluate(run.level, &shown, out, &mut scratch);
            from = to;
        }
    }
    Ok(rows)
}
