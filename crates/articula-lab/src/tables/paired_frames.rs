//! Cost of having a budget: frames of one scene with and without one, in turns within one process, so that
//! a clock that changes its speed changes both.

use crate::measure::median;
use anyhow::Result;
use articula::crowd::{Budget, CrowdAsset, DISPLAY_HZ, DetailGoal, SceneOptions, ScenePlayer};
use articula_build::Scene;
use articula_report::thread_ns;
use std::slice::from_ref;
use std::sync::Arc;

/// Frames before the first one that counts, in which levels settle and costs are learned.
const WARM_UP: usize = 150;

/// A player of the scene, and its budget if it has one.
struct Playing {
    player: ScenePlayer,
    budget: Option<Budget>,
}

impl Playing {
    /// Plays a frame and returns its nanoseconds of this thread.
    fn frame(&mut self, dt_secs: f64) -> Result<f64> {
        let start = thread_ns();
        if let Some(budget) = &self.budget {
            self.player.allow(budget.allowance());
        }
        self.player.plan(dt_secs)?;
        if let Some(budget) = &mut self.budget {
            self.player.add_to(budget);
        }
        let planned = thread_ns();
        self.player.evaluate();
        let evaluated = thread_ns();
        if let Some(budget) = &mut self.budget {
            budget.observe((planned - start) as f64, (evaluated - planned) as f64);
        }
        Ok((thread_ns() - start) as f64)
    }
}

/// Median milliseconds of a frame without a budget, and with one of so many.
pub(crate) fn without_and_with(
    asset: &CrowdAsset,
    scene: &Arc<Scene>,
    options: SceneOptions,
    (budget_ms, cap_px): (f64, f32),
    frames: usize,
) -> Result<[f64; 2]> {
    let goals = [
        DetailGoal::Tolerance(cap_px),
        DetailGoal::Budget {
            ms: budget_ms as f32,
            cap_px,
        },
    ];
    let mut both = Vec::with_capacity(goals.len());
    for (g, detail) in goals.into_iter().enumerate() {
        let options = SceneOptions { detail, ..options };
        both.push(Playing {
            player: ScenePlayer::new(from_ref(asset), scene.clone(), options)?,
            budget: (g == 1).then(|| Budget::new(1e6 * budget_ms, cap_px)),
        });
    }
    let mut taken = [(); 2].map(|()| Vec::with_capacity(frames));
    for frame in 0..WARM_UP + frames {
        for turn in 0..2 {
            let who = (frame + turn) % 2;
            let ns = both[who].frame(1.0 / DISPLAY_HZ)?;
            if frame >= WARM_UP {
                taken[who].push(ns / 1e6);
            }
        }
    }
    Ok(taken.map(|mut ms| median(&mut ms)))
}
