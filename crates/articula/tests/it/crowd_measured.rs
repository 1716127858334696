//! Measured scenes, by clocks of the test.

use crate::crowd::{asset_of, human, human_asset};
use articula::crowd::{
    Backend, CacheUse, CrowdAsset, CrowdOptions, DetailGoal, FrameClocks, Hiders, MeasureOptions,
    SceneMeasurement, SceneOptions, measure_scene,
};
use articula::{Executor, Job};
use articula_build::{Plaza, plaza};
use std::slice::from_ref;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

const COUNT: usize = 30;

/// Measures a small plaza by clocks of which each reading is later by 1 ns and by 5 ns.
fn measured(asset: &CrowdAsset, detail: DetailGoal, threads: usize) -> SceneMeasurement {
    let scene = Arc::new(plaza(COUNT, &[asset.clips().len()], 1, Plaza::Moving));
    let options = MeasureOptions {
        scene: SceneOptions {
            detail,
            cache: CacheUse::Cpu,
            hiders: Hiders::Walls,
        },
        threads,
        frames: 20,
        seed: 1,
    };
    let (processor, wall) = (AtomicU64::new(0), AtomicU64::new(0));
    let clocks = FrameClocks {
        thread_ns: &|| processor.fetch_add(1, Ordering::Relaxed),
        wall_ns: &|| wall.fetch_add(5, Ordering::Relaxed),
    };
    let backwards = |jobs: &mut [Job<'_>]| jobs.iter_mut().rev().for_each(Job::run);
    let work = Executor::default().run_jobs(&backwards);
    measure_scene(from_ref(asset), &scene, &options, clocks, &work).unwrap()
}

#[test]
fn times_are_those_of_the_clocks() {
    let found = measured(human_asset(), DetailGoal::Tolerance(1.0), 1);
    // Pairs of readings: around the plan, one crowd's poses and the end of the frame.
    let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-9;
    assert!(near(found.frame_ms.median, 3e-6), "{:?}", found.frame_ms);
    assert!(near(found.frame_ms.p95, 3e-6), "{:?}", found.frame_ms);
    assert!(near(found.tick_ms.median, 2e-6), "{:?}", found.tick_ms);
    assert!(near(found.wall_ms.median, 5e-6), "{:?}", found.wall_ms);
    let count = COUNT as f64;
    assert!(near(found.ns_per_character.median, 3.0 / count));
    assert!(near(found.characters_per_ms, count / 3e-6));
    assert_eq!((found.budget_ms, found.overrun_p95), (None, None));
    assert_eq!((found.over_time.len(), found.samples.len()), (20, 16));
    assert_eq!(found.over_time[3].0, 0.05);
    let all = found.visible + found.in_cull_margin + found.hidden + found.occluded;
    assert_eq!((found.characters, all), (COUNT, COUNT));
}

#[test]
fn a_budget_of_less_than_a_reading_overruns() {
    // 1 ns of 3: the rest is twice the budget.
    let budget = |ms| DetailGoal::Budget { ms, cap_px: 1.0 };
    let tight = measured(human_asset(), budget(1e-6), 1);
    let over = tight.overrun_p95.unwrap();
    assert!((over - 2.0).abs() < 1e-5, "{over}");
    let ample = measured(human_asset(), budget(1.0), 1);
    assert_eq!(ample.overrun_p95, Some(0.0));
    assert_eq!(ample.budget.unwrap().overloaded, 0);
}

#[test]
fn threads_and_backends_show_the_same_bits_within_the_tolerance() {
    let one = measured(human_asset(), DetailGoal::Tolerance(1.0), 1);
    assert!(one.error_px.p95 <= 1.0, "{:?}", one.error_px);
    let three = measured(human_asset(), DetailGoal::Tolerance(1.0), 3);
    assert_eq!(one.palette_hash, three.palette_hash);
    let scalar = CrowdOptions {
        backend: Backend::Scalar,
        ..CrowdOptions::default()
    };
    let scalar = asset_of(human(), &scalar);
    let plain = measured(&scalar, DetailGoal::Tolerance(1.0), 1);
    assert_eq!(one.palette_hash, plain.palette_hash);
    let full = measured(human_asset(), DetailGoal::Full, 1);
    assert_eq!(full.error_bound_px, None);
    assert!(full.error_px.max < 0.02, "{:?}", full.error_px);
    assert_ne!(one.palette_hash, full.palette_hash);
}
