//! What goes into a frame and what comes out of it, but for the palettes.

use super::character_state::MAX_STEP_SECS;
use crate::budget::{self, Workload};
use crate::visibility::View;
use glam::{Quat, Vec3};

/// What the caller says of one frame; slices have one entry for each character.
#[derive(Debug, Clone, Copy)]
pub struct Frame<'a> {
    /// Time since the frame before; negative or no number counts as 0, more than
    /// 60 s as that.
    pub dt_secs: f32,
    /// Where each root is in the world, metres.
    pub positions: &'a [Vec3],
    /// How each is turned.
    pub rotations: &'a [Quat],
    /// Uniform scale of each; empty: all 1.
    pub scales: &'a [f32],
    /// How far each may go until it is looked for again, metres; empty: nowhere.
    pub cull_margin_metres: &'a [f32],
    /// How important each is: 1 is neutral, 2 halves its tolerance; empty: all 1.
    pub importance: &'a [f32],
    /// Who can be seen.
    pub culling: Culling<'a>,
    /// How much detail each gets.
    pub detail: Detail,
    /// Whether characters whose poses agree within their tolerance may share one palette.
    pub share: bool,
    /// What may be shown from the model's pose cache, where its error is within the tolerance.
    pub cache: CacheUse,
}

/// Who blends the palettes of a [pose cache](crate::pose_cache::PoseCache).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CacheUse {
    /// Nobody: every pose is evaluated.
    #[default]
    Never,
    /// [`Crowd::evaluate`](super::Crowd::evaluate), among the other palettes.
    Cpu,
    /// The caller's vertex shader, by [`Drawn::records`](super::Drawn::records): 16 bytes a
    /// character, no palette.
    Gpu,
}

/// Who can be seen.
#[derive(Debug, Clone, Copy)]
pub enum Culling<'a> {
    /// Whoever meets one of these views.
    Views(&'a [View<'a>]),
    /// Everyone, in full detail.
    Off,
}

/// How much detail each character gets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Detail {
    /// Every joint of everyone who is seen.
    Full,
    /// The same level for everyone who is seen; beyond the coarsest, the coarsest.
    Level(usize),
    /// The coarsest level whose error stays within so many pixels. A tolerance that is no
    /// number counts as 0.
    Tolerance {
        /// Pixels.
        px: f32,
    },
    /// The least visible error that a cost allows, after [`set_budget`](super::Crowd::set_budget);
    /// everyone at the coarsest level before it.
    Budget {
        /// Cost, in the units of the cost model (nanoseconds).
        cost: f32,
    },
}

/// What game logic is told during a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CrowdEvent {
    /// A mark on a clip was passed.
    Clip {
        /// The character.
        character: usize,
        /// Its clip.
        clip: usize,
        /// The event's id.
        id: u32,
        /// Share that the clip has in the pose, 0 to 1.
        weight: f32,
    },
    /// A character is shown at another level, or no more (`None`), or again.
    Level {
        /// The character.
        character: usize,
        /// The level before.
        from: Option<usize>,
        /// The level now.
        to: Option<usize>,
        /// The most that the skin may jump by, pixels; 0 if it came into view.
        jump_px: f32,
    },
}

/// What was done in a frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CrowdReport {
    /// Characters that a view sees.
    pub visible: usize,
    /// Characters that are near to being seen.
    pub in_margin: usize,
    /// Poses to evaluate for single characters.
    pub own: usize,
    /// Poses to evaluate that several share.
    pub leaders: usize,
    /// Characters that show a shared pose.
    pub followers: usize,
    /// Poses to evaluate that blend two clips.
    pub blended: usize,
    /// Poses that are blended from the cache.
    pub cached: usize,
    /// What evaluating them is.
    pub work: Workload,
    /// Greatest error that the chosen levels and shared poses may show, pixels.
    pub bound_px: f32,
    /// What the budget made of it, if there was one.
    pub budget: Option<budget::AllocationReport>,
}

impl Frame<'_> {
    /// The step of time that counts.
    pub(crate) fn step_secs(&self) -> f32 {
        // No number fails the comparison too.
        if self.dt_secs > 0.0 {
            self.dt_secs.min(MAX_STEP_SECS)
        } else {
            0.0
        }
    }
}
