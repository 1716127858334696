//! Real characters: the stated error of a pose cache holds for its output.

use crate::real::bytes;
use articula::build::ClipOptions;
use articula::build::{Asset, character};
use articula::build::{CacheDecision, CacheOptions, CachedPoses, cached_poses};
use articula::build::{JointLodOptions, MergedLevels, merged_levels};
use articula::core::batch::BatchEvaluator;
use articula::core::{Backend, ClipSet, ClipStorage, PaletteForm, PaletteRows, skin_points};
use articula::formats::{Limits, gltf, joint_map};
use glam::{Affine3A, Vec3};

fn asset() -> Option<Asset> {
    let bytes = bytes("glb/pab_arnaud.glb")?;
    let mut beside = |_: &str| Err("one file".to_owned());
    let file = gltf::read(&bytes, &Limits::default(), &mut beside)
        .unwrap()
        .value;
    let mapping =
        articula::build::joint_names::map(&file.character.skeleton, joint_map::builtin(), None);
    let opts = ClipOptions::default();
    let mut asset = character(&file.character, Some(mapping.articulation), &opts).unwrap();
    // Walk, jog and run; the fourth clip lasts 15 s and would take most of the test's time.
    asset.clips.truncate(3);
    Some(asset)
}

/// Every vertex of the level's skin under a palette.
fn points(asset: &Asset, levels: &MergedLevels, level: usize, rows: &[[f32; 4]]) -> Vec<Vec3> {
    let mesh = levels.skins.mesh(level, &asset.mesh);
    let matrices = rows.chunks(3).map(|r| {
        let column = |c: usize| Vec3::new(r[0][c], r[1][c], r[2][c]).into();
        Affine3A::from_cols(column(0), column(1), column(2), column(3))
    });
    let vertices: Vec<u32> = (0..mesh.len() as u32).collect();
    let mut out = vec![Vec3::ZERO; vertices.len()];
    skin_points(&mesh, &matrices.collect::<Vec<_>>(), &vertices, &mut out);
    out
}

/// 95th percentile over all vertices of the error of blending at a time, metres.
fn error(
    asset: &Asset,
    (levels, clips): (&MergedLevels, &ClipSet),
    made: &CachedPoses,
    (clip, level): (usize, usize),
    secs: f32,
) -> f32 {
    let map = &levels.skins.palette;
    let form = PaletteForm::Matrix;
    let evaluator = BatchEvaluator::new(clips, map, form, Backend::best()).unwrap();
    let mut rows = vec![[0.0; 4]; evaluator.rows(level)];
    let shown = [clips.cursor(clip, secs).into()];
    let out = PaletteRows::Float(&mut rows);
    evaluator.evaluate(level, &shown, out, &mut evaluator.scratch());
    let truth = points(asset, levels, level, &rows);
    let record = [made.cache.locate(clip, level, secs).unwrap()];
    let out = PaletteRows::Float(&mut rows);
    made.cache.blend(level, &record, Backend::best(), out);
    let shown = points(asset, levels, level, &rows);
    let mut apart: Vec<f32> = truth
        .iter()
        .zip(&shown)
        .map(|(t, s)| t.distance(*s))
        .collect();
    apart.sort_by(f32::total_cmp);
    apart[(0.95 * (apart.len() - 1) as f32) as usize]
}

#[test]
fn a_walking_human_blends_within_what_its_cache_states() {
    let Some(asset) = asset() else { return };
    let levels = merged_levels(&asset, &JointLodOptions::default()).unwrap();
    let joint_lods = levels.joint_lods.clone();
    let clips = ClipSet::new(&asset.rig, joint_lods, &asset.clips, ClipStorage::Float).unwrap();
    // Every vertex is measured, so there is no sampling error.
    let opts = CacheOptions {
        vertices: usize::MAX,
        ..CacheOptions::default()
    };
    let made = cached_poses(&asset, &levels, &clips, &opts).unwrap();
    assert_eq!(made.report.len(), 3 * levels.joint_lods.levels());
    for report in &made.report {
        let (clip, level) = (report.clip, report.level);
        println!(
            "{} level {level}: {:?}, {} keys, {} bytes, {:.2} mm for {:.2} mm",
            asset.clips[clip].name,
            report.decision,
            report.keys,
            report.bytes,
            report.error_metres * 1e3,
            report.tolerance_metres * 1e3,
        );
        assert_ne!(report.decision, CacheDecision::NoRoom);
        if report.decision != CacheDecision::Cached {
            continue;
        }
        // Times that are no multiples of anything.
        for i in 0..60u32 {
            let secs = (i as f32 * 0.618_034).fract() * clips.duration_secs(clip);
            let found = error(&asset, (&levels, &clips), &made, (clip, level), secs);
            assert!(
                found <= report.error_metres + 1e-5,
                "{found} m at {secs} s, {report:?}"
            );
        }
    }
    // The coarsest level of every clip is slow enough for its tolerance.
    let coarsest = levels.joint_lods.levels() - 1;
    assert!((0..3).all(|clip| made.cache.error_metres(clip, coarsest).is_some()));
}
