//! Faces of a crowd: morph targets of the clips of each character, as the plain path shows them.

use crate::crowd::{asset_of, row};
use crate::real::file;
use articula::crowd::{CacheUse, CrowdOptions, Culling, Detail, ErrorMeter, PaletteHash, View};
use articula_core::{Wrap, sample_morphs};
use glam::Vec3;

#[test]
fn every_head_shows_its_own_clip_and_time() {
    let Some(path) = file("glb/ict_head_talk_554.glb") else {
        return;
    };
    let opened = articula::fs::open(path).unwrap();
    let asset = asset_of(opened, &CrowdOptions::default());
    assert_eq!(asset.warnings(), [""; 0]);
    let (mut crowd, camera) = row(&asset, 12);
    crowd.detail = Detail::Full;
    let full = asset.full();
    let mut open = 0;
    for _ in 0..10 {
        let report = crowd.frame(0.05, &camera);
        assert_eq!(report.visible, 12);
        for character in 0..12 {
            let state = *crowd.crowd().state(character).clip_state();
            let mut expected = full.mesh.morph_weights.clone();
            let (clip, secs) = (&full.clips[state.clip()], f64::from(state.secs()));
            sample_morphs(clip, secs, Wrap::Loop, &mut expected);
            let found = crowd.morph_weights_of(character);
            assert_eq!(found.len(), expected.len());
            let near = |(a, b): (&f32, &f32)| (a - b).abs() < 1e-4;
            assert!(found.iter().zip(&expected).all(near), "{character}");
            open += usize::from(found != full.mesh.morph_weights);
        }
    }
    assert!(open > 60, "{open} of 120 faces are not at rest");
    // Palettes and weights are those of the full character, so nothing differs.
    let mut meter = ErrorMeter::new(&asset, 1);
    let sample = meter.measure(&crowd, 0.0, &[camera.into()]);
    assert!(sample.characters.len() > 6);
    assert!(sample.characters.iter().all(|c| c.worst_px < 0.02));
}

#[test]
fn who_writes_the_weights_changes_no_bit() {
    let Some(path) = file("glb/ict_head_talk_554.glb") else {
        return;
    };
    let opened = articula::fs::open(path).unwrap();
    for (pose_cache, cache) in [(false, CacheUse::Never), (true, CacheUse::Gpu)] {
        let options = CrowdOptions {
            pose_cache,
            ..CrowdOptions::default()
        };
        let asset = asset_of(opened.clone(), &options);
        let run = |parts: usize| {
            let (mut crowd, camera) = row(&asset, 60);
            crowd.cache = cache;
            for i in 0..60 {
                // From far away to a few metres before the camera.
                let place = Vec3::new(0.1 * i as f32 - 3.0, 0.0, 4.0 * i as f32);
                crowd.place(i, place, 0.0);
            }
            let mut hash = PaletteHash::default();
            for _ in 0..3 {
                let views = [View::of(&camera)];
                crowd.plan(1.0 / 60.0, Culling::Views(&views), &mut |_| ());
                let mut parts: Vec<_> = crowd.parts(parts).collect();
                parts.reverse();
                parts.iter_mut().for_each(|part| part.evaluate());
                drop(parts);
                hash.add(&crowd);
                assert!(!crowd.morph_weights().is_empty());
            }
            hash.text()
        };
        let one = run(1);
        assert_eq!(one, run(5));
        assert_eq!(one, run(1000));
    }
}

#[test]
fn faces_leave_out_targets_within_the_tolerance() {
    let Some(path) = file("glb/ict_head_talk_554.glb") else {
        return;
    };
    let opened = articula::fs::open(path).unwrap();
    let asset = asset_of(opened, &CrowdOptions::default());
    let model = asset.model();
    let lods = model.parts().morphs.as_ref().unwrap().lods();
    let all = lods.count(0);
    assert!(lods.levels() > 3 && lods.count(lods.levels() - 1) == 0);
    let (mut crowd, camera) = row(&asset, 60);
    for i in 0..60 {
        let place = Vec3::new(0.1 * i as f32 - 3.0, 0.0, 4.0 * i as f32);
        crowd.place(i, place, 0.0);
    }
    let mut meter = ErrorMeter::new(&asset, 1);
    let (mut some, mut none) = (0, 0);
    for frame in 0..12 {
        crowd.frame(0.1, &camera);
        let list = crowd.crowd().draw_list();
        for character in list.draws.iter().map(|d| d.character as usize) {
            let level = crowd.crowd().morph_level(model, character).unwrap();
            let shown = lods.count(level);
            some += usize::from(shown > 0 && shown < all);
            none += usize::from(shown == 0);
            let weights = crowd.morph_weights_of(character);
            for target in &lods.order()[shown..] {
                let target = usize::from(*target);
                let rest = asset.full().mesh.morph_weights[target];
                assert_eq!(weights[target], rest, "character {character}");
            }
        }
        assert!(list.morph_sets() < list.draws.len(), "frame {frame}");
        let sample = meter.measure(&crowd, 0.0, &[camera.into()]);
        for found in &sample.characters {
            let near = found.distance_m;
            assert!(found.p95_px <= 1.0, "{} px at {near} m", found.p95_px);
            assert!(found.worst_px <= 2.0, "{} px at {near} m", found.worst_px);
        }
    }
    assert!(
        some > 24 && none > 60,
        "{some} with some targets, {none} with none"
    );
}
