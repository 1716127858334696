//! Options of [`measure_scene`](super::measure_scene), and the clocks of its caller.

use super::scene_player::SceneOptions;
use std::fmt;

/// Options for measuring a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasureOptions {
    /// How the scene is played.
    pub scene: SceneOptions,
    /// Number of threads on which the executor runs jobs; with 1 the executor runs none.
    pub threads: usize,
    /// Number of frames that count, at [`DISPLAY_HZ`](super::DISPLAY_HZ).
    pub frames: usize,
    /// Seed of the vertices and characters on which errors are measured.
    pub seed: u64,
}

/// Clocks by which frames are timed, in nanoseconds from any origin.
#[derive(Clone, Copy)]
pub struct FrameClocks<'a> {
    /// Processor time of the calling thread.
    pub thread_ns: &'a (dyn Fn() -> u64 + Sync),
    /// Wall-clock time.
    pub wall_ns: &'a (dyn Fn() -> u64 + Sync),
}

impl fmt::Debug for FrameClocks<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FrameClocks").finish_non_exhaustive()
    }
}
