//! Properties of the pose cache: a time is located between the right keys, a blend is the straight
//! line between their palettes on every backend, a key reproduces its evaluation bit for bit, no
//! allocation.

use crate::random_rig::{Options, figure};
use articula_core::batch::{BatchEvaluator, BatchPose};
use articula_core::{
    Backend, BlendRecord, CachedKeys, CachedRows, ClipSet, ClipStorage, JointLods, PaletteForm,
    PaletteMap, PaletteRows, PoseCache, f32_from_half, half_from_f32,
};
use proptest::prelude::*;
use proptest::strategy::ValueTree;

/// Evaluates one pose at a level into f32 rows, for any form.
fn evaluated(
    evaluator: &BatchEvaluator<'_>,
    level: usize,
    shown: BatchPose,
    half: bool,
) -> Vec<[f32; 4]> {
    let mut scratch = evaluator.scratch();
    let len = evaluator.rows(level);
    if half {
        let mut rows = vec![[0u16; 4]; len];
        evaluator.evaluate(level, &[shown], PaletteRows::Half(&mut rows), &mut scratch);
        return rows.iter().map(|r| r.map(f32_from_half)).collect();
    }
    let mut rows = vec![[0f32; 4]; len];
    evaluator.evaluate(level, &[shown], PaletteRows::Float(&mut rows), &mut scratch);
    rows
}

/// Key times of a clip: both ends and the given fractions of its duration.
fn times(end_secs: f32, fractions: &[f32]) -> Vec<f32> {
    let mut times: Vec<f32> = fractions.iter().map(|f| f * end_secs).collect();
    times.extend([0.0, end_secs]);
    times.sort_by(f32::total_cmp);
    times.dedup();
    times
}

/// A cache of all clips and levels with keys at the same fractions of each clip; every third entry
/// is left out, to be evaluated.
fn cached(
    set: &ClipSet,
    map: &PaletteMap,
    fractions: &[f32],
    half: bool,
) -> (PoseCache, Vec<Vec<Option<CachedKeys>>>) {
    let evaluator = BatchEvaluator::new(set, map, PaletteForm::Matrix, Backend::best()).unwrap();
    let levels = set.joint_lods().levels();
    let mut rows: Vec<[f32; 4]> = Vec::new();
    let mut keys = vec![vec![None; levels]; set.clips()];
    for (clip, level) in (0..set.clips()).flat_map(|c| (0..levels).map(move |l| (c, l))) {
        if (clip + 2 * level) % 3 == 1 {
            continue;
        }
        let times_secs = times(set.duration_secs(clip), fractions);
        let first_matrix = (rows.len() / 3) as u32;
        for secs in &times_secs {
            let shown = set.cursor(clip, *secs).into();
            rows.extend(evaluated(&evaluator, level, shown, false));
        }
        keys[clip][level] = Some(CachedKeys {
            times_secs,
            first_matrix,
            error_metres: 0.5 * level as f32,
        });
    }
    let rows = if half {
        CachedRows::Half(rows.iter().map(|r| r.map(half_from_f32)).collect())
    } else {
        CachedRows::Float(rows)
    };
    (PoseCache::new(set, map, &keys, rows).unwrap(), keys)
}

/// Blends one record into f32 rows, for any form.
fn blended(
    cache: &PoseCache,
    level: usize,
    record: BlendRecord,
    backend: Backend,
) -> Vec<[f32; 4]> {
    let len = cache.matrices(level) * 3;
    if cache.form().is_half() {
        let mut rows = vec![[0u16; 4]; len];
        cache.blend(level, &[record], backend, PaletteRows::Half(&mut rows));
        return rows.iter().map(|r| r.map(f32_from_half)).collect();
    }
    let mut rows = vec![[0f32; 4]; len];
    cache.blend(level, &[record], backend, PaletteRows::Float(&mut rows));
    rows
}

/// A cached palette as f32 rows.
fn palette(cache: &PoseCache, level: usize, first: u32) -> Vec<[f32; 4]> {
    let range = first as usize * 3..(first as usize + cache.matrices(level)) * 3;
    match cache.rows() {
        CachedRows::Float(rows) => rows[range].to_vec(),
        CachedRows::Half(rows) => rows[range].iter().map(|r| r.map(f32_from_half)).collect(),
    }
}

fn bits(rows: &[[f32; 4]]) -> Vec<u32> {
    rows.iter().flatten().map(|v| v.to_bits()).collect()
}

/// Evenly spread keys, or a few close together.
fn fractions() -> impl Strategy<Value = Vec<f32>> {
    prop_oneof![
        prop::collection::vec(0.0f32..1.0, 0..12),
        prop::collection::vec(0.3f32..0.300_1, 0..6),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn a_record_blends_the_keys_around_its_time(
        (rig, clips, sets) in figure(Options { scaled: true, steps: true }),
        fractions in fractions(),
        secs in prop::collection::vec(-0.1f32..6.0, 8),
        half in any::<bool>(),
    ) {
        let joint_lods = JointLods::of_sets(&rig, &sets, rig.rest_pose()).unwrap();
        let set = ClipSet::new(&rig, joint_lods.clone(), &clips, ClipStorage::Float).unwrap();
        let map = PaletteMap::joints(&joint_lods);
        let (cache, keys) = cached(&set, &map, &fractions, half);
        for (clip, level) in (0..2).flat_map(|c| (0..joint_lods.levels()).map(move |l| (c, l))) {
            let Some(keys) = &keys[clip][level] else {
                prop_assert_eq!(cache.error_metres(clip, level), None);
                prop_assert_eq!(cache.locate(clip, level, secs[0]), None);
                continue;
            };
            prop_assert_eq!(cache.error_metres(clip, level), Some(keys.error_metres));
            let times = &keys.times_secs;
            let stored: Vec<f32> = cache.times_secs(clip, level).unwrap().collect();
            prop_assert_eq!(&stored, times);
            let last = times.len() - 1;
            for secs in &secs {
                let record = cache.locate(clip, level, *secs).unwrap();
                // Reference: search from the end.
                let time = secs.clamp(0.0, times[last]);
                let key = times.iter().rposition(|t| *t <= time).unwrap();
                let matrix = |key: usize| keys.first_matrix + (key * cache.matrices(level)) as u32;
                prop_assert_eq!(record.before, matrix(key));
                prop_assert_eq!(record.after, matrix((key + 1).min(last)));
                let blend = match times.get(key + 1) {
                    Some(next) => (time - times[key]) / (next - times[key]),
                    None => 0.0,
                };
                prop_assert!((record.blend - blend).abs() <= 2e-7, "{} for {blend}", record.blend);
                let (a, b) = (palette(&cache, level, record.before), palette(&cache, level, record.after));
                let shown = blended(&cache, level, record, Backend::Scalar);
                for ((s, a), b) in shown.iter().flatten().zip(a.iter().flatten()).zip(b.iter().flatten()) {
                    let line = f64::from(*a) + (f64::from(*b) - f64::from(*a)) * f64::from(record.blend);
                    // Three roundings in f32; one more for half floats.
                    let size = f64::from(a.abs().max(b.abs()));
                    let within = 4e-7 * size + if half { line.abs() / 2048.0 + 6e-8 } else { 0.0 };
                    prop_assert!((f64::from(*s) - line).abs() <= within, "{s} for {line}");
                }
                for backend in Backend::ALL.into_iter().filter(|b| b.is_available()) {
                    let other = blended(&cache, level, record, backend);
                    prop_assert_eq!(bits(&other), bits(&shown), "{}", backend);
                }
            }
        }
    }

    #[test]
    fn at_a_key_the_palette_is_the_one_evaluated(
        (rig, clips, sets) in figure(Options { scaled: true, steps: true }),
        fractions in fractions(),
        half in any::<bool>(),
    ) {
        let joint_lods = JointLods::of_sets(&rig, &sets, rig.rest_pose()).unwrap();
        let set = ClipSet::new(&rig, joint_lods.clone(), &clips, ClipStorage::Float).unwrap();
        let map = PaletteMap::joints(&joint_lods);
        let (cache, keys) = cached(&set, &map, &fractions, half);
        let evaluator = BatchEvaluator::new(&set, &map, cache.form(), Backend::best()).unwrap();
        for (clip, level) in (0..2).flat_map(|c| (0..joint_lods.levels()).map(move |l| (c, l))) {
            let times = keys[clip][level].iter().flat_map(|k| &k.times_secs);
            for secs in times {
                let record = cache.locate(clip, level, *secs).unwrap();
                let shown = blended(&cache, level, record, Backend::best());
                let truth = evaluated(&evaluator, level, set.cursor(clip, *secs).into(), half);
                prop_assert_eq!(bits(&shown), bits(&truth), "clip {}, level {}, {} s", clip, level, secs);
            }
        }
    }

    #[test]
    fn several_records_are_several_blends(
        (rig, clips, sets) in figure(Options { scaled: false, steps: false }),
        fractions in fractions(),
        plays in prop::collection::vec((0usize..2, 0.0f32..2.0), 0..12),
    ) {
        let joint_lods = JointLods::of_sets(&rig, &sets, rig.rest_pose()).unwrap();
        let set = ClipSet::new(&rig, joint_lods.clone(), &clips, ClipStorage::Float).unwrap();
        let map = PaletteMap::joints(&joint_lods);
        let (cache, _) = cached(&set, &map, &fractions, false);
        for level in 0..joint_lods.levels() {
            let records: Vec<BlendRecord> = plays
                .iter()
                .filter_map(|(clip, secs)| cache.locate(*clip, level, *secs))
                .collect();
            let mut rows = vec![[0.0; 4]; records.len() * cache.matrices(level) * 3];
            cache.blend(level, &records, Backend::best(), PaletteRows::Float(&mut rows));
            let single = records.iter().flat_map(|r| blended(&cache, level, *r, Backend::best()));
            prop_assert_eq!(bits(&rows), bits(&single.collect::<Vec<_>>()));
        }
    }
}

#[test]
fn locating_and_blending_allocate_nothing() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let options = Options {
        scaled: false,
        steps: false,
    };
    let (rig, clips, _) = figure(options).new_tree(&mut runner).unwrap().current();
    let joint_lods = JointLods::whole(&rig).unwrap();
    let set = ClipSet::new(&rig, joint_lods.clone(), &clips, ClipStorage::Float).unwrap();
    let map = PaletteMap::joints(&joint_lods);
    for half in [false, true] {
        let (cache, _) = cached(&set, &map, &[0.2, 0.7], half);
        let len = cache.matrices(0) * 3;
        let mut floats = vec![[0.0; 4]; len];
        let mut halves = vec![[0; 4]; len];
        for backend in Backend::ALL.into_iter().filter(|b| b.is_available()) {
            let counted = allocation_counter::measure(|| {
                let mut record = cache.locate(0, 0, 0.05).unwrap();
                record.character = 3;
                let out = if half {
                    PaletteRows::Half(&mut halves)
                } else {
                    PaletteRows::Float(&mut floats)
                };
                cache.blend(0, &[record], backend, out);
            });
            assert_eq!(counted.count_total, 0, "{backend}");
        }
    }
}
