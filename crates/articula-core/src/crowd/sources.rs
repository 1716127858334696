//! Sources of a character's pose: one row for each, with its error, its cost and what a renderer reads.
//!
//! Source: `docs/methods/runtime.md` 4.1. Nanoseconds are those of the machine of part 1 there. A new
//! source is a [`Source`] with its arms in this file and, if a renderer reads something new of it, a
//! [`DrawKind`] with an implementation of [`CachedDraw`](super::CachedDraw).

use super::frame::CacheUse;
use super::parts::CrowdParts;
use super::workload::Workload;

/// Nanoseconds of a blend of cached palettes, for each matrix: about 0.4 of what evaluating a joint takes.
const BLENDED_MATRIX_NS: f32 = 1.1;
/// The same of a blended palette for the look-up, and of a record for the GPU.
const BLENDED_NS: f32 = 2.0;
const RECORD_NS: f32 = 4.0;
/// The same of a draw with a palette that is cached.
const STEP_NS: f32 = 3.5;
/// The same of a draw of an impostor, which looks up a pose.
const IMPOSTOR_NS: f32 = 3.5;

/// Kinds of work, each with a price of its own: poses that are evaluated, blended from the cache, and drawn as
/// they are cached, and weights of morph targets.
pub(crate) const KINDS: usize = 4;
/// The kind of the weights of morph targets.
pub(crate) const FACES: usize = 3;

/// Source of a character's pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Source {
    /// One clip is evaluated.
    Clip,
    /// Two clips are evaluated and blended.
    Blend,
    /// Two cached palettes are blended.
    Cached,
    /// The GPU blends two cached palettes.
    Record,
    /// The cached palette nearest in time.
    Step,
    /// An impostor.
    Impostor,
}

/// What a renderer reads of a character that is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DrawKind {
    /// A palette of this frame: [`Draw`](super::Draw).
    Palette,
    /// Two palettes of the model's cache, which the GPU blends:
    /// [`BlendRecord`](crate::BlendRecord).
    Record,
    /// The palette of the model's cache that is nearest in time:
    /// [`Draw`](super::Draw).
    Step,
    /// An impostor, which has one size and no levels:
    /// [`ImpostorDraw`](super::ImpostorDraw).
    Impostor,
}

impl DrawKind {
    /// All kinds, in their order.
    pub const ALL: [Self; 4] = [Self::Palette, Self::Record, Self::Step, Self::Impostor];
}

impl Source {
    /// All sources, in the order in which the characters of a level are drawn.
    pub(super) const ALL: [Self; 6] = [
        Self::Clip,
        Self::Blend,
        Self::Cached,
        Self::Record,
        Self::Step,
        Self::Impostor,
    ];

    /// Sources of a pose within one clip, at any level.
    pub(super) fn of_levels(cache_use: CacheUse) -> &'static [Self] {
        match cache_use {
            CacheUse::Never => &[Self::Clip],
            CacheUse::Cpu => &[Self::Clip, Self::Cached, Self::Step],
            // A record costs no more than a step, and its error is less.
            CacheUse::Gpu => &[Self::Clip, Self::Record],
        }
    }

    /// What a renderer reads.
    pub(super) fn draws(self) -> DrawKind {
        match self {
            Self::Clip | Self::Blend | Self::Cached => DrawKind::Palette,
            Self::Record => DrawKind::Record,
            Self::Step => DrawKind::Step,
            Self::Impostor => DrawKind::Impostor,
        }
    }

    /// Kind of work that it is.
    #[inline]
    pub(super) fn kind(self) -> usize {
        match self {
            Self::Clip | Self::Blend => 0,
            Self::Cached => 1,
            Self::Record | Self::Step | Self::Impostor => 2,
        }
    }

    /// Error in metres that the source adds to that of the level; `None` where the model lacks it.
    pub(super) fn added_metres(self, parts: &CrowdParts, clip: usize, level: usize) -> Option<f32> {
        match self {
            Self::Clip | Self::Blend | Self::Impostor => Some(0.0),
            Self::Cached => parts.cache.as_ref()?.error_metres(clip, level),
            Self::Record => parts.cache.as_ref()?.record_error_metres(clip, level),
            Self::Step => parts.cache.as_ref()?.step_error_metres(clip, level),
        }
    }

    /// Expected nanoseconds of a pose of a level.
    pub(super) fn cost_ns(self, parts: &CrowdParts, level: usize) -> f32 {
        match self {
            Self::Clip => evaluated(parts, level, 1).cost_ns() as f32,
            Self::Blend => 2.0 * Self::Clip.cost_ns(parts, level),
            Self::Cached => BLENDED_NS + BLENDED_MATRIX_NS * parts.palette.len(level) as f32,
            Self::Record => RECORD_NS,
            Self::Step => STEP_NS,
            Self::Impostor => IMPOSTOR_NS,
        }
    }
}

/// Workload of evaluating `poses` poses of a level.
pub(super) fn evaluated(parts: &CrowdParts, level: usize, poses: u64) -> Workload {
    let kept = parts.clips.joint_lods().joint_count(level);
    let is_kept = |place: &u16| usize::from(*place) < kept;
    Workload {
        characters: poses,
        sampled_joints: poses * parts.clips.rotations().partition_point(is_kept) as u64,
        fk_joints: poses * kept as u64,
        matrices: poses * parts.palette.len(level) as u64,
    }
}
