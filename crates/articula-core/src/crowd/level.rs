//! Choice of the level of one character: the coarsest whose error is within the tolerance.

use super::character_state::CharacterState;
use super::model::CrowdModel;
use crate::attention::multiplier;

/// Level chosen for a visible character.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Choice {
    pub(crate) level: usize,
    /// Error of the level, metres of the unscaled character.
    pub(crate) error_metres: f32,
    /// Tolerance less that error, metres.
    pub(crate) slack_metres: f32,
    pub(crate) pixels_per_metre: f32,
    /// Whether the pose comes from the cache.
    pub(crate) cached: bool,
}

/// The coarsest level whose cached palettes stay within a tolerance, at most `coarsest`, and the
/// sum of the level's own error and that of the cache.
#[inline]
pub(crate) fn cached_within(
    model: &CrowdModel,
    clip: usize,
    coarsest: usize,
    tolerance_metres: f32,
) -> Option<(usize, f32)> {
    let cache = model.parts().cache.as_ref()?;
    let own = model.errors_of(clip);
    (0..=coarsest).rev().find_map(|level| {
        let error = own[level] + cache.error_metres(clip, level)?;
        (error <= tolerance_metres).then_some((level, error))
    })
}

/// Multiplier of the tolerance, from the attention factor of the clip now and the importance of the
/// character.
#[inline]
pub(crate) fn attention(model: &CrowdModel, player: &CharacterState, importance: f32) -> f32 {
    let (from, to) = player.clips();
    let at = |clip: usize, secs: f32, wrap| {
        let marked = model.attention(clip);
        marked.map_or(1.0, |a| a.at(f64::from(secs), wrap))
    };
    let mut factor = at(from, player.from.secs, player.from.wrap);
    if player.is_fading() {
        factor = factor.min(at(to, player.to.secs, player.to.wrap));
    }
    multiplier(factor, importance)
}
