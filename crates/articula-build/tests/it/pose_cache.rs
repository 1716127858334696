//! Properties of baked pose caches, on random rigs, skins and clips.

use crate::random_figure::{RATE, Row, character_of, flat, rows};
use crate::reference_human::asset_of_4000;
use articula_build::ClipOptions;
use articula_build::{Asset, character};
use articula_build::{CacheDecision, CacheOptions, CacheReport, CachedPoses, cached_poses};
use articula_build::{JointLodOptions, MergedLevels, merged_levels};
use articula_core::batch::BatchEvaluator;
use articula_core::{
    Backend, BlendRecord, CachedRows, ClipSet, ClipStorage, PaletteForm, PaletteRows,
    f32_from_half, percentile, skin_points,
};
use glam::{Affine3A, Vec3};
use proptest::prelude::*;

/// Rounding of f32 positions of up to some metres.
const ROUNDING_METRES: f32 = 1e-5;

struct Figure {
    asset: Asset,
    levels: MergedLevels,
    clips: ClipSet,
}

fn asset(rows: &[Row]) -> Asset {
    let opts = ClipOptions {
        rate_hz: Some(RATE),
    };
    character(&character_of(rows), Some(flat(rows.len())), &opts).unwrap()
}

fn prepared(asset: Asset) -> Figure {
    let opts = JointLodOptions {
        min_joints: 1,
        ..JointLodOptions::default()
    };
    let levels = merged_levels(&asset, &opts).unwrap();
    let joint_lods = levels.joint_lods.clone();
    let clips = ClipSet::new(&asset.rig, joint_lods, &asset.clips, ClipStorage::Float).unwrap();
    Figure {
        asset,
        levels,
        clips,
    }
}

impl Figure {
    fn cached(&self, opts: &CacheOptions) -> CachedPoses {
        cached_poses(&self.asset, &self.levels, &self.clips, opts).unwrap()
    }

    /// Positions of all vertices of a level under a palette.
    fn points(&self, level: usize, rows: &[[f32; 4]]) -> Vec<Vec3> {
        let mesh = self.levels.skins.mesh(level, &self.asset.mesh);
        let matrices = rows.chunks(3).map(|r| {
            let column = |c: usize| Vec3::new(r[0][c], r[1][c], r[2][c]).into();
            Affine3A::from_cols(column(0), column(1), column(2), column(3))
        });
        let vertices: Vec<u32> = (0..mesh.len() as u32).collect();
        let mut out = vec![Vec3::ZERO; vertices.len()];
        skin_points(&mesh, &matrices.collect::<Vec<_>>(), &vertices, &mut out);
        out
    }

    fn evaluated(&self, level: usize, secs: f32) -> Vec<Vec3> {
        let map = &self.levels.skins.palette;
        let form = PaletteForm::Matrix;
        let evaluator = BatchEvaluator::new(&self.clips, map, form, Backend::best()).unwrap();
        let mut rows = vec![[0.0; 4]; evaluator.rows(level)];
        let shown = [self.clips.cursor(0, secs).into()];
        let out = PaletteRows::Float(&mut rows);
        evaluator.evaluate(level, &shown, out, &mut evaluator.scratch());
        self.points(level, &rows)
    }

    /// Skin of a record of the cache.
    fn shown(&self, made: &CachedPoses, level: usize, record: BlendRecord) -> Vec<Vec3> {
        let cache = &made.cache;
        let len = cache.matrices(level) * 3;
        let (mut floats, mut halves) = (vec![[0.0; 4]; len], vec![[0; 4]; len]);
        if cache.form().is_half() {
            cache.blend(
                level,
                &[record],
                Backend::best(),
                PaletteRows::Half(&mut halves),
            );
            floats = halves.iter().map(|row| row.map(f32_from_half)).collect();
        } else {
            cache.blend(
                level,
                &[record],
                Backend::best(),
                PaletteRows::Float(&mut floats),
            );
        }
        self.points(level, &floats)
    }

    /// 95th percentile and maximum of the distance between blended and evaluated skin.
    fn error(&self, made: &CachedPoses, level: usize, secs: f32) -> (f32, f32) {
        let record = made.cache.locate(0, level, secs).unwrap();
        self.apart(level, secs, &self.shown(made, level, record))
    }

    /// The same with the nearest palette as it is.
    fn step_error(&self, made: &CachedPoses, level: usize, secs: f32) -> (f32, f32) {
        let record = BlendRecord::of_key(made.cache.nearest(0, level, secs).unwrap());
        self.apart(level, secs, &self.shown(made, level, record))
    }

    /// The same with a blend of the two steps around the time.
    fn step_blend_error(&self, made: &CachedPoses, level: usize, secs: f32) -> (f32, f32) {
        let record = made.cache.between_steps(0, level, secs).unwrap();
        self.apart(level, secs, &self.shown(made, level, record))
    }

    fn apart(&self, level: usize, secs: f32, shown: &[Vec3]) -> (f32, f32) {
        let truth = self.evaluated(level, secs);
        let apart = truth.iter().zip(shown).map(|(t, s)| t.distance(*s));
        let mut apart: Vec<f32> = apart.collect();
        (percentile(&mut apart, 0.95), percentile(&mut apart, 1.0))
    }
}

fn palette_bytes_of(made: &CachedPoses) -> usize {
    match made.cache.rows() {
        CachedRows::Float(rows) => size_of_val(rows.as_slice()),
        CachedRows::Half(rows) => size_of_val(rows.as_slice()),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn the_stated_error_holds_at_any_time(
        rows in rows(),
        at in prop::collection::vec(0.0f32..1.0, 24),
        half in any::<bool>(),
    ) {
        let figure = prepared(asset(&rows));
        let opts = CacheOptions {
            form: if half { PaletteForm::HalfMatrix } else { PaletteForm::Matrix },
            ..CacheOptions::default()
        };
        let made = figure.cached(&opts);
        let end = figure.clips.duration_secs(0);
        // Half floats round what is cached and what is written: at a time between those measured
        // their noise may be greater, by twice half a step of four numbers within 4 m.
        let noise = if half { 2.0 * 4.0 * 4.0 / 4096.0 } else { ROUNDING_METRES };
        for report in made.report.iter().filter(|r| r.decision == CacheDecision::Cached) {
            prop_assert_eq!(made.cache.error_metres(0, report.level), Some(report.error_metres));
            prop_assert!(report.error_metres <= report.worst_metres);
            let keys: Vec<f32> = made.cache.times_secs(0, report.level).unwrap().collect();
            prop_assert!(end > (keys.len() - 1) as f32 * 2.0 / 60.0);
            for at in &at {
                let (percentile, worst) = figure.error(&made, report.level, at * end);
                prop_assert!(
                    percentile <= report.error_metres + noise && worst <= report.worst_metres + noise,
                    "level {}: {percentile} and {worst} m at {} s, stated {report:?}", report.level, at * end
                );
            }
            // At a key the only error is the rounding of half floats.
            for key in keys {
                let (_, worst) = figure.error(&made, report.level, key);
                prop_assert!(worst <= if half { noise } else { ROUNDING_METRES }, "{worst}");
            }
        }
    }

    #[test]
    fn the_stated_error_of_steps_holds_at_any_time(
        rows in rows(),
        at in prop::collection::vec(0.0f32..1.0, 24),
        half in any::<bool>(),
    ) {
        let figure = prepared(asset(&rows));
        let opts = CacheOptions {
            form: if half { PaletteForm::HalfMatrix } else { PaletteForm::Matrix },
            ..CacheOptions::default()
        };
        let made = figure.cached(&opts);
        let end = figure.clips.duration_secs(0);
        let noise = if half { 2.0 * 4.0 * 4.0 / 4096.0 } else { ROUNDING_METRES };
        let mut levels = made.report.iter().filter(|r| r.steps > 0).peekable();
        prop_assert!(levels.peek().is_some());
        for report in levels {
            let stated = report.step_error_metres;
            prop_assert_eq!(made.cache.step_error_metres(0, report.level), Some(stated));
            // Two for each frame of a display at most.
            prop_assert!((report.steps - 1) as f32 <= (120.0 * end).ceil() + 1.0);
            for at in &at {
                let (percentile, worst) = figure.step_error(&made, report.level, at * end);
                prop_assert!(
                    percentile <= stated + noise && worst <= 2.0 * stated + noise,
                    "level {}: {percentile} and {worst} m at {} s, stated {report:?}", report.level, at * end
                );
            }
        }
    }

    #[test]
    fn the_stated_error_of_blended_steps_and_of_records_holds_at_any_time(
        rows in rows(),
        at in prop::collection::vec(0.0f32..1.0, 24),
        half in any::<bool>(),
    ) {
        let figure = prepared(asset(&rows));
        let opts = CacheOptions {
            form: if half { PaletteForm::HalfMatrix } else { PaletteForm::Matrix },
            ..CacheOptions::default()
        };
        let made = figure.cached(&opts);
        let end = figure.clips.duration_secs(0);
        let noise = if half { 2.0 * 4.0 * 4.0 / 4096.0 } else { ROUNDING_METRES };
        for report in made.report.iter().filter(|r| r.steps > 0) {
            let (stated, worst_stated) = (report.step_blend_metres, report.step_blend_worst_metres);
            let of_keys = made.cache.error_metres(0, report.level);
            let of_record = made.cache.record_error_metres(0, report.level).unwrap();
            prop_assert_eq!(of_record, of_keys.unwrap_or(f32::INFINITY).min(stated));
            for at in &at {
                let (percentile, worst) = figure.step_blend_error(&made, report.level, at * end);
                prop_assert!(
                    percentile <= stated + noise && worst <= worst_stated + noise,
                    "level {}: {percentile} and {worst} m at {} s, stated {report:?}", report.level, at * end
                );
                let record = made.cache.record(0, report.level, at * end).unwrap();
                let shown = figure.shown(&made, report.level, record);
                let (percentile, worst) = figure.apart(report.level, at * end, &shown);
                prop_assert!(
                    percentile <= of_record + noise && worst <= 2.0 * of_record + noise,
                    "level {}: {percentile} and {worst} m at {} s, stated {of_record}", report.level, at * end
                );
            }
        }
    }

    #[test]
    fn errors_stay_near_the_tolerance_and_grow_with_it(rows in rows()) {
        let figure = prepared(asset(&rows));
        let made = figure.cached(&CacheOptions::default());
        for report in &made.report {
            let own: Vec<f32> = figure.levels.errors.clips[0].judged().collect();
            let floor = 0.5e-3 * f32::powi(2.0, report.level as i32);
            let least = floor.max(0.25 * own[report.level]);
            let wider = own.get(report.level + 1).map_or(0.0, |next| next - own[report.level]);
            let tolerance = report.tolerance_metres;
            prop_assert!(tolerance == least || (tolerance <= wider && tolerance <= 8.0 * least));
            prop_assert_eq!((tolerance / least).log2().fract(), 0.0, "doubled, or not");
            // Chosen within the tolerance at half ticks, plus half of the curvature within a tick.
            prop_assert!(report.error_metres <= 1.5 * report.tolerance_metres + ROUNDING_METRES, "{report:?}");
            prop_assert_eq!(made.cache.error_metres(0, report.level).is_some(), report.decision == CacheDecision::Cached);
        }
    }

    #[test]
    fn coarse_levels_come_first_where_room_is_short(rows in rows(), part in 0.0f32..1.0) {
        let figure = prepared(asset(&rows));
        let whole = figure.cached(&CacheOptions::default());
        let all = palette_bytes_of(&whole);
        let sizes = |made: &CachedPoses| -> usize {
            made.report.iter().map(|r| r.step_bytes + usize::from(r.decision == CacheDecision::Cached) * r.bytes).sum()
        };
        prop_assert_eq!(sizes(&whole), all);
        let palette_bytes = (all as f32 * part) as usize;
        let made = figure.cached(&CacheOptions { palette_bytes, ..CacheOptions::default() });
        prop_assert!(palette_bytes_of(&made) <= palette_bytes);
        prop_assert_eq!(sizes(&made), palette_bytes_of(&made));
        // Who has palettes has them at all coarser levels too: those of the finest of these.
        let finest = |made: &CachedPoses, has: fn(&CacheReport) -> bool| {
            let first = made.report.iter().position(has).unwrap_or(made.report.len());
            assert!(made.report[first..].iter().all(has), "{:?}", made.report);
            first
        };
        let has_keys = |r: &CacheReport| r.decision == CacheDecision::Cached;
        let has_steps = |r: &CacheReport| r.steps > 0;
        for (has, list) in [(has_keys as fn(&CacheReport) -> bool, 0), (has_steps, 1)] {
            let (few, all) = (finest(&made, has), finest(&whole, has));
            prop_assert!(few >= all);
            let bytes = |r: &CacheReport| [r.bytes * usize::from(has_keys(r)), r.step_bytes][list];
            for (level, (made, whole)) in made.report.iter().zip(&whole.report).enumerate() {
                prop_assert_eq!(bytes(made) > 0, level == few);
                if few == all {
                    let shown = |r: &CacheReport| match list {
                        0 => (r.keys, r.error_metres),
                        _ => (r.steps, r.step_error_metres),
                    };
                    prop_assert_eq!(shown(made), shown(whole));
                } else if level < few && has(whole) {
                    prop_assert!(list == 1 || made.decision == CacheDecision::NoRoom);
                }
            }
        }
        // A level that shares palettes shows them as its own: its joints are posed alike.
        for report in made.report.iter().filter(|r| has_steps(r)) {
            let (_, worst) = figure.step_error(&made, report.level, 0.0);
            prop_assert!(worst <= ROUNDING_METRES);
        }
    }
}

/// The sample of vertices decides about keys and the percentile alone.
#[test]
fn the_stated_error_holds_for_every_vertex_of_a_character() {
    let mut asset = asset_of_4000().clone();
    // The walk.
    asset.clips.swap(0, 1);
    asset.clips.truncate(1);
    let figure = prepared(asset);
    let opts = CacheOptions {
        vertices: 50,
        ..CacheOptions::default()
    };
    let made = figure.cached(&opts);
    let mut cached = 0;
    for report in made
        .report
        .iter()
        .filter(|r| r.decision == CacheDecision::Cached)
    {
        cached += 1;
        let mut most = 0.0f32;
        for at in 0..400 {
            let secs = figure.clips.duration_secs(0) * at as f32 / 399.0;
            let (_, worst) = figure.error(&made, report.level, secs);
            most = most.max(worst);
        }
        assert!(
            most <= report.worst_metres + ROUNDING_METRES,
            "{most} m, {report:?}"
        );
        assert!(most <= 2.0 * report.error_metres + ROUNDING_METRES);
        // Half of the bend of the true path in a tick is added.
        assert!(most >= 0.5 * report.worst_metres, "{most} m, {report:?}");
    }
    assert!(cached > 1);
    let mut stepped = 0;
    for report in made.report.iter().filter(|r| r.steps > 0) {
        stepped += 1;
        let secs = |at: usize| figure.clips.duration_secs(0) * at as f32 / 999.0;
        let errors = (0..1000).map(|at| figure.step_error(&made, report.level, secs(at)));
        let most = errors.map(|e| e.1).fold(0.0, f32::max);
        let stated = report.step_error_metres;
        assert!(
            most <= 2.0 * stated + ROUNDING_METRES,
            "{most} m, {report:?}"
        );
        assert!(most >= 0.5 * stated, "{most} m, {report:?}");
        let errors = (0..1000).map(|at| figure.step_blend_error(&made, report.level, secs(at)));
        let most = errors.map(|e| e.1).fold(0.0, f32::max);
        let stated = report.step_blend_worst_metres;
        assert!(most <= stated + ROUNDING_METRES, "{most} m, {report:?}");
        // Half of the bend of the true path in a tick is added, and at 120 Hz a tick is all of a span.
        assert!(most >= 0.25 * stated, "{most} m, {report:?}");
    }
    assert!(stepped > 1);
}

/// Three joints at some distance from each other.
fn three() -> Vec<Row> {
    let turn = Vec3::new(0.1, -0.05, 0.02);
    let rest = glam::Quat::from_rotation_x(0.3);
    (0..3).map(|_| (0.9, Vec3::Y * 0.4, rest, turn)).collect()
}

#[test]
fn hostile_figures() {
    let mut without_clips = asset(&three());
    without_clips.clips.clear();
    let figure = prepared(without_clips);
    let made = figure.cached(&CacheOptions::default());
    assert_eq!(made.report.len(), figure.levels.joint_lods.levels());
    let rest = made.cache.locate(0, 0, f32::NAN).unwrap();
    assert_eq!((rest.before, rest.blend), (rest.after, 0.0));

    let mut without_mesh = asset(&three());
    without_mesh.mesh = articula_core::Mesh::default().into();
    let figure = prepared(without_mesh);
    let made = figure.cached(&CacheOptions::default());
    assert!(
        made.report
            .iter()
            .all(|r| r.decision == CacheDecision::TooFast)
    );
    assert_eq!(palette_bytes_of(&made), 0);

    let figure = prepared(asset(&three()[..1]));
    let nothing = CacheOptions {
        palette_bytes: 0,
        ..CacheOptions::default()
    };
    assert!(
        figure
            .cached(&nothing)
            .report
            .iter()
            .all(|r| r.decision != CacheDecision::Cached)
    );
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let figure = prepared(asset(&three()));
    let other = prepared(asset(&three()[..2]));
    let make = |asset: &Asset, levels: &MergedLevels, opts: CacheOptions| {
        cached_poses(asset, levels, &figure.clips, &opts)
            .map_err(|e| e.at)
            .err()
    };
    let opts = CacheOptions::default();
    assert_eq!(make(&figure.asset, &figure.levels, opts), None);
    assert_eq!(make(&other.asset, &figure.levels, opts).unwrap(), "clips");
    assert_eq!(make(&figure.asset, &other.levels, opts).unwrap(), "clips");
    let mut longer = figure.asset.clone();
    longer.clips.push(longer.clips[0].clone());
    assert_eq!(make(&longer, &figure.levels, opts).unwrap(), "clips");
    let rigid = CacheOptions {
        form: PaletteForm::Rigid,
        ..opts
    };
    assert_eq!(make(&figure.asset, &figure.levels, rigid).unwrap(), "form");
    let nan = CacheOptions {
        share: f32::NAN,
        ..opts
    };
    assert_eq!(make(&figure.asset, &figure.levels, nan).unwrap(), "share");
}
