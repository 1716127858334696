//! One frame of a crowd: clocks, bounds, views, levels and the plan of the evaluation.

use super::character_state::{CharacterState, ClipState};
use super::clocks::Clocks;
use super::demand::Demand;
use super::frame::{CacheUse, CrowdEvent, CrowdReport, Culling, Detail, Frame};
use super::model::CrowdModel;
use super::options::evaluated;
use super::places::{ANEW, CELL, CELL_TILES, WorldBounds};
use super::plan::{Key, Plan, Shown};
use super::root_path::RootDelta;
use super::share::Sharing;
use crate::simd::{LANES, Tile};
use crate::sphere::Sphere;
use crate::visibility::{Bands, BoxSight, CullResult, Sight, View, Visibility};
use crate::visibility::{look, look_at_box, look_at_one};

/// Seconds for which a bound is valid before it is looked up again.
const BOUND_SECS: f32 = 1.0;

/// No option: the character was not shown, or plays another clip.
pub(super) const NO_OPTION: u8 = u8::MAX;

/// Frames in which the cost by tolerance is found anew.
const SWEEP_FRAMES: usize = 16;

/// Cost by tolerance, summed up cell by cell.
#[derive(Debug, Clone)]
struct Sweep {
    whole: Demand,
    part: Demand,
    next_cell: usize,
    is_first: bool,
}

impl Sweep {
    fn new() -> Self {
        Self {
            whole: Demand::NONE,
            part: Demand::NONE,
            next_cell: 0,
            is_first: true,
        }
    }
}

/// What a choice depends on beside clip and tolerance: while it is the same, choices are kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mode {
    pub(super) choosing: Choosing,
    pub(super) cache: CacheUse,
    /// Whether tolerances follow from pixels per metre alone.
    pub(super) is_plain: bool,
    pub(super) is_culled: bool,
}

/// How levels are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Choosing {
    /// The same level for all.
    Fixed(usize),
    /// The cheapest option within the tolerance, kept while that stays in its range.
    Options,
    /// Anew in each frame, for shared poses.
    Anew,
}

impl Mode {
    fn of(model: &CrowdModel, frame: &Frame<'_>) -> Self {
        let views = match frame.culling {
            Culling::Views(views) => views,
            Culling::Off => &[],
        };
        let alike = frame.importance.is_empty()
            && frame.scales.is_empty()
            && frame.cull_margin_metres.is_empty();
        let choosing = match frame.detail {
            Detail::Full => Choosing::Fixed(0),
            Detail::Level(level) => Choosing::Fixed(level.min(model.levels() - 1)),
            Detail::Tolerance { .. } if !frame.share => Choosing::Options,
            _ => Choosing::Anew,
        };
        let is_anew = choosing == Choosing::Anew;
        Self {
            choosing,
            cache: frame.cache,
            is_plain: alike
                && !is_anew
                && !model.has_attention()
                && !views.iter().any(View::has_occlusion),
            is_culled: matches!(frame.culling, Culling::Views(_)),
        }
    }
}

/// The characters of one rig: playback state, levels, and the plan of the current frame.
#[derive(Debug, Clone)]
pub struct Crowd {
    pub(super) clocks: Clocks,
    /// Model-space bound of each character.
    pub(super) bounds: Vec<Sphere>,
    pub(super) world: WorldBounds,
    /// Characters whose model-space bound has to be looked up, one bit each.
    renew: Vec<u8>,
    /// Seconds since the first frame.
    now_secs: f64,
    pub(super) roots: Vec<RootDelta>,
    /// Level and source of each character, its index among the options of its clip, and the range
    /// of tolerances in metres in which it keeps them.
    pub(super) keys: Vec<Key>,
    pub(super) options: Vec<u8>,
    pub(super) keep_least: Vec<Tile>,
    pub(super) keep_most: Vec<Tile>,
    pub(super) sight: Sight,
    /// Characters that are shown, one bit each.
    shown: Vec<u8>,
    /// Views, mode and tolerance of the frame before.
    views: Vec<View<'static>>,
    pub(super) mode: Option<Mode>,
    px: f32,
    // The fields below are recomputed each frame and kept so that nothing is allocated.
    /// Tiles to look at.
    tiles: Vec<u32>,
    pub(super) sharing: Sharing,
    /// Level of each shared pose, and the shared pose of each character that follows one.
    pub(super) leader_levels: Vec<u8>,
    pub(super) leader_of: Vec<u32>,
    pub(super) plan: Plan,
    /// Whether the plan has to be made again.
    is_stirred: bool,
    sweep: Sweep,
}

impl Crowd {
    /// Makes `characters` characters, all playing the first clip from its beginning.
    pub fn new(model: &CrowdModel, characters: usize) -> Self {
        let clocks = Clocks::new(characters, ClipState::new(&model.parts().clips, 0));
        let levels = model.levels();
        let tiles = clocks.tiles();
        Self {
            bounds: vec![Sphere::default(); characters],
            world: WorldBounds::new(characters),
            renew: vec![u8::MAX; tiles],
            now_secs: 0.0,
            roots: vec![RootDelta::default(); if model.has_paths() { characters } else { 0 }],
            keys: vec![Key::HIDDEN; characters],
            options: vec![NO_OPTION; characters],
            keep_least: vec![Tile([ANEW[0]; LANES]); tiles],
            keep_most: vec![Tile([ANEW[1]; LANES]); tiles],
            sight: Sight::new(tiles),
            shown: vec![0; tiles],
            views: Vec::with_capacity(8),
            mode: None,
            px: 0.0,
            tiles: Vec::with_capacity(tiles),
            sharing: Sharing::new(model.parts().clips.clips(), levels, characters),
            leader_levels: Vec::with_capacity(characters),
            leader_of: vec![0; characters],
            plan: Plan::new(characters, levels),
            is_stirred: true,
            sweep: Sweep::new(),
            clocks,
        }
    }

    /// Bytes of state per character, without budget and output. One that fades takes 24 more.
    pub const BYTES_PER_CHARACTER: usize = Clocks::BYTES
        + size_of::<Sphere>()
        + WorldBounds::BYTES
        + size_of::<Key>()
        + size_of::<u8>()
        + size_of::<[f32; 2]>();

    /// Number of characters.
    pub(crate) fn len(&self) -> usize {
        self.clocks.len()
    }

    /// Returns the playback state of a character.
    pub fn state(&self, character: usize) -> CharacterState {
        self.clocks.state(character)
    }

    /// Replaces the playback state of a character.
    pub fn play(&mut self, character: usize, player: CharacterState) {
        self.clocks.set(character, &player);
        self.renew[character / LANES] |= 1 << (character % LANES);
        if let Some(root) = self.roots.get_mut(character) {
            *root = RootDelta::default();
        }
        self.forget(character);
    }

    /// Starts a cross-fade of a character to another clip; see [`CharacterState::fade_to`].
    pub fn fade_to(&mut self, character: usize, clip_state: ClipState, secs: f32) {
        let mut state = self.clocks.state(character);
        state.fade_to(clip_state, secs);
        self.play(character, state);
    }

    /// Advances every clock, culls against the views, chooses a level for each character and plans
    /// the evaluation.
    ///
    /// O(characters), with little more than an addition for those of whom nothing changes; does not
    /// allocate, except for more views than before.
    ///
    /// # Panics
    /// If a slice of the frame does not have one entry for each character (or none, where that is
    /// allowed), or the model is not the one that the crowd was made for.
    pub fn tick(
        &mut self,
        model: &CrowdModel,
        frame: &Frame<'_>,
        tell: &mut dyn FnMut(CrowdEvent),
    ) -> CrowdReport {
        self.check(frame);
        let dt_secs = frame.step_secs();
        self.advance(model, dt_secs, tell);
        self.renew_bounds(model);
        self.world.update(frame, &self.bounds);
        self.look(model, frame);
        let mut report = CrowdReport::default();
        self.choose(model, frame, tell);
        self.report(model, &mut report);
        report
    }

    fn check(&self, frame: &Frame<'_>) {
        let count = self.len();
        for slice in [frame.scales, frame.cull_margin_metres, frame.importance] {
            assert!(
                slice.is_empty() || slice.len() == count,
                "expected one entry for each character"
            );
        }
        for places in [frame.positions.len(), frame.rotations.len()] {
            assert_eq!(
                places, count,
                "expected one position and one rotation for each character"
            );
        }
    }

    /// Advances clocks and root motion, and reports events.
    fn advance(&mut self, model: &CrowdModel, dt_secs: f32, tell: &mut dyn FnMut(CrowdEvent)) {
        self.now_secs += f64::from(dt_secs);
        self.sharing.begin(dt_secs, model.durations());
        self.clocks.advance(model.parts().backend, dt_secs);
        for tile in 0..self.clocks.tiles() {
            for lane in lanes(self.clocks.slow()[tile]) {
                self.advance_one(model, tile * LANES + lane, dt_secs, tell);
            }
        }
    }

    /// Advances one character, reports its events and stores its root motion.
    fn advance_one(
        &mut self,
        model: &CrowdModel,
        character: usize,
        dt_secs: f32,
        tell: &mut dyn FnMut(CrowdEvent),
    ) {
        let before = self.clocks.state(character);
        let mut state = before;
        let (way, _) = state.advance(model, dt_secs, &mut |clip, event, weight| {
            tell(CrowdEvent::Clip {
                character,
                clip,
                id: event.id,
                weight,
            });
        });
        self.clocks.settle(model, character, &state);
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

    #[inline]
    pub(super) fn set_keep(&mut self, character: usize, [least, most]: [f32; 2]) {
        let (tile, lane) = (character / LANES, character % LANES);
        self.keep_least[tile].0[lane] = least;
        self.keep_most[tile].0[lane] = most;
    }

    /// Looks up the model-space bounds that are no longer valid.
    fn renew_bounds(&mut self, model: &CrowdModel) {
        let count = self.len();
        for cell in 0..self.world.cells.len() {
            let tiles = cell * CELL_TILES..((cell + 1) * CELL_TILES).min(self.renew.len());
            let due_secs = self.world.cells[cell].due_secs;
            let is_due = due_secs < self.now_secs;
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
                    let (bound, secs) = bound_of(model, &self.clocks.state(character));
                    holds = holds.min(secs);
                    if self.bounds[character] != bound {
                        self.bounds[character] = bound;
                        self.world.touch(character);
                    }
                }
            }
            let mut due = self.now_secs + f64::from(holds);
            if due_secs == f64::NEG_INFINITY {
                // The first bounds are spread, so that they do not all expire in one frame.
                due = self.now_secs + f64::from(holds) * ((cell % 32 + 1) as f64 / 32.0);
            } else if !is_due {
                due = due.min(due_secs);
            }
            self.world.cells[cell].due_secs = due;
        }
    }

    /// Finds what the views see of the characters of the cells in which that may have changed.
    fn look(&mut self, model: &CrowdModel, frame: &Frame<'_>) {
        let views = match frame.culling {
            Culling::Views(views) => views,
            Culling::Off => &[],
        };
        let px = match frame.detail {
            Detail::Tolerance { px } => px,
            _ => 1.0,
        };
        let mode = Mode::of(model, frame);
        let before = self.mode.replace(mode);
        if before != Some(mode) {
            self.keep_least.fill(Tile([ANEW[0]; LANES]));
            self.keep_most.fill(Tile([ANEW[1]; LANES]));
            if before.is_none_or(|b| b.cache != mode.cache) {
                self.options.fill(NO_OPTION);
            }
            self.world.cells.iter_mut().for_each(|c| c.is_fresh = true);
        }
        let same_views = self.views.len() == views.len()
            && self
                .views
                .iter()
                .zip(views)
                .all(|(a, b)| *a == b.unoccluded());
        if !same_views {
            self.views.clear();
            self.views.extend(views.iter().map(View::unoccluded));
        }
        let same_px = px == self.px;
        self.px = px;
        self.tiles.clear();
        let count = self.len();
        let tiles = self.clocks.tiles();
        for (c, cell) in self.world.cells.iter_mut().enumerate() {
            let may_skip = mode.is_plain && !cell.is_fresh;
            if may_skip && same_views && (same_px || cell.visible == 0) {
                continue;
            }
            if may_skip && mode.is_culled {
                let [least, most] = cell.keeps;
                let members = (count - c * CELL).min(CELL);
                let skips = match look_at_box(views, cell.least, cell.greatest) {
                    BoxSight::Nothing => cell.visible == 0 && cell.in_margin == 0,
                    BoxSight::All([low, high]) => {
                        usize::from(cell.visible) == members
                            && least <= px * low
                            && px * high < most
                    }
                    BoxSight::Some => false,
                };
                if skips {
                    cell.is_stale = true;
                    if cell.visible > 0 {
                        // Whoever keeps a level is within the tolerance.
                        cell.bound_px = px;
                    }
                    continue;
                }
            }
            cell.is_fresh = true;
            let of_cell = c * CELL_TILES..((c + 1) * CELL_TILES).min(tiles);
            self.tiles.extend(of_cell.map(|tile| tile as u32));
        }
        let bands = Bands {
            px,
            least: &self.keep_least,
            most: &self.keep_most,
        };
        if mode.is_culled {
            let bodies = (self.world.spheres(), frame.cull_margin_metres);
            let backend = model.parts().backend;
            look(backend, views, bodies, bands, &self.tiles, &mut self.sight);
        } else {
            self.sight.see_all(&self.tiles, count);
        }
    }

    /// Chooses levels where they may have changed, and plans the evaluation.
    fn choose(&mut self, model: &CrowdModel, frame: &Frame<'_>, tell: &mut dyn FnMut(CrowdEvent)) {
        let Some(mode) = self.mode else { return };
        self.leader_levels.clear();
        if mode.choosing == Choosing::Anew {
            self.is_stirred = true;
        }
        for c in 0..self.world.cells.len() {
            if !std::mem::replace(&mut self.world.cells[c].is_fresh, false) {
                continue;
            }
            let tiles = c * CELL_TILES..((c + 1) * CELL_TILES).min(self.shown.len());
            let mut bound_px = 0.0_f32;
            for tile in tiles.clone() {
                let visible = self.sight.visible[tile];
                let before = std::mem::replace(&mut self.shown[tile], visible);
                let leaves = if mode.is_plain {
                    self.sight.leaves[tile]
                } else {
                    visible
                };
                for lane in lanes((before ^ visible) | leaves) {
                    let character = tile * LANES + lane;
                    if visible >> lane & 1 == 0 {
                        self.hide(model, character, tell);
                        continue;
                    }
                    let bound = match mode.choosing {
                        Choosing::Anew => self.show_anew(model, frame, character, tell),
                        _ => self.show(model, frame, character, tell),
                    };
                    bound_px = bound_px.max(bound);
                }
            }
            self.settle(c, mode, bound_px);
        }
        if std::mem::replace(&mut self.is_stirred, false) {
            let shown = Shown {
                keys: &self.keys,
                cells: &self.world.cells,
                leaders: &self.leader_levels,
                leader_of: &self.leader_of,
            };
            let morph_levels = model.morphs().0;
            self.plan.make(shown, &model.parts().palette, morph_levels);
        }
    }

    /// Sums up what is seen of a cell. `bound_px` is the greatest bound of those just chosen.
    fn settle(&mut self, c: usize, mode: Mode, mut bound_px: f32) {
        let tiles = c * CELL_TILES..((c + 1) * CELL_TILES).min(self.shown.len());
        let (mut visible, mut near, mut keeps) = (0, 0, [0.0_f32, f32::INFINITY]);
        for tile in tiles {
            visible += self.sight.visible[tile].count_ones();
            near += self.sight.near[tile].count_ones();
            if mode.is_plain && mode.choosing == Choosing::Options {
                let seen = self.sight.visible[tile];
                let (least, most) = (&self.keep_least[tile].0, &self.keep_most[tile].0);
                let metres = &self.sight.metres_per_px[tile].0;
                for lane in 0..LANES {
                    if seen >> lane & 1 == 1 {
                        keeps = [keeps[0].max(least[lane]), keeps[1].min(most[lane])];
                        // The least tolerance is the error of the option.
                        if least[lane] > 0.0 {
                            bound_px = bound_px.max(least[lane] / metres[lane]);
                        }
                    }
                }
            }
        }
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

    pub(super) fn set_key(&mut self, character: usize, key: Key) {
        if self.keys[character] != key {
            self.keys[character] = key;
            self.is_stirred = true;
        }
    }

    /// Counts poses, work and errors of the plan.
    fn report(&self, model: &CrowdModel, report: &mut CrowdReport) {
        for (level, counts) in self.plan.counts().iter().enumerate() {
            report.own += counts.own;
            report.blended += counts.blended;
            report.shared_poses += counts.leaders;
            report.sharing_characters += counts.followers;
            report.cached += counts.cached + counts.recorded;
            let poses = (counts.own + counts.leaders) as u64;
            report.work += evaluated(model.parts(), level, poses);
        }
        for cell in &self.world.cells {
            report.visible += usize::from(cell.visible);
            report.in_margin += usize::from(cell.in_margin);
            if cell.visible > 0 {
                report.bound_px = report.bound_px.max(cell.bound_px);
            }
        }
    }

    /// Cost of the visible characters by tolerance, with the options of the last tick. A sixteenth of
    /// the cells are summed up anew in each call, all of them in the first.
    pub(super) fn demand(&mut self, model: &CrowdModel) -> &Demand {
        let count = self.world.cells.len();
        let steps = if self.sweep.is_first {
            count
        } else {
            count.div_ceil(SWEEP_FRAMES)
        };
        for _ in 0..steps {
            self.add_demand(model, self.sweep.next_cell);
            self.sweep.next_cell += 1;
            if self.sweep.next_cell >= count {
                self.sweep.next_cell = 0;
                self.sweep.is_first = false;
                self.sweep.whole = std::mem::replace(&mut self.sweep.part, Demand::NONE);
                break;
            }
        }
        &self.sweep.whole
    }

    fn add_demand(&mut self, model: &CrowdModel, cell: usize) {
        if self.world.cells[cell].visible == 0 {
            return;
        }
        let cache_use = self.mode.map_or(CacheUse::Never, |mode| mode.cache);
        for character in cell * CELL..((cell + 1) * CELL).min(self.len()) {
            if self.keys[character] == Key::HIDDEN {
                continue;
            }
            let pixels_per_metre = self.pixels_per_metre(character);
            if self.clocks.is_fading(character) {
                let state = self.clocks.state(character);
                self.sweep.part.see_fading(model, &state, pixels_per_metre);
            } else {
                let clip = self.clocks.from(character).clip();
                let options = model.options(cache_use).of(clip);
                self.sweep.part.see(options, pixels_per_metre);
            }
        }
    }

    /// Level at which a character is shown; `None` if it is not visible.
    pub fn level(&self, character: usize) -> Option<usize> {
        self.keys[character].level()
    }

    /// Pixels that a metre of the world spans at a visible character, the maximum over views.
    #[inline]
    pub(super) fn pixels_per_metre(&self, character: usize) -> f32 {
        match self.mode {
            Some(mode) if mode.is_culled => {
                1.0 / self.sight.metres_per_px[character / LANES].0[character % LANES]
            }
            _ => f32::MAX,
        }
    }

    /// Result of culling a character in the last tick.
    pub fn cull_result(&self, character: usize) -> CullResult {
        let (tile, lane) = (character / LANES, character % LANES);
        let is = |bits: &[u8]| bits[tile] >> lane & 1 == 1;
        if !is(&self.sight.near) && !is(&self.sight.visible) {
            return CullResult::default();
        }
        let is_visible = is(&self.sight.visible);
        let is_culled = self.mode.is_some_and(|m| m.is_culled);
        let pixels_per_metre =
            if is_culled && (self.world.cells[character / CELL].is_stale || !is_visible) {
                look_at_one(&self.views, self.world.sphere(character)).pixels_per_metre
            } else {
                self.pixels_per_metre(character)
            };
        CullResult {
            pixels_per_metre,
            visibility: if is_visible {
                Visibility::Visible
            } else {
                Visibility::Margin
            },
        }
    }

    /// Root motion of a character in the last tick, in the space of its root; zero if no clip has a
    /// trajectory. Hidden characters move too.
    pub fn root_delta(&self, character: usize) -> RootDelta {
        self.roots.get(character).copied().unwrap_or_default()
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
