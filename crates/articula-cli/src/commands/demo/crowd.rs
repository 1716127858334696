//! The crowd of the demo: the character on a small plaza, at full detail and with levels.

use super::Folder;
use crate::console::Console;
use crate::crowd::picture;
use crate::crowd::run::{self, Run};
use crate::crowd::stage::Settings;
use anyhow::Context;
use articula::Figure;
use articula::build::{Plaza, Scene, plaza};
use articula::crowd::{
    CacheUse, CrowdAsset, CrowdOptions, DetailGoal, Hiders, JointLodMethod, LevelStatistics,
};
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
    folder: &Folder<'_>,
    console: &Console,
) -> anyhow::Result<Crowd> {
    let scene = Arc::new(plaza(
        COUNT,
        &[figure.asset.clips.len()],
        SEED,
        Plaza::Still,
    ));
    let asset = |joints| console.work(|work| CrowdAsset::new(figure, &options(joints), work));
    let (whole, merged) = (
        asset(JointLodMethod::Whole)?,
        asset(JointLodMethod::Merged)?,
    );
    let tolerance = DetailGoal::Tolerance(epsilon_px);
    let evaluated = settings(tolerance, CacheUse::Never);
    let full = play(
        &whole,
        &scene,
        settings(DetailGoal::Full, CacheUse::Never),
        console,
    )?;
    let seen = play(&merged, &scene, evaluated, console)?;
    let cached = play(&merged, &scene, settings(tolerance, CacheUse::Cpu), console)?;
    let picture = picture::draw(from_ref(&merged), &scene, evaluated, PICTURE_PX)?;
    folder.write("crowd.png", &picture.to_png().context("crowd.png")?)?;
    Ok(Crowd {
        characters: COUNT,
        visible: seen.visible.median.round() as usize,
        epsilon_px,
        ways: vec![
            way("all joints of all characters", &full),
            way("merged levels, characters in view", &seen),
            way("as above, with cached poses", &cached),
        ],
        levels: seen.tiers.into_iter().flatten().collect(),
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

fn settings(detail: DetailGoal, cache: CacheUse) -> Settings {
    Settings {
        detail,
        cache,
        hiders: Hiders::Walls,
        threads: 1,
        frames: FRAMES,
    }
}

fn play(
    asset: &CrowdAsset,
    scene: &Arc<Scene>,
    settings: Settings,
    console: &Console,
) -> anyhow::Result<Run> {
    run::run(from_ref(asset), scene, settings, SEED, console)
}

fn way(label: &'static str, run: &Run) -> CrowdVariant {
    CrowdVariant {
        label,
        ns_per_character: 1e6 * run.frame_ms.median / COUNT as f64,
        written_mb: run.written_mb.median,
        error_px_p95: run.error.p95,
        error_px_max: run.error.max,
    }
}
