//! Choice of the level and the source of one character's pose.

use super::character_state::CharacterState;
use super::frame::{CacheUse, CrowdEvent, Detail, Frame};
use super::level::{Choice, attention, cached_within};
use super::model::CrowdModel;
use super::plan::{Key, Kind};
use super::share::{ClipWay, Follower};
use super::tick::{Choosing, Crowd, NO_OPTION};
use crate::level_choice::{level_within, tolerance_range};
use crate::sample::Wrap;

impl Crowd {
    /// Stops to show a character.
    pub(super) fn hide(
        &mut self,
        model: &CrowdModel,
        character: usize,
        tell: &mut dyn FnMut(CrowdEvent),
    ) {
        self.set_level(model, character, (None, 0.0), tell);
        self.options[character] = NO_OPTION;
        self.set_key(character, Key::HIDDEN);
    }

    /// Shows a visible character at the level of all, or as the cheapest of its options within its
    /// tolerance. Returns an upper bound on its error in pixels.
    pub(super) fn show(
        &mut self,
        model: &CrowdModel,
        frame: &Frame<'_>,
        character: usize,
        tell: &mut dyn FnMut(CrowdEvent),
    ) -> f32 {
        let Some(mode) = self.mode else { return 0.0 };
        let pixels_per_metre = self.pixels_per_metre(character) * frame.scale(character);
        let kind =
            match self.clocks.is_fading(character) && self.clocks.state(character).fade != 0.0 {
                true => Kind::Blend,
                false => Kind::Clip,
            };
        let (key, level, error_metres) = match mode.choosing {
            Choosing::Fixed(level) => {
                self.set_keep(character, [f32::NEG_INFINITY, f32::INFINITY]);
                let (from, to) = self.clocks.state(character).clips();
                (
                    Key::new(level, kind),
                    level,
                    model.error_metres(from, to, level),
                )
            }
            _ => {
                let tolerance = self.tolerance_metres(model, frame, character, pixels_per_metre);
                if self.clocks.is_fading(character) {
                    self.fading_option(model, character, kind, tolerance)
                } else {
                    self.option(model, frame.cache, character, tolerance)
                }
            }
        };
        self.set_level(model, character, (Some(level), pixels_per_metre), tell);
        self.set_key(character, key);
        if error_metres > 0.0 {
            error_metres * pixels_per_metre
        } else {
            0.0
        }
    }

    /// Tolerance of a visible character in metres of the unscaled character.
    fn tolerance_metres(
        &self,
        model: &CrowdModel,
        frame: &Frame<'_>,
        character: usize,
        pixels_per_metre: f32,
    ) -> f32 {
        let Detail::Tolerance { px } = frame.detail else {
            return 0.0;
        };
        if self
            .mode
            .is_some_and(|mode| mode.is_plain && mode.is_culled)
        {
            let (tile, lane) = (
                character / crate::simd::LANES,
                character % crate::simd::LANES,
            );
            return self.sight.metres_per_px[tile].0[lane] * px;
        }
        let importance = frame.importance.get(character).copied().unwrap_or(1.0);
        px * attention(model, &self.clocks.state(character), importance) / pixels_per_metre
    }

    /// The cheapest option of the clip within a tolerance, with its level and error.
    #[inline]
    fn option(
        &mut self,
        model: &CrowdModel,
        cache_use: CacheUse,
        character: usize,
        tolerance_metres: f32,
    ) -> (Key, usize, f32) {
        let clip = self.clocks.from(character).clip();
        let options = model.options(cache_use).of(clip);
        let shown = Some(usize::from(self.options[character])).filter(|o| *o < options.len());
        // A level is kept over a change of the clip.
        let shown = shown.or_else(|| {
            let level = self.keys[character].level()?;
            options.iter().rposition(|o| usize::from(o.level) <= level)
        });
        let error = |option: usize| options[option].error_metres;
        let chosen = level_within(tolerance_metres, shown, options.len() - 1, error);
        let option = options[chosen];
        let next = options.get(chosen + 1).map(|next| next.error_metres);
        self.options[character] = chosen as u8;
        self.set_keep(character, tolerance_range(option.error_metres, next));
        let level = usize::from(option.level);
        (Key::new(level, option.kind), level, option.error_metres)
    }

    /// The coarsest level of a cross-fade within a tolerance, with its error.
    fn fading_option(
        &mut self,
        model: &CrowdModel,
        character: usize,
        kind: Kind,
        tolerance_metres: f32,
    ) -> (Key, usize, f32) {
        let (from, to) = self.clocks.state(character).clips();
        let error = |level: usize| model.error_metres(from, to, level);
        let coarsest = model.levels() - 1;
        let shown = self.level(character);
        let level = level_within(tolerance_metres, shown, coarsest, error);
        let next = (level < coarsest).then(|| error(level + 1));
        self.set_keep(character, tolerance_range(error(level), next));
        (Key::new(level, kind), level, error(level))
    }

    /// Shows a visible character at a level chosen in this frame, with a cached, a shared or its own
    /// pose. Returns an upper bound on its error in pixels.
    pub(super) fn show_anew(
        &mut self,
        model: &CrowdModel,
        frame: &Frame<'_>,
        character: usize,
        tell: &mut dyn FnMut(CrowdEvent),
    ) -> f32 {
        let choice = self.choice(model, frame, character);
        let at = (Some(choice.level), choice.pixels_per_metre);
        self.set_level(model, character, at, tell);
        let (kind, error_metres) = self.source(model, frame, character, choice);
        self.set_key(character, Key::new(choice.level, kind));
        error_metres * choice.pixels_per_metre
    }

    /// Chooses the level of a visible character.
    fn choice(&self, model: &CrowdModel, frame: &Frame<'_>, character: usize) -> Choice {
        let player = &self.clocks.state(character);
        let (from, to) = player.clips();
        let pixels_per_metre = self.pixels_per_metre(character) * frame.scale(character);
        let coarsest = model.levels() - 1;
        let shown = self.level(character);
        let mut tolerance_metres = 0.0;
        let level = match frame.detail {
            Detail::Full => 0,
            Detail::Level(level) => level.min(coarsest),
            Detail::Tolerance { px } => {
                let importance = frame.importance.get(character).copied().unwrap_or(1.0);
                tolerance_metres = px * attention(model, player, importance) / pixels_per_metre;
                let (a, b) = (model.errors_of(from), model.errors_of(to));
                let error = |level: usize| a[level].max(b[level]);
                // The cost of a shared pose is divided, so a finer level that leaves slack for
                // sharing pays.
                let part = if shares(frame, player) {
                    SHARE_LEAVES
                } else {
                    1.0
                };
                level_within(tolerance_metres * part, shown, coarsest, error)
            }
        };
        let error_metres = model.error_metres(from, to, level);
        let mut choice = Choice {
            level,
            error_metres,
            slack_metres: tolerance_metres - error_metres,
            pixels_per_metre,
            cached: false,
        };
        if frame.cache != CacheUse::Never && tolerance_metres > 0.0 && !player.is_fading() {
            let cached = cached_within(model, from, level, tolerance_metres);
            if let Some((level, error_metres)) = cached.filter(|c| pays(model, frame, choice, c.0))
            {
                choice.level = level;
                choice.error_metres = error_metres;
                choice.cached = true;
            }
        }
        choice
    }

    /// Source of a character's pose, and an upper bound on its error in metres.
    fn source(
        &mut self,
        model: &CrowdModel,
        frame: &Frame<'_>,
        character: usize,
        choice: Choice,
    ) -> (Kind, f32) {
        if choice.cached {
            let kind = match frame.cache {
                CacheUse::Gpu => Kind::Record,
                _ => Kind::Cached,
            };
            return (kind, choice.error_metres);
        }
        let player = self.clocks.state(character);
        if shares(frame, &player) && choice.slack_metres > 0.0 {
            let clip = player.from.clip();
            let errors = &model.parts().errors.clips[clip];
            let follower = Follower {
                clip,
                level: choice.level,
                secs: player.from.secs,
                slack_metres: choice.slack_metres,
            };
            let way = ClipWay {
                duration_secs: model.durations()[clip],
                speed_metres_per_sec: errors.speed_metres_per_sec,
                seam_metres: errors.seam_metres,
            };
            if let Some(leader) = self.sharing.leader(follower, way) {
                if leader == self.leader_levels.len() {
                    self.leader_levels.push(choice.level as u8);
                }
                self.leader_of[character] = leader as u32;
                return (Kind::Follow, choice.error_metres + choice.slack_metres);
            }
        }
        let kind = if player.fade != 0.0 {
            Kind::Blend
        } else {
            Kind::Clip
        };
        (kind, choice.error_metres)
    }

    /// Reports an event if the level of a character changes. A metre of it spans `pixels_per_metre`.
    #[inline]
    fn set_level(
        &mut self,
        model: &CrowdModel,
        character: usize,
        (level, pixels_per_metre): (Option<usize>, f32),
        tell: &mut dyn FnMut(CrowdEvent),
    ) {
        let from = self.level(character);
        if from == level {
            return;
        }
        let (a, b) = self.clocks.state(character).clips();
        let error = |level: usize| model.error_metres(a, b, level);
        let jump_px = match (from, level) {
            (Some(from), Some(to)) => (error(from) + error(to)) * pixels_per_metre,
            _ => 0.0,
        };
        tell(CrowdEvent::Level {
            character,
            from,
            to: level,
            jump_px,
        });
    }
}

/// Fraction of the tolerance that a level may use where poses are shared.
const SHARE_LEAVES: f32 = 0.5;

/// Whether a character may share its pose.
fn shares(frame: &Frame<'_>, player: &CharacterState) -> bool {
    frame.share && !player.is_fading() && player.from.wrap == Wrap::Loop
}

/// Blending two cached palettes costs a third or less of evaluating as many joints (measured), but
/// writes as much, so a finer level from the cache pays up to this factor in matrices.
const CACHE_PAYS: usize = 2;

/// Whether a level from the cache is cheaper than the level that would be evaluated.
fn pays(model: &CrowdModel, frame: &Frame<'_>, evaluated: Choice, cached: usize) -> bool {
    let matrices = |level| model.parts().palette.len(level);
    frame.cache == CacheUse::Gpu || matrices(cached) <= CACHE_PAYS * matrices(evaluated.level)
}
