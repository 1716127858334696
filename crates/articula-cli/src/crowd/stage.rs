//! A scene on one thread or several: the library's frames, timed.

use super::timing::thread_ns;
use anyhow::Context;
use articula::crowd::{
    CacheUse, CrowdAsset, CrowdReport, DetailGoal, FrameBudget, FramePart, SceneOptions,
    ScenePlayer,
};
use articula_build::Scene;
use rayon::ThreadPool;
use rayon::prelude::*;

/// Frames a second of the display.
pub(crate) const DISPLAY_HZ: f64 = 60.0;

/// Parts of a frame for each thread: more than one, so that none waits long for the others.
const PARTS_PER_THREAD: usize = 4;

/// How a scene is played.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Settings {
    pub(crate) detail: DetailGoal,
    /// Whether characters may share poses within their tolerance.
    pub(crate) share: bool,
    /// Who blends cached poses.
    pub(crate) cache: CacheUse,
    pub(crate) threads: usize,
    /// Frames that count.
    pub(crate) frames: usize,
}

/// A scene and the threads that it is played on.
#[derive(Debug)]
pub(crate) struct TimedCrowd<'a> {
    pub(crate) scene: ScenePlayer<'a>,
    pool: Option<ThreadPool>,
    parts: usize,
}

impl<'a> TimedCrowd<'a> {
    /// Puts everyone in place at time 0.
    pub(crate) fn new(
        asset: &CrowdAsset,
        scene: &'a Scene,
        settings: Settings,
    ) -> anyhow::Result<Self> {
        let options = SceneOptions {
            detail: settings.detail,
            share: settings.share,
            cache: settings.cache,
        };
        let several = settings.threads > 1;
        let pool = several.then(|| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(settings.threads);
            pool.build().context("threads")
        });
        Ok(Self {
            scene: ScenePlayer::new(asset, scene, options)?,
            pool: pool.transpose()?,
            parts: if several {
                PARTS_PER_THREAD * settings.threads
            } else {
                1
            },
        })
    }

    /// Goes on by some time and plans the frame.
    pub(crate) fn plan(
        &mut self,
        dt_secs: f64,
        allowance: Option<&FrameBudget>,
    ) -> anyhow::Result<CrowdReport> {
        Ok(self.scene.plan(dt_secs, allowance)?)
    }

    /// Writes all palettes; gives the processor time that it took, on all threads together.
    pub(crate) fn evaluate(&mut self) -> u64 {
        let timed = |part: &mut FramePart<'_>| {
            let start = thread_ns();
            part.evaluate();
            thread_ns() - start
        };
        let parts = self.scene.player_mut().parts(self.parts);
        match &self.pool {
            None => parts.map(|mut part| timed(&mut part)).sum(),
            Some(pool) => {
                let mut parts: Vec<FramePart<'_>> = parts.collect();
                pool.install(|| parts.par_iter_mut().map(timed).sum())
            }
        }
    }
}
