//! A scene on one or several threads: the frames of the library, timed.

use super::timing::thread_ns;
use anyhow::Context;
use articula::build::Scene;
use articula::crowd::{
    CacheUse, CrowdAsset, CrowdReport, CrowdSection, DetailGoal, FramePart, Hiders, SceneOptions,
    ScenePlayer,
};
use rayon::ThreadPool;
use rayon::prelude::*;
use std::sync::Arc;

/// Refresh rate of the display, hertz.
pub(crate) const DISPLAY_HZ: f64 = 60.0;

/// Parts of a frame per thread: more than one, so that no thread waits long for the others.
const PARTS_PER_THREAD: usize = 8;

/// Options for playing a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Settings {
    pub(crate) detail: DetailGoal,
    /// What blends cached poses: CPU, GPU or no cache.
    pub(crate) cache: CacheUse,
    /// What hides characters.
    pub(crate) hiders: Hiders,
    pub(crate) threads: usize,
    /// Number of frames that count.
    pub(crate) frames: usize,
}

/// A scene and the threads that evaluate it.
#[derive(Debug)]
pub(crate) struct TimedCrowd {
    pub(crate) scene: ScenePlayer,
    pool: Option<ThreadPool>,
    /// Number of parts of a frame; 1 on a single thread.
    parts: usize,
}

impl TimedCrowd {
    /// Places all characters at time 0.
    pub(crate) fn new(
        cast: &[CrowdAsset],
        scene: Arc<Scene>,
        settings: Settings,
    ) -> anyhow::Result<Self> {
        let options = SceneOptions {
            detail: settings.detail,
            cache: settings.cache,
            hiders: settings.hiders,
        };
        let several = settings.threads > 1;
        let pool = several.then(|| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(settings.threads);
            pool.build().context("threads")
        });
        Ok(Self {
            scene: ScenePlayer::new(cast, scene, options)?,
            pool: pool.transpose()?,
            parts: if several {
                PARTS_PER_THREAD * settings.threads
            } else {
                1
            },
        })
    }

    /// Places all characters and evaluates the frame at time 0.
    pub(crate) fn first_frame(
        cast: &[CrowdAsset],
        scene: Arc<Scene>,
        settings: Settings,
    ) -> anyhow::Result<Self> {
        let mut stage = Self::new(cast, scene, settings)?;
        stage.on_threads(|stage| {
            stage.plan(0.0, None)?;
            stage.evaluate();
            anyhow::Ok(())
        })?;
        Ok(stage)
    }

    /// Runs `play` on one of the threads, so that the others are a step away.
    pub(crate) fn on_threads<R: Send>(&mut self, play: impl FnOnce(&mut Self) -> R + Send) -> R {
        let Some(pool) = self.pool.take() else {
            return play(self);
        };
        let result = pool.install(|| play(self));
        self.pool = Some(pool);
        result
    }

    /// Advances the scene and plans the frame, within another tolerance than before if one is given;
    /// returns the processor time of other threads too, nanoseconds.
    pub(crate) fn plan(
        &mut self,
        dt_secs: f64,
        px: Option<f32>,
    ) -> anyhow::Result<(CrowdReport, u64)> {
        if let Some(px) = px {
            self.scene.set_tolerance(px);
        }
        if self.parts == 1 {
            return Ok((self.scene.plan(dt_secs)?, 0));
        }
        let mut others_ns = 0;
        let this_thread = rayon::current_thread_index();
        let report = self.scene.plan_on(dt_secs, |sections, tick| {
            let share = sections.len().div_ceil(self.parts).max(1);
            let timed = |sections: &mut [CrowdSection]| {
                let start = thread_ns();
                sections.iter_mut().for_each(tick);
                match rayon::current_thread_index() == this_thread {
                    true => 0,
                    false => thread_ns() - start,
                }
            };
            others_ns += sections.par_chunks_mut(share).map(timed).sum::<u64>();
        })?;
        Ok((report, others_ns))
    }

    /// Writes all palettes; returns the processor time of all threads together, nanoseconds.
    pub(crate) fn evaluate(&mut self) -> u64 {
        let timed = |part: &mut FramePart<'_>| {
            let start = thread_ns();
            part.evaluate();
            thread_ns() - start
        };
        let crowds = self.scene.crowds_mut().iter_mut();
        let parts = crowds.flat_map(|crowd| crowd.parts(self.parts));
        if self.parts == 1 {
            return parts.map(|mut part| timed(&mut part)).sum();
        }
        let mut parts: Vec<FramePart<'_>> = parts.collect();
        parts.par_iter_mut().map(timed).sum()
    }
}
