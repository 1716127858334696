//! A section of a crowd: neighbouring characters that are ticked together, by one thread.
//!
//! All that a tick reads and writes of a character lies in its section, so sections are independent,
//! and one stays in the cache of a processor from the clocks to the sorted keys.

use super::character_state::{CharacterState, ClipState};
use super::clocks::Clocks;
use super::demand::Demand;
use super::frame::{CrowdEvent, Frame};
use super::keys::{Key, SectionKeys};
use super::mode::{Choosing, Mode};
use super::model::CrowdModel;
use super::morph_levels::MorphLevels;
use super::places::{ANEW, CELL, CELL_TILES, WorldBounds};
use super::root_path::RootDelta;
use super::weights::Weights;
use crate::allowance::Allowance;
use crate::simd::{LANES, Tile};
use crate::sphere::Sphere;
use crate::visibility::{Bands, BoxSight, Sight, View, look, look_at_box};

/// Cells of a section.
pub(super) const SECTION_CELLS: usize = 16;
/// Characters of a section.
pub(super) const SECTION: usize = SECTION_CELLS * CELL;

/// Seconds for which a bound is valid before it is looked up again.
const BOUND_SECS: f32 = 1.0;

/// No option: the character was not shown, or plays another clip.
pub(super) const NO_OPTION: u8 = u8::MAX;

/// What all sections are told of a frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step<'a> {
    pub(super) model: &'a CrowdModel,
    /// The frame of the whole crowd.
    pub(super) frame: &'a Frame<'a>,
    pub(super) views: &'a [View<'a>],
    pub(super) mode: Mode,
    /// Tolerance, or 1 pixel.
    pub(super) allowance: Allowance,
    pub(super) dt_secs: f32,
    /// Seconds since the first frame.
    pub(super) now_secs: f64,
    /// Whether mode, the lists of options, views and tolerance are those of the frame before.
    pub(super) same_mode: bool,
    pub(super) same_options: bool,
    pub(super) same_views: bool,
    pub(super) same_allowance: bool,
}

/// Sums over the characters of a section.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Seen {
    pub(super) visible: usize,
    pub(super) in_margin: usize,
    pub(super) bound_px: f32,
}

/// A part of a [`Crowd`](super::Crowd) that is ticked alone; see
/// [`Crowd::tick_on`](super::Crowd::tick_on). Characters are counted from its first one on.
#[derive(Debug, Clone)]
pub struct CrowdSection {
    /// Index of its first character in the crowd.
    pub(super) first: usize,
    pub(super) clocks: Clocks,
    /// Model-space bound of each character.
    bounds: Vec<Sphere>,
    pub(super) world: WorldBounds,
    /// Characters whose model-space bound has to be looked up, one bit each.
    renew: Vec<u8>,
    pub(super) roots: Vec<RootDelta>,
    /// Level and source of each character, its index among the options of its clip, and the range
    /// of tolerances in metres in which it keeps them.
    pub(super) keys: SectionKeys,
    pub(super) options: Vec<u8>,
    pub(super) morphs: MorphLevels,
    keep_least: Vec<Tile>,
    keep_most: Vec<Tile>,
    pub(super) sight: Sight,
    /// Importance and scale of the last frame.
    pub(super) weights: Weights,
    /// Characters that are shown, one bit each.
    shown: Vec<u8>,
    /// Mode of the last tick.
    pub(super) mode: Mode,
    /// Whether a key has changed in the last tick.
    pub(super) is_sorted_anew: bool,
    pub(super) seen: Seen,
    /// Tiles to look at in this frame.
    tiles: Vec<u32>,
    /// Whether the tick of this frame is done, and its events, if they are kept.
    pub(super) is_ticked: bool,
    pub(super) events: Vec<CrowdEvent>,
}

impl CrowdSection {
    /// Characters `first` to `first + len` of a crowd, all playing the first clip from its beginning.
    pub(super) fn new(model: &CrowdModel, first: usize, len: usize) -> Self {
        let clocks = Clocks::new(len, ClipState::new(&model.parts().clips, 0));
        let tiles = clocks.tiles();
        Self {
            first,
            bounds: vec![Sphere::default(); len],
            world: WorldBounds::new(len),
            renew: vec![u8::MAX; tiles],
            roots: vec![RootDelta::default(); if model.has_paths() { len } else { 0 }],
            keys: SectionKeys::new(first, len, model.levels(), model.morphs().0),
            options: vec![NO_OPTION; len],
            morphs: MorphLevels::new(model, len),
            keep_least: vec![Tile([ANEW[0]; LANES]); tiles],
            keep_most: vec![Tile([ANEW[1]; LANES]); tiles],
            sight: Sight::new(tiles),
            weights: Weights::default(),
            shown: vec![0; tiles],
            mode: Mode::NONE,
            is_sorted_anew: false,
            seen: Seen::default(),
            tiles: Vec::with_capacity(tiles),
            is_ticked: false,
            events: Vec::new(),
            clocks,
        }
    }

    /// Number of characters.
    pub(super) fn len(&self) -> usize {
        self.clocks.len()
    }

    /// Replaces the playback state of a character.
    pub(super) fn play(&mut self, character: usize, state: &CharacterState) {
        self.clocks.set(character, state);
        self.renew[character / LANES] |= 1 << (character % LANES);
        if let Some(root) = self.roots.get_mut(character) {
            *root = RootDelta::default();
        }
        self.forget(character);
    }

    /// Advances the clocks, looks through the views and chooses levels.
    pub(super) fn tick(&mut self, step: &Step<'_>, tell: &mut dyn FnMut(CrowdEvent)) {
        let frame = step.frame.part(self.first..self.first + self.len());
        self.advance(step, tell);
        self.renew_bounds(step);
        self.world.update(&frame, &self.bounds);
        self.weigh(&frame);
        self.look(step, &frame);
        self.choose(step, &frame, tell);
        self.is_ticked = true;
    }

    /// The same, with the events kept.
    pub(super) fn tick_and_keep_events(&mut self, step: &Step<'_>) {
        let mut events = std::mem::take(&mut self.events);
        self.tick(step, &mut |event| events.push(event));
        self.events = events;
    }

    /// Advances clocks and root motion, and reports events.
    fn advance(&mut self, step: &Step<'_>, tell: &mut dyn FnMut(CrowdEvent)) {
        self.clocks
            .advance(step.model.parts().backend, step.dt_secs);
        for tile in 0..self.clocks.tiles() {
            for lane in lanes(self.clocks.slow()[tile]) {
                self.advance_one(step, tile * LANES + lane, tell);
            }
        }
    }

    /// Advances one character, reports its events and stores its root motion.
    fn advance_one(&mut self, step: &Step<'_>, character: usize, tell: &mut dyn FnMut(CrowdEvent)) {
        let before = self.clocks.state(character);
        let mut state = before;
        let first = self.first;
        let (way, _) = state.advance(step.model, step.dt_secs, &mut |clip, event, weight| {
            tell(CrowdEvent::Clip {
                character: first + character,
                clip,
                id: event.id,
                weight,
            });
        });
        if way == RootDelta::default() {
            self.clocks.settle(step.model, character, &state);
        } else {
            // Also where no clip has root motion any more: the next step is zero, and is stored.
            self.clocks.set(character, &state);
        }
        if let Some(root) = self.roots.get_mut(character) {
            *root = way;
        }
        let fades = |state: &CharacterState| (state.is_fading(), state.fade != 0.0);
        if fades(&before) != fades(&state) {
            self.forget(character);
        }
    }

    /// Has the level of a character chosen again.
    fn forget(&mut self, character: usize) {
        self.options[character] = NO_OPTION;
        self.set_keep(character, ANEW);
        self.world.cells[character / CELL].is_fresh = true;
    }

    /// Has the levels of characters chosen again whose importance or scale has changed.
    fn weigh(&mut self, frame: &Frame<'_>) {
        let mut weights = std::mem::take(&mut self.weights);
        weights.update(frame, self.len(), |character| {
            self.set_keep(character, ANEW);
            self.world.cells[character / CELL].is_fresh = true;
        });
        self.weights = weights;
    }

    /// Sets the range of tolerances, in metres of the unscaled character without importance, in which a
    /// character keeps its level.
    #[inline]
    pub(super) fn set_keep(&mut self, character: usize, range: [f32; 2]) {
        let weight = self.weights.of(character);
        let [least, most] = match weight == 1.0 {
            true => range,
            false => range.map(|metres| metres / weight),
        };
        let (tile, lane) = (character / LANES, character % LANES);
        self.keep_least[tile].0[lane] = least;
        self.keep_most[tile].0[lane] = most;
    }

    /// Looks up the model-space bounds that are no longer valid.
    fn renew_bounds(&mut self, step: &Step<'_>) {
        let count = self.len();
        for cell in 0..self.world.cells.len() {
            let tiles = cell * CELL_TILES..((cell + 1) * CELL_TILES).min(self.renew.len());
            let due_secs = self.world.cells[cell].due_secs;
            let is_due = due_secs < step.now_secs;
            if !is_due && !self.world.cells[cell].is_fresh {
                continue;
            }
            let mut holds = f32::INFINITY;
            for tile in tiles {
                let renew = std::mem::take(&mut self.renew[tile]);
                for lane in lanes(if is_due { u8::MAX } else { renew }) {
                    let character = tile * LANES + lane;
                    if character == count {
                        break;
                    }
                    let (bound, secs) = bound_of(step.model, &self.clocks.state(character));
                    holds = holds.min(secs);
                    if self.bounds[character] != bound {
                        self.bounds[character] = bound;
                        self.world.touch(character);
                    }
                }
            }
            let mut due = step.now_secs + f64::from(holds);
            if due_secs == f64::NEG_INFINITY {
                // The first bounds are spread, so that they do not all expire in one frame.
                let at = self.first / CELL + cell;
                due = step.now_secs + f64::from(holds) * ((at % 32 + 1) as f64 / 32.0);
            } else if !is_due {
                due = due.min(due_secs);
            }
            self.world.cells[cell].due_secs = due;
        }
    }

    /// Finds what the views see of the characters of the cells in which that may have changed.
    fn look(&mut self, step: &Step<'_>, frame: &Frame<'_>) {
        let Step {
            mode,
            views,
            allowance,
            ..
        } = *step;
        self.mode = mode;
        if !step.same_mode {
            self.keep_least.fill(Tile([ANEW[0]; LANES]));
            self.keep_most.fill(Tile([ANEW[1]; LANES]));
            if !step.same_options {
                self.options.fill(NO_OPTION);
            }
            self.world.cells.iter_mut().for_each(|c| c.is_fresh = true);
        }
        self.tiles.clear();
        let count = self.len();
        let tiles = self.clocks.tiles();
        for (c, cell) in self.world.cells.iter_mut().enumerate() {
            let may_skip = mode.skips && !cell.is_fresh;
            if may_skip && step.same_views && (step.same_allowance || cell.visible == 0) {
                continue;
            }
            if may_skip && mode.is_culled {
                let [least, most] = cell.keeps;
                let members = (count - c * CELL).min(CELL);
                let skips = match look_at_box(views, cell.least, cell.greatest) {
                    BoxSight::Nothing => cell.visible == 0 && cell.in_margin == 0,
                    BoxSight::All([low, high]) => {
                        usize::from(cell.visible) == members
                            && least <= allowance.metres(low)
                            && allowance.metres(high) < most
                    }
                    BoxSight::Some => false,
                };
                if skips {
                    cell.is_stale = true;
                    if cell.visible > 0 {
                        // Whoever keeps a level is within the tolerance.
                        cell.bound_px = allowance.px * self.weights.most_multiplier();
                    }
                    continue;
                }
            }
            cell.is_fresh = true;
            let of_cell = c * CELL_TILES..((c + 1) * CELL_TILES).min(tiles);
            self.tiles.extend(of_cell.map(|tile| tile as u32));
        }
        let bands = Bands {
            allowance,
            least: &self.keep_least,
            most: &self.keep_most,
        };
        if mode.is_culled {
            let spheres = self.world.spheres(self.first / LANES);
            let bodies = (spheres, frame.cull_margin_metres);
            let backend = step.model.parts().backend;
            look(backend, views, bodies, bands, &self.tiles, &mut self.sight);
        } else {
            self.sight.see_all(&self.tiles, count);
        }
    }

    /// Chooses levels where they may have changed, and sorts the characters by level and source.
    fn choose(&mut self, step: &Step<'_>, frame: &Frame<'_>, tell: &mut dyn FnMut(CrowdEvent)) {
        for c in 0..self.world.cells.len() {
            if !std::mem::replace(&mut self.world.cells[c].is_fresh, false) {
                continue;
            }
            let tiles = c * CELL_TILES..((c + 1) * CELL_TILES).min(self.shown.len());
            let mut bound_px = 0.0_f32;
            for tile in tiles.clone() {
                let visible = self.sight.visible[tile];
                let before = std::mem::replace(&mut self.shown[tile], visible);
                let leaves = if step.mode.keeps {
                    self.sight.leaves[tile]
                } else {
                    visible
                };
                for lane in lanes((before ^ visible) | leaves) {
                    let character = tile * LANES + lane;
                    if visible >> lane & 1 == 0 {
                        self.hide(step.model, character, tell);
                        continue;
                    }
                    let bound = self.show(step.model, frame, character, tell);
                    bound_px = bound_px.max(bound);
                }
            }
            self.settle(c, bound_px);
        }
        self.sum_up();
        self.is_sorted_anew = self.keys.sort();
    }

    fn sum_up(&mut self) {
        let mut seen = Seen::default();
        for cell in &self.world.cells {
            seen.visible += usize::from(cell.visible);
            seen.in_margin += usize::from(cell.in_margin);
            if cell.visible > 0 {
                seen.bound_px = seen.bound_px.max(cell.bound_px);
            }
        }
        self.seen = seen;
    }

    /// Sums up what is seen of a cell. `bound_px` is the greatest bound of those just chosen.
    fn settle(&mut self, c: usize, mut bound_px: f32) {
        let mode = self.mode;
        let tiles = c * CELL_TILES..((c + 1) * CELL_TILES).min(self.shown.len());
        let (mut visible, mut near) = (0, 0);
        // One of each for every lane, so that compilers use vectors.
        let mut keeps = [[0.0_f32; LANES], [f32::INFINITY; LANES]];
        let mut bounds = [bound_px; LANES];
        for tile in tiles {
            visible += self.sight.visible[tile].count_ones();
            near += self.sight.near[tile].count_ones();
            if mode.keeps && mode.choosing == Choosing::Options {
                let seen = self.sight.visible[tile];
                let (least, most) = (&self.keep_least[tile].0, &self.keep_most[tile].0);
                let metres = &self.sight.metres_per_px[tile].0;
                for lane in 0..LANES {
                    let is_seen = seen & 1 << lane != 0;
                    let or = |value: f32, other: f32| if is_seen { value } else { other };
                    keeps[0][lane] = keeps[0][lane].max(or(least[lane], 0.0));
                    keeps[1][lane] = keeps[1][lane].min(or(most[lane], f32::INFINITY));
                    // The least tolerance is the error of the option.
                    let multiplier = self.weights.multiplier(tile * LANES + lane);
                    let px = multiplier * least[lane] / metres[lane];
                    bounds[lane] = bounds[lane].max(or(px, 0.0));
                }
            }
        }
        let keeps = [
            keeps[0].into_iter().fold(0.0, f32::max),
            keeps[1].into_iter().fold(f32::INFINITY, f32::min),
        ];
        bound_px = bounds.into_iter().fold(bound_px, f32::max);
        let cell = &mut self.world.cells[c];
        cell.visible = visible as u8;
        cell.in_margin = near.saturating_sub(visible) as u8;
        cell.is_stale = false;
        cell.keeps = match mode.choosing {
            Choosing::Options => keeps,
            // Full detail has no error at any distance.
            Choosing::Fixed(0) => [f32::NEG_INFINITY, f32::INFINITY],
            _ => ANEW,
        };
        cell.bound_px = bound_px;
    }

    /// Adds the cost of the visible characters of a cell by tolerance, with their options by the cost of the
    /// frame and by that of the processor. Near ones are off by at most `near_px`.
    pub(super) fn add_demand(
        &self,
        model: &CrowdModel,
        cell: usize,
        near_px: f32,
        sums: &mut [Demand; 2],
    ) {
        if self.world.cells[cell].visible == 0 {
            return;
        }
        let most = Allowance {
            px: f32::INFINITY,
            near_px,
            by_processor: false,
        };
        let lists = [false, true].map(|by| model.options(self.mode.cache, by));
        for character in cell * CELL..((cell + 1) * CELL).min(self.len()) {
            if self.keys.get(character) == Key::HIDDEN {
                continue;
            }
            let density = self.pixels_per_metre(character);
            let most_px = most.px_at(1.0 / density);
            let pixels_per_metre = density / self.weights.of(character);
            for (sum, list) in sums.iter_mut().zip(lists) {
                if self.clocks.is_fading(character) {
                    let state = self.clocks.state(character);
                    sum.see_fading(model, &state, pixels_per_metre, most_px);
                } else {
                    let clip = self.clocks.from(character).clip();
                    sum.see(list.of(clip), pixels_per_metre, most_px);
                }
            }
        }
    }

    /// Pixels that a metre of the world spans at a visible character, the maximum over views.
    #[inline]
    pub(super) fn pixels_per_metre(&self, character: usize) -> f32 {
        if self.mode.is_culled {
            1.0 / self.sight.metres_per_px[character / LANES].0[character % LANES]
        } else {
            f32::MAX
        }
    }
}

/// The lanes of a mask, in order.
fn lanes(mut mask: u8) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (lane < LANES).then_some(lane)
    })
}

/// Model-space bound of a character, and the seconds for which it is valid.
fn bound_of(model: &CrowdModel, player: &CharacterState) -> (Sphere, f32) {
    let (from, to) = player.clips();
    if player.is_fading() {
        return (model.parts().bounds.blended(from, to), BOUND_SECS);
    }
    let bounds = &model.parts().bounds.clips[from];
    let ClipState {
        secs, speed, wrap, ..
    } = player.from;
    // A short clip has one bound as a whole, which never expires.
    if model.durations()[from] <= 2.0 * BOUND_SECS {
        return (bounds.whole().sphere, f32::INFINITY);
    }
    let bound = bounds.over(f64::from(secs), BOUND_SECS, speed, wrap);
    (bound.sphere, BOUND_SECS)
}
