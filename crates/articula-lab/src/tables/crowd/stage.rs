//! A crowd of Articula on a scene, measured by the library.

use super::SEED;
use anyhow::Result;
use articula::Executor;
use articula::crowd::{
    CacheUse, CrowdAsset, CrowdOptions, DetailGoal, Hiders, MeasureOptions, SceneMeasurement,
    SceneOptions, ScenePlayer, measure_scene,
};
use articula_build::{Asset, Scene};
use articula_report::FRAME_CLOCKS;
use std::slice::from_ref;
use std::sync::Arc;

/// The character of all runs on scenes.
pub(super) struct SceneBench {
    asset: CrowdAsset,
}

/// Options for playing a scene.
#[derive(Clone, Copy)]
pub(super) struct Play {
    pub(super) detail: DetailGoal,
    pub(super) cache: CacheUse,
    pub(super) frames: usize,
}

impl Play {
    fn options(self) -> SceneOptions {
        SceneOptions {
            detail: self.detail,
            cache: self.cache,
            hiders: Hiders::Nothing,
        }
    }
}

impl SceneBench {
    /// Levels, skins, errors and bounds of a character with all its clips.
    pub(super) fn new(asset: Asset) -> Result<Self> {
        let options = CrowdOptions::default();
        let asset = CrowdAsset::from_asset(asset, &options, &Executor::default())?;
        Ok(Self { asset })
    }

    /// Number of joints that each level keeps.
    pub(super) fn kept(&self) -> Vec<usize> {
        let all = 0..self.asset.levels();
        all.map(|l| self.asset.level(l).joints).collect()
    }

    /// Plays a scene from its beginning on one thread.
    pub(super) fn play(&self, scene: &Arc<Scene>, play: Play) -> Result<SceneMeasurement> {
        let options = MeasureOptions {
            scene: play.options(),
            threads: 1,
            frames: play.frames,
            seed: SEED,
        };
        let (cast, work) = (from_ref(&self.asset), Executor::default());
        Ok(measure_scene(cast, scene, &options, FRAME_CLOCKS, &work)?)
    }

    /// The crowd of a scene at time 0.
    pub(super) fn player(&self, scene: &Arc<Scene>, play: Play) -> Result<ScenePlayer> {
        let cast = from_ref(&self.asset);
        Ok(ScenePlayer::new(cast, scene.clone(), play.options())?)
    }
}

/// Median time of the selection as a fraction of that of the evaluation.
pub(super) fn selection_share(found: &SceneMeasurement) -> f64 {
    let select_ms = found.tick_ms.median;
    select_ms / (found.frame_ms.median - select_ms).max(1e-9)
}
