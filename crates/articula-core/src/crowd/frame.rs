//! Input and output of one frame of a crowd, except palettes.

use super::character_state::MAX_STEP_SECS;
use super::workload::Workload;
use crate::allowance::Allowance;
use crate::visibility::View;
use glam::{Quat, Vec3};
use std::ops::Range;

/// Input of one frame; slices have one entry for each character.
#[derive(Debug, Clone, Copy)]
pub struct Frame<'a> {
    /// Seconds since the frame before; negative and NaN count as 0, more than 60 as 60.
    pub dt_secs: f32,
    /// Position of each root in the world, metres.
    pub positions: &'a [Vec3],
    /// World-from-model rotation of each character, unit length.
    pub rotations: &'a [Quat],
    /// Characters whose position, rotation or scale differs from that of the frame before.
    pub moved: Moved<'a>,
    /// Uniform scale of each; empty: all 1.
    pub scales: &'a [f32],
    /// Distance that each character may move until the next culling test, metres; empty: all 0.
    pub cull_margin_metres: &'a [f32],
    /// Importance of each character: 1 is neutral, 2 halves its tolerance; empty: all 1.
    pub importance: &'a [f32],
    /// Culling of the characters.
    pub culling: Culling<'a>,
    /// Choice of the level of detail.
    pub detail: Detail,
    /// Use of the model's pose cache, where it is the cheapest way within the tolerance.
    pub cache: CacheUse,
}

impl Default for Frame<'_> {
    /// No time step, no characters, no culling, an error of one pixel, and the cache where the model has
    /// one.
    fn default() -> Self {
        Self {
            dt_secs: 0.0,
            positions: &[],
            rotations: &[],
            moved: Moved::All,
            scales: &[],
            cull_margin_metres: &[],
            importance: &[],
            culling: Culling::Off,
            detail: Detail::Tolerance { px: 1.0 },
            cache: CacheUse::default(),
        }
    }
}

/// Characters that have moved since the frame before. Where few do, the others cost less.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Moved<'a> {
    /// Any of them.
    #[default]
    All,
    /// At most these, in any order. A character that is moved and not listed is culled, and its
    /// level is chosen, as if it were still where it was.
    These(&'a [u32]),
}

/// Use of a [pose cache](crate::PoseCache): none, or its palettes blended on the CPU or the GPU.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CacheUse {
    /// Nowhere: every pose is evaluated.
    Never,
    /// On the CPU, by [`Crowd::evaluate`](super::Crowd::evaluate), among the other palettes; where
    /// the nearest one is within the tolerance as it is, it is drawn from the cache
    /// ([`Crowd::evaluate_draws`](super::Crowd::evaluate_draws)): 8 bytes per character.
    #[default]
    Cpu,
    /// In the caller's vertex shader, from the records of
    /// [`Crowd::evaluate_draws`](super::Crowd::evaluate_draws): 16 bytes per character, no palette.
    Gpu,
}

/// Views against which characters are culled, or no culling.
#[derive(Debug, Clone, Copy)]
pub enum Culling<'a> {
    /// Characters whose bounds meet one of these views are visible.
    Views(&'a [View<'a>]),
    /// All characters are visible, at an unlimited number of pixels per metre, so that any
    /// tolerance gives full detail.
    Off,
}

/// Choice of the level of detail of visible characters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Detail {
    /// All joints of every visible character.
    Full,
    /// The same level for every visible character, at most the coarsest.
    Level(usize),
    /// The cheapest level and source of the pose whose error is within a tolerance. A
    /// [`Budget`](super::Budget) derives the tolerance from measured times.
    Tolerance {
        /// Tolerated error in pixels; NaN counts as 0.
        px: f32,
    },
    /// The same, as a [`Budget`](super::Budget) chooses it.
    Within(Allowance),
}

impl Detail {
    /// What is tolerated, where options are chosen by a tolerance.
    pub(crate) fn allowance(self) -> Option<Allowance> {
        match self {
            Self::Tolerance { px } => Some(Allowance::of(px)),
            Self::Within(allowance) => Some(allowance),
            Self::Full | Self::Level(_) => None,
        }
    }
}

/// Event reported by [`Crowd::tick`](super::Crowd::tick).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CrowdEvent {
    /// An event of a clip was passed.
    Clip {
        /// Index of the character.
        character: usize,
        /// Index of the clip.
        clip: usize,
        /// Identifier of the event.
        id: u32,
        /// Weight of the clip in the pose, 0 to 1.
        weight: f32,
    },
    /// A character changes its level or its morph level, appears or disappears.
    Level {
        /// Index of the character.
        character: usize,
        /// Level before; `None` if the character was not shown.
        from: Option<usize>,
        /// Level now; `None` if the character is no longer shown. The level before if only the morph
        /// level changes.
        to: Option<usize>,
        /// Upper bound on the jump of the skin in pixels; 0 if the character appears or disappears.
        jump_px: f32,
    },
}

/// Counts and error bound of one tick.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CrowdReport {
    /// Number of characters that a view sees.
    pub visible: usize,
    /// Number of characters inside the cull margin.
    pub in_margin: usize,
    /// Number of poses to evaluate for single characters.
    pub own: usize,
    /// Number of poses to evaluate that blend two clips.
    pub blended: usize,
    /// Number of poses blended from the cache.
    pub cached: usize,
    /// Number of poses shown from the cache as they are, each the nearest in time.
    pub stepped: usize,
    /// Number of characters shown by impostors.
    pub impostors: usize,
    /// Workload of the poses to evaluate.
    pub work: Workload,
    /// Upper bound on the error of the chosen levels and sources of poses, pixels.
    pub bound_px: f32,
}

impl CrowdReport {
    /// The report of this crowd and another one together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            visible: self.visible + other.visible,
            in_margin: self.in_margin + other.in_margin,
            own: self.own + other.own,
            blended: self.blended + other.blended,
            cached: self.cached + other.cached,
            stepped: self.stepped + other.stepped,
            impostors: self.impostors + other.impostors,
            work: self.work + other.work,
            bound_px: self.bound_px.max(other.bound_px),
        }
    }
}

impl<'a> Frame<'a> {
    /// The frame of some of the characters; those that moved are not listed.
    pub(crate) fn part(&self, of: Range<usize>) -> Frame<'a> {
        let numbers = |all: &'a [f32]| all.get(of.clone()).unwrap_or_default();
        Frame {
            positions: &self.positions[of.clone()],
            rotations: &self.rotations[of.clone()],
            scales: numbers(self.scales),
            cull_margin_metres: numbers(self.cull_margin_metres),
            importance: numbers(self.importance),
            moved: match self.moved {
                Moved::All => Moved::All,
                Moved::These(_) => Moved::These(&[]),
            },
            ..*self
        }
    }

    /// Absolute scale of a character.
    pub(crate) fn scale(&self, character: usize) -> f32 {
        self.scales.get(character).map_or(1.0, |s| s.abs())
    }

    /// Time step in seconds, clamped to 0 to 60.
    pub(crate) fn step_secs(&self) -> f32 {
        // NaN fails the comparison too.
        if self.dt_secs > 0.0 {
            self.dt_secs.min(MAX_STEP_SECS)
        } else {
            0.0
        }
    }
}
