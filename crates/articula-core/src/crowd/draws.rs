//! What a renderer reads of a character that is drawn, as it lies in its buffers.

use super::character_state::ClipState;
use super::model::CrowdModel;
use super::sources::DrawKind;
use crate::blend_record::BlendRecord;

/// One visible character and its palette.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(C)]
pub struct Draw {
    /// Index of the character.
    pub character: u32,
    /// Index of the first matrix of its palette: among all matrices written in this frame, or, of a
    /// step, among those of the cache.
    pub first_matrix: u32,
}

/// One visible character that is shown by an impostor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(C)]
pub struct ImpostorDraw {
    /// Index of the character.
    pub character: u32,
    /// Index of the pose among those of all clips.
    pub pose: u32,
}

/// What a renderer reads of a character without a palette of its own, found anew in each frame:
/// [`BlendRecord`], [`Draw`] of a step, [`ImpostorDraw`].
pub trait CachedDraw: Copy + Default {
    /// The kind of draw.
    const KIND: DrawKind;

    /// Returns what shows a character at the time of its clip, at a level.
    fn at(model: &CrowdModel, level: usize, state: ClipState, character: u32) -> Self;
}

impl CachedDraw for BlendRecord {
    const KIND: DrawKind = DrawKind::Record;

    #[inline]
    fn at(model: &CrowdModel, level: usize, state: ClipState, character: u32) -> Self {
        let cache = model.parts().cache.as_ref();
        let located = cache.and_then(|c| c.record(state.clip(), level, state.secs));
        located.unwrap_or_default().of(character)
    }
}

impl CachedDraw for Draw {
    const KIND: DrawKind = DrawKind::Step;

    #[inline]
    fn at(model: &CrowdModel, level: usize, state: ClipState, character: u32) -> Self {
        let cache = model.parts().cache.as_ref();
        let nearest = cache.and_then(|c| c.nearest(state.clip(), level, state.secs));
        Self {
            character,
            first_matrix: nearest.unwrap_or_default(),
        }
    }
}

impl CachedDraw for ImpostorDraw {
    const KIND: DrawKind = DrawKind::Impostor;

    #[inline]
    fn at(model: &CrowdModel, _: usize, state: ClipState, character: u32) -> Self {
        let impostors = model.parts().impostors.as_ref();
        let pose = impostors.and_then(|i| i.pose(state.clip(), state.secs));
        Self {
            character,
            pose: pose.unwrap_or_default(),
        }
    }
}
