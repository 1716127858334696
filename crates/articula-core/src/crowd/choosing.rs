//! Choice of the level and the source of one character's pose.

use super::character_state::CharacterState;
use super::frame::{CrowdEvent, Frame};
use super::keys::Key;
use super::mode::Choosing;
use super::model::CrowdModel;
use super::options::DetailOption;
use super::places::CELL;
use super::section::{CrowdSection, NO_OPTION};
use super::sources::Source;
use crate::attention::multiplier;
use crate::level_choice::{level_within, tolerance_range};
use crate::simd::LANES;

/// A level, a source of a pose and a morph level, and an upper bound on their error.
#[derive(Debug, Clone, Copy)]
struct Choice {
    key: Key,
    /// Morph level; 0 at levels that show no morph targets.
    morphs: u8,
    /// Metres of the unscaled character.
    error_metres: f32,
}

/// Key and morph level of a character.
type Shown = (Key, u8);

impl CrowdSection {
    /// Stops to show a character.
    pub(super) fn hide(
        &mut self,
        model: &CrowdModel,
        character: usize,
        tell: &mut dyn FnMut(CrowdEvent),
    ) {
        self.set_level(model, character, ((Key::HIDDEN, 0), 0.0), tell);
        self.options[character] = NO_OPTION;
        self.keys.set(character, Key::HIDDEN);
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
        let pixels_per_metre = self.pixels_per_metre(character) * frame.scale(character);
        let is_fading = self.clocks.is_fading(character);
        let source = match is_fading && self.clocks.state(character).fade != 0.0 {
            true => Source::Blend,
            false => Source::Clip,
        };
        let choice = if let Choosing::Fixed(level) = self.mode.choosing {
            self.set_keep(character, [f32::NEG_INFINITY, f32::INFINITY]);
            let (from, to) = self.clocks.state(character).clips();
            Choice {
                key: Key::new(level, source),
                morphs: 0,
                error_metres: model.error_metres(from, to, level),
            }
        } else {
            let tolerance = self.tolerance_metres(model, frame, character, pixels_per_metre);
            if is_fading {
                self.fading_option(model, character, source, tolerance)
            } else {
                self.option(model, character, tolerance)
            }
        };
        let shown = (choice.key, choice.morphs);
        self.set_level(model, character, (shown, pixels_per_metre), tell);
        self.keys.set(character, choice.key);
        self.morphs.set(character, choice.morphs);
        if choice.error_metres > 0.0 {
            choice.error_metres * pixels_per_metre
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
        let allowance = self.world.cells[character / CELL].allowance();
        if self.mode.keeps && self.mode.is_culled {
            let metres_per_px = self.sight.metres_per_px[character / LANES].0[character % LANES];
            return allowance.metres(metres_per_px) * self.weights.of(character);
        }
        let importance = frame.importance.get(character).copied().unwrap_or(1.0);
        let px = allowance.px_at(1.0 / self.pixels_per_metre(character));
        px * attention(model, &self.clocks.state(character), importance) / pixels_per_metre
    }

    /// The cheapest option of the clip within a tolerance.
    #[inline]
    fn option(&mut self, model: &CrowdModel, character: usize, tolerance_metres: f32) -> Choice {
        let clip = self.clocks.from(character).clip();
        let allowance = self.world.cells[character / CELL].allowance();
        let options = model.options(self.mode.cache, allowance.by_processor);
        let options = options.of(clip);
        let shown = Some(usize::from(self.options[character])).filter(|o| *o < options.len());
        // A level is kept over a change of the clip.
        let shown = shown.or_else(|| {
            let level = self.keys.get(character).level()?;
            let morphs = self.morphs.get(character);
            let is_as_fine =
                |o: &DetailOption| usize::from(o.level) <= level && usize::from(o.morphs) <= morphs;
            options.iter().rposition(is_as_fine)
        });
        let error = |option: usize| options[option].error_metres;
        let chosen = level_within(tolerance_metres, shown, options.len() - 1, error);
        let option = options[chosen];
        let next = options.get(chosen + 1).map(|next| next.error_metres);
        self.options[character] = chosen as u8;
        self.set_keep(character, tolerance_range(option.error_metres, next));
        let level = usize::from(option.level);
        let mut key = Key::new(level, option.source);
        if model.is_at_rest(level, usize::from(option.morphs)) {
            key = key.at_rest();
        }
        Choice {
            key,
            morphs: option.morphs,
            error_metres: option.error_metres,
        }
    }

    /// The coarsest level of a cross-fade within a tolerance, with all morph targets if it shows any.
    fn fading_option(
        &mut self,
        model: &CrowdModel,
        character: usize,
        source: Source,
        tolerance_metres: f32,
    ) -> Choice {
        let (from, to) = self.clocks.state(character).clips();
        let error = |level: usize| model.error_metres(from, to, level);
        let coarsest = model.levels() - 1;
        let shown = self.keys.get(character).level();
        let level = level_within(tolerance_metres, shown, coarsest, error);
        let next = (level < coarsest).then(|| error(level + 1));
        self.set_keep(character, tolerance_range(error(level), next));
        Choice {
            key: Key::new(level, source),
            morphs: 0,
            error_metres: error(level),
        }
    }

    /// Reports an event if the level of a character changes with its key, or its morph level does. A
    /// metre of it spans `pixels_per_metre`.
    #[inline]
    fn set_level(
        &mut self,
        model: &CrowdModel,
        character: usize,
        ((key, morphs), pixels_per_metre): (Shown, f32),
        tell: &mut dyn FnMut(CrowdEvent),
    ) {
        let before = (self.keys.get(character), self.morphs.get(character));
        let (from, to) = (before.0.level(), key.level());
        let morphs = usize::from(morphs);
        if from == to && (to.is_none() || before.1 == morphs) {
            return;
        }
        let (a, b) = self.clocks.state(character).clips();
        let impostors = &model.parts().impostors;
        let body = |level: usize, key: Key| match impostors {
            Some(impostors) if key.is_impostor() => impostors.error_metres(a).unwrap_or(0.0),
            _ => model.error_metres(a, b, level),
        };
        let source = |key: Key| key.added_metres(model.parts(), a);
        let face = |morphs: usize| model.morph_error_metres(a, b, morphs);
        let jump_px = match (from, to) {
            (Some(from), Some(to)) => {
                let mut metres = face(before.1) + face(morphs);
                // At the same level the bodies are the same, but for their sources.
                if from != to || before.0.is_impostor() != key.is_impostor() {
                    metres += body(from, before.0) + body(to, key);
                }
                if !before.0.has_pose_of(key) {
                    metres += source(before.0) + source(key);
                }
                metres * pixels_per_metre
            }
            _ => 0.0,
        };
        tell(CrowdEvent::Level {
            character: self.first + character,
            from,
            to,
            jump_px,
        });
    }
}

/// Multiplier of the tolerance, from the attention factor of the clip now and the importance of the
/// character.
#[inline]
fn attention(model: &CrowdModel, player: &CharacterState, importance: f32) -> f32 {
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
