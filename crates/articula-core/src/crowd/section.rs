//! A section of a crowd: neighbouring characters that are ticked together, by one thread.
//!
//! All that a tick reads and writes of a character lies in its section, so sections are independent,
//! and one stays in the cache of a processor from the clocks to the sorted keys.

use super::character_state::{CharacterState, ClipState};
use super::clip_times::ClipTimes;
use super::clocks::Clocks;
use super::demand::{Demand, Tolerances};
use super::frame::{CrowdEvent, Frame};
use super::keys::SectionKeys;
use super::mode::{Choosing, Mode};
use super::model::CrowdModel;
use super::morph_levels::MorphLevels;
use super::options::morphs_ns;
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
    /// Tolerance, or 1 pixel, and whose turn it is to take it over.
    pub(super) allowance: Allowance,
    pub(super) turn: Turn,
    pub(super) dt_secs: f32,
    /// Seconds since the first frame.
    pub(super) now_secs: f64,
    /// Whether mode, the lists of options and views are those of the frame before.
    pub(super) same_mode: bool,
    pub(super) same_options: bool,
    pub(super) same_views: bool,
}

/// Cells of a crowd that follow each other, in a circle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turn {
    pub(super) first: usize,
    pub(super) count: usize,
    /// Number of all cells.
    pub(super) cells: usize,
}

impl Turn {
    fn has(self, cell: usize) -> bool {
        (cell + self.cells - self.first) % self.cells < self.count
    }
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
    /// Root motion of those who were advanced one by one in the last step and moved, by rising character; that of
    /// the others follows from their times.
    roots: Vec<(u32, RootDelta)>,
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
        let first_state = ClipState::new(&model.parts().clips, 0);
        let clocks = Clocks::new(len, first_state, model.has_paths());
        let tiles = clocks.tiles();
        Self {
            first,
            bounds: vec![Sphere::default(); len],
            world: WorldBounds::new(len),
            renew: vec![u8::MAX; tiles],
            roots: Vec::with_capacity(if model.has_paths() { len } else { 0 }),
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
        if let Ok(at) = self.known_root(character) {
            self.roots.remove(at);
        }
        self.forget(character);
    }

    fn known_root(&self, character: usize) -> Result<usize, usize> {
        let of = |(c, _): &(u32, RootDelta)| *c;
        self.roots.binary_search_by_key(&(character as u32), of)
    }

    /// Root motion of a character in the last tick.
    pub(super) fn root_delta(&self, model: &CrowdModel, character: usize) -> RootDelta {
        if let Ok(at) = self.known_root(character) {
            return self.roots[at].1;
        }
        let from = self.clocks.from(character);
        let path = model
            .clip_path(from.clip())
            .filter(|_| !self.clocks.is_fading(character));
        let way = path.zip(self.clocks.secs_before(character));
        way.map_or(RootDelta::default(), |(path, before)| {
            path.step(before, from.secs, 0)
        })
    }

    /// Advances the clocks, looks through the views and chooses levels.
    pub(super) fn tick(&mut self, step: &Step<'_>, tell: &mut dyn FnMut(CrowdEvent)) {
        let frame = step.frame.part(self.first..self.first + self.len());
        self.advance(step, tell);
        self.renew_bounds(step);
        self.world.update(&frame, &self.bounds);
        self.weigh(&frame);
        self.change_mode(step);
        self.take_over(step);
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
        self.roots.clear();
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
        self.clocks.settle(step.model, character, &state);
        if way != RootDelta::default() {
            self.roots.push((character as u32, way));
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

    /// Has all levels chosen again where they are chosen in another way than in the frame before.
    fn change_mode(&mut self, step: &Step<'_>) {
        self.mode = step.mode;
        if step.same_mode {
            return;
        }
        self.keep_least.fill(Tile([ANEW[0]; LANES]));
        self.keep_most.fill(Tile([ANEW[1]; LANES]));
        if !step.same_options {
            self.options.fill(NO_OPTION);
        }
        self.world.cells.iter_mut().for_each(|c| c.is_fresh = true);
    }

    /// Gives the cells whose turn it is what the frame allows.
    fn take_over(&mut self, step: &Step<'_>) {
        let allowed = Allowance {
            frames: 1,
            ..step.allowance
        };
        for c in 0..self.world.cells.len() {
            let cell = &mut self.world.cells[c];
            let before = cell.allowance;
            // Nearly always nothing is new.
            if before == Some(allowed) || before.is_some() && !step.turn.has(self.first / CELL + c)
            {
                continue;
            }
            cell.allowance = Some(allowed);
            cell.has_new_allowance = true;
            if before.is_none_or(|b| b.by_processor == allowed.by_processor) {
                continue;
            }
            // Options of another list.
            cell.is_fresh = true;
            let tiles = c * CELL_TILES..((c + 1) * CELL_TILES).min(self.keep_least.len());
            self.keep_least[tiles.clone()].fill(Tile([ANEW[0]; LANES]));
            self.keep_most[tiles].fill(Tile([ANEW[1]; LANES]));
            let characters = c * CELL..((c + 1) * CELL).min(self.options.len());
            self.options[characters].fill(NO_OPTION);
        }
    }

    /// Finds what the views see of the characters of the cells in which that may have changed.
    fn look(&mut self, step: &Step<'_>, frame: &Frame<'_>) {
        self.tiles.clear();
        let tiles = self.clocks.tiles();
        let mut allowance = Allowance::of(1.0);
        for c in 0..self.world.cells.len() {
            if self.skips(step, c) {
                continue;
            }
            let cell = &mut self.world.cells[c];
            cell.is_fresh = true;
            // Those that are allowed the same are looked at together.
            let own = cell.allowance();
            if own != allowance && !self.tiles.is_empty() {
                self.look_at_tiles(step, frame, allowance);
            }
            allowance = own;
            let of_cell = c * CELL_TILES..((c + 1) * CELL_TILES).min(tiles);
            self.tiles.extend(of_cell.map(|tile| tile as u32));
        }
        self.look_at_tiles(step, frame, allowance);
    }

    /// Whether nothing can have changed in a cell.
    fn skips(&mut self, step: &Step<'_>, c: usize) -> bool {
        let mode = step.mode;
        let members = (self.len() - c * CELL).min(CELL);
        let cell = &mut self.world.cells[c];
        let has_new_allowance = std::mem::replace(&mut cell.has_new_allowance, false);
        if !mode.skips || cell.is_fresh {
            return false;
        }
        if step.same_views && (!has_new_allowance || cell.visible == 0) {
            return true;
        }
        if !mode.is_culled {
            return false;
        }
        let ([least, most], allowance) = (cell.keeps, cell.allowance());
        let skips = match look_at_box(step.views, cell.least, cell.greatest) {
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
        }
        skips
    }

    /// Looks at the tiles that are noted.
    fn look_at_tiles(&mut self, step: &Step<'_>, frame: &Frame<'_>, allowance: Allowance) {
        if step.mode.is_culled {
            let bands = Bands {
                allowance,
                least: &self.keep_least,
                most: &self.keep_most,
            };
            let spheres = self.world.spheres(self.first / LANES);
            let bodies = (spheres, frame.cull_margin_metres);
            let backend = step.model.parts().backend;
            look(
                backend,
                step.views,
                bodies,
                bands,
                &self.tiles,
                &mut self.sight,
            );
        } else {
            self.sight.see_all(&self.tiles, self.clocks.len());
        }
        self.tiles.clear();
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

    /// Adds the cost of the characters of a tile that are shown by tolerance, with their options by the cost of the
    /// frame, list 0, or by that of the processor, and returns how many these are. The greatest tolerance is that of
    /// near ones.
    pub(super) fn add_demand(
        &self,
        model: &CrowdModel,
        (tile, list): (usize, usize),
        tolerances: Tolerances,
        sum: &mut Demand,
    ) -> usize {
        let most = Allowance {
            px: f32::INFINITY,
            near_px: tolerances.most_px(),
            by_processor: false,
            frames: 1,
        };
        let options = model.options(self.mode.cache, list == 1);
        for lane in lanes(self.shown[tile]) {
            let character = tile * LANES + lane;
            let density = self.pixels_per_metre(character);
            let tolerances = tolerances.up_to(most.px_at(1.0 / density));
            let pixels_per_metre = density / self.weights.of(character);
            if self.clocks.is_fading(character) {
                let state = self.clocks.state(character);
                sum.see_fading(model, &state, pixels_per_metre, tolerances);
            } else {
                let clip = self.clocks.from(character).clip();
                sum.see(options.of(clip), pixels_per_metre, tolerances);
            }
        }
        self.shown[tile].count_ones() as usize
    }

    /// Nominal nanoseconds of the morph target weights of a character that has a set of them.
    pub(super) fn morphs_ns(&self, model: &CrowdModel, character: usize) -> f32 {
        let level = self.keys.get(character).level().unwrap_or(0);
        let ns = morphs_ns(model.parts(), level, self.morphs.get(character));
        match self.clocks.is_fading(character) {
            true => 2.0 * ns,
            false => ns,
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
