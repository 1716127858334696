//! Cost and error of a scene, as [`measure_scene`](super::measure_scene) finds them.

use super::budget_use::BudgetUse;
use super::level_use::{DrawCost, LevelStatistics};
use super::lod_error::{ErrorSample, ErrorSummary};
use super::morph_use::MorphUse;
use super::role_errors::RoleError;
use super::spread::Spread;
use serde::Serialize;

/// Refresh rate at which scenes are measured, hertz.
pub const DISPLAY_HZ: f64 = 60.0;

/// Cost and error of a scene over the frames that count. The names of the fields are stable, since
/// scripts read them as JSON (`docs/commands.md`).
#[derive(Debug, Clone, Serialize)]
pub struct SceneMeasurement {
    /// Number of characters.
    pub characters: usize,
    /// Visible characters; the median over frames, as are the next three fields.
    pub visible: usize,
    /// Characters that are evaluated because they may soon be visible.
    pub in_cull_margin: usize,
    /// Characters that no view can see.
    pub hidden: usize,
    /// Characters that are wholly hidden by others or by walls.
    pub occluded: usize,
    /// Number of frames.
    pub frames: usize,
    /// Frames per second.
    pub display_hz: f64,
    /// Number of threads.
    pub threads: usize,
    /// Processor time of a frame divided by all characters, nanoseconds.
    pub ns_per_character: Spread,
    /// All characters divided by the median processor time of a frame in milliseconds.
    pub characters_per_ms: f64,
    /// Processor time of a frame, all threads together, milliseconds.
    pub frame_ms: Spread,
    /// Wall-clock time of a frame, milliseconds.
    pub wall_ms: Spread,
    /// Processor time of a frame before evaluation, milliseconds.
    pub tick_ms: Spread,
    /// What is written in a frame, megabytes.
    pub written_mb: Spread,
    /// Memory in use.
    pub working_set: CrowdMemory,
    /// Sources of poses.
    pub poses: PoseUse,
    /// Morph targets in use.
    pub morphs: MorphUse,
    /// True errors of the sampled characters.
    pub error_px: ErrorSummary,
    /// Errors by role, if any character has one.
    pub roles: Vec<RoleError>,
    /// Maximum error in pixels by which levels and sources of poses were chosen; `None` in full detail,
    /// in which nothing is chosen.
    pub error_bound_px: Option<f32>,
    /// Time budget of a frame, milliseconds.
    pub budget_ms: Option<f32>,
    /// Time beyond the budget as a fraction of it, 95th percentile over frames.
    pub overrun_p95: Option<f64>,
    /// Result of the budget.
    pub budget: Option<BudgetUse>,
    /// Levels in use, of each character of the scene.
    #[serde(skip)]
    pub levels: Vec<Vec<LevelStatistics>>,
    /// Rendering cost of all levels together.
    pub renderer: DrawCost,
    /// Hash over every bit of every palette.
    pub palette_hash: String,
    /// Time of the scene in seconds and processor time in milliseconds, of each frame.
    #[serde(skip)]
    pub over_time: Vec<(f64, f64)>,
    /// Errors at the sampled frames.
    #[serde(skip)]
    pub samples: Vec<ErrorSample>,
}

/// The cost and the error of a whole frame, in the few numbers that say whether it is good.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FrameSummary {
    /// Processor time of a frame, median, milliseconds.
    pub ms: f64,
    /// Number of triangles drawn, mean.
    pub triangles: f64,
    /// Number of instanced draws, mean: one for each level, source and material.
    pub draws: f64,
    /// Bytes written in a frame, median.
    pub bytes: f64,
    /// 95th percentile over the sampled characters and frames of the error of joints, mesh and cached poses
    /// together, in pixels.
    pub error_p95_px: f64,
    /// Maximum of the same over characters nearer than 20 m.
    pub error_near_px: f64,
    /// Maximum error of a vertex, in pixels.
    pub worst_vertex_px: f64,
}

impl SceneMeasurement {
    /// Returns the few numbers that say whether the frame is good.
    pub fn frame(&self) -> FrameSummary {
        FrameSummary {
            ms: self.frame_ms.median,
            triangles: self.renderer.triangles,
            draws: self.renderer.draw_groups,
            bytes: 1e6 * self.written_mb.median,
            error_p95_px: self.error_px.p95,
            error_near_px: self.error_px.near_max,
            worst_vertex_px: self.error_px.worst_vertex,
        }
    }
}

/// Poses evaluated in a frame, on average.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct PoseUse {
    /// Evaluated.
    pub own: f64,
    /// Evaluated poses that blend two clips.
    pub blended: f64,
    /// Poses blended from the pose cache, by the CPU or by the GPU.
    pub cached: f64,
    /// Shown from the cache as they are.
    pub stepped: f64,
}

/// Memory of a crowd.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct CrowdMemory {
    /// Bytes of the clips.
    pub clips_bytes: usize,
    /// Bytes of the pose cache.
    pub cache_bytes: usize,
    /// Bytes of palettes, records and morph target weights of the largest frame.
    pub output_bytes: usize,
    /// Bytes of the state of all characters.
    pub state_bytes: usize,
    /// Bytes of the state of one.
    pub state_bytes_per_character: usize,
}
