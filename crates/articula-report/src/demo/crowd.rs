//! The crowd of the demo: the character on a small plaza, at full detail and with levels.

use super::files::DemoFiles;
use crate::clocks::FRAME_CLOCKS;
use crate::scene_picture::scene_picture;
use articula::build::{Plaza, plaza};
use articula::crowd::{
    CacheUse, CrowdAsset, CrowdOptions, DetailGoal, Hiders, JointLodMethod, LevelStatistics,
    MeasureOptions, SceneMeasurement, SceneOptions, ScenePlayer, measure_scene,
};
use articula::{Executor, Figure, Result};
use serde::Serialize;
use std::slice::from_ref;
use std::sync::Arc;

/// Number of characters: a square of 14 by 14.
const COUNT: usize = 196;
/// Number of frames to play.
const FRAMES: usize = 60;
const SEED: u64 = 1;
const PICTURE_PX: (u32, u32) = (1120, 630);

/// Cost and error of a small crowd.
#[derive(Debug, Serialize)]
pub(super) struct Crowd {
    pub(super) characters: usize,
    pub(super) visible: usize,
    pub(super) epsilon_px: f32,
    pub(super) ways: Vec<CrowdVariant>,
    /// Levels of the second variant.
    pub(super) levels: Vec<LevelStatistics>,
}

/// Cost and error of one variant.
#[derive(Debug, Serialize)]
pub(super) struct CrowdVariant {
    pub(super) label: &'static str,
    pub(super) ns_per_character: f64,
    pub(super) written_mb: f64,
    pub(super) error_px_p95: f64,
    pub(super) error_px_max: f64,
}

/// Plays the crowd in three variants and draws it.
pub(super) fn of(
    figure: &Figure,
    epsilon_px: f32,
    files: &mut DemoFiles,
    work: &Executor<'_>,
) -> Result<Crowd> {
    let clips = [figure.asset.clips.len()];
    let scene = Arc::new(plaza(COUNT, &clips, SEED, Plaza::Still));
    let asset = |joints| CrowdAsset::new(figure, &options(joints), work);
    let (whole, merged) = (
        asset(JointLodMethod::Whole)?,
        asset(JointLodMethod::Merged)?,
    );
    let play = |asset, detail, cache| {
        let options = MeasureOptions {
            scene: played(detail, cache),
            threads: 1,
            frames: FRAMES,
            seed: SEED,
        };
        measure_scene(from_ref(asset), &scene, &options, FRAME_CLOCKS, work)
    };
    let tolerance = DetailGoal::Tolerance(epsilon_px);
    let full = play(&whole, DetailGoal::Full, CacheUse::Never)?;
    let seen = play(&merged, tolerance, CacheUse::Never)?;
    let cached = play(&merged, tolerance, CacheUse::Cpu)?;
    let evaluated = played(tolerance, CacheUse::Never);
    let mut player = ScenePlayer::new(from_ref(&merged), scene.clone(), evaluated)?;
    player.plan(0.0)?;
    player.evaluate();
    let characters = [figure.opened.character()];
    let title = format!("A crowd of {COUNT}");
    let time = format!(
        "Time {:.3} ms per frame (median), error {:.2} px (p95), {:.2} px (maximum).",
        seen.frame_ms.median, seen.error_px.p95, seen.error_px.max
    );
    let heading = (&title[..], vec![time]);
    let picture = scene_picture(&player, &characters, PICTURE_PX, heading)?;
    files.add_png("crowd.png", &picture)?;
    Ok(Crowd {
        characters: COUNT,
        visible: seen.visible,
        epsilon_px,
        ways: vec![
            variant("all joints of all characters", &full),
            variant("merged levels, characters in view", &seen),
            variant("as above, with cached poses", &cached),
        ],
        levels: seen.levels.into_iter().flatten().collect(),
    })
}

fn options(joints: JointLodMethod) -> CrowdOptions {
    CrowdOptions {
        pose_cache: joints == JointLodMethod::Merged,
        joints,
        seed: SEED,
        ..CrowdOptions::default()
    }
}

fn played(detail: DetailGoal, cache: CacheUse) -> SceneOptions {
    SceneOptions {
        detail,
        cache,
        hiders: Hiders::Walls,
    }
}

fn variant(label: &'static str, measured: &SceneMeasurement) -> CrowdVariant {
    CrowdVariant {
        label,
        ns_per_character: measured.ns_per_character.median,
        written_mb: measured.written_mb.median,
        error_px_p95: measured.error_px.p95,
        error_px_max: measured.error_px.max,
    }
}
