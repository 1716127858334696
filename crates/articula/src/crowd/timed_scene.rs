//! A scene on one or several threads of the caller: the frames of the player, timed.

use super::asset::CrowdAsset;
use super::frame_parts::FramePart;
use super::measure_options::{FrameClocks, MeasureOptions};
use super::scene_player::ScenePlayer;
use crate::error::Result;
use crate::work::Executor;
use articula_build::Scene;
use articula_core::crowd::{Allowance, CrowdReport};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

/// Parts of a frame per thread: more than one, so that no thread waits long for the others.
const PARTS_PER_THREAD: usize = 8;

/// A scene, and the threads and clocks by which it is evaluated.
#[derive(Debug)]
pub(super) struct TimedScene<'a> {
    pub(super) player: ScenePlayer,
    clocks: FrameClocks<'a>,
    work: &'a Executor<'a>,
    /// Number of parts of a frame; 1 on a single thread.
    parts: usize,
}

impl<'a> TimedScene<'a> {
    /// Places all characters at time 0.
    pub(super) fn new(
        characters: &[CrowdAsset],
        scene: &Arc<Scene>,
        options: &MeasureOptions,
        clocks: FrameClocks<'a>,
        work: &'a Executor<'a>,
    ) -> Result<Self> {
        Ok(Self {
            player: ScenePlayer::new(characters, scene.clone(), options.scene)?,
            clocks,
            work,
            parts: match options.threads {
                0 | 1 => 1,
                several => PARTS_PER_THREAD.saturating_mul(several),
            },
        })
    }

    /// Processor time of this thread, nanoseconds.
    pub(super) fn thread_ns(&self) -> u64 {
        (self.clocks.thread_ns)()
    }

    /// Advances the scene and plans the frame, within what a budget allows if there is one;
    /// returns the processor time of other threads too, nanoseconds.
    pub(super) fn plan(
        &mut self,
        dt_secs: f64,
        allowed: Option<Allowance>,
    ) -> Result<(CrowdReport, u64)> {
        if let Some(allowance) = allowed {
            self.player.allow(allowance);
        }
        if self.parts == 1 {
            return Ok((self.player.plan(dt_secs)?, 0));
        }
        let (this_thread, others_ns) = (thread::current().id(), AtomicU64::new(0));
        let (thread_ns, work, parts) = (self.clocks.thread_ns, self.work, self.parts);
        let report = self.player.plan_on(dt_secs, |sections, tick| {
            let share = sections.len().div_ceil(parts).max(1);
            let others_ns = &others_ns;
            work.run(sections.chunks_mut(share).map(|sections| {
                move || {
                    let start = thread_ns();
                    sections.iter_mut().for_each(tick);
                    if thread::current().id() != this_thread {
                        others_ns.fetch_add(thread_ns() - start, Ordering::Relaxed);
                    }
                }
            }));
        })?;
        Ok((report, others_ns.into_inner()))
    }

    /// Writes all palettes; returns the processor time of all threads together, nanoseconds.
    pub(super) fn evaluate(&mut self) -> u64 {
        let (thread_ns, count) = (self.clocks.thread_ns, self.parts);
        let timed = |part: &mut FramePart<'_>| {
            let start = thread_ns();
            part.evaluate();
            thread_ns() - start
        };
        let crowds = self.player.crowds_mut().iter_mut();
        let parts = crowds.flat_map(|crowd| crowd.parts(count));
        if count == 1 {
            return parts.map(|mut part| timed(&mut part)).sum();
        }
        let (all_ns, timed) = (AtomicU64::new(0), &timed);
        let sum = &all_ns;
        self.work.run(parts.map(|mut part| {
            move || {
                sum.fetch_add(timed(&mut part), Ordering::Relaxed);
            }
        }));
        all_ns.into_inner()
    }
}
