//! One frame of a crowd: clocks, bounds, views, levels and the plan of the evaluation.

use super::character_state::{CharacterState, ClipState};
use super::clocks::Clocks;
use super::demand::{Costs, Demand, Tolerances};
use super::frame::{CrowdEvent, CrowdReport, Culling, Frame, Moved};
use super::keys::SectionKeys;
use super::mode::Mode;
use super::model::CrowdModel;
use super::places::{CELL, WorldBounds};
use super::plan::Plan;
use super::root_path::RootDelta;
use super::section::{CrowdSection, SECTION, Step, Turn};
use super::sources::{FACES, KINDS, Source, evaluated};
use crate::allowance::Allowance;
use crate::simd::LANES;
use crate::sphere::Sphere;
use crate::visibility::{CullResult, View, Visibility, look_at_one};

/// Tiles of a section.
const SECTION_TILES: usize = SECTION / LANES;

/// Cost by tolerance, summed up tile by tile, with the options by the cost of the frame and by that of the
/// processor, in turns.
#[derive(Debug, Clone)]
struct Sweep {
    whole: [Demand; 2],
    part: Demand,
    list: usize,
    next_tile: usize,
    is_first: bool,
}

impl Sweep {
    fn new() -> Self {
        Self {
            whole: [Demand::NONE; 2],
            part: Demand::NONE,
            list: 0,
            next_tile: 0,
            is_first: true,
        }
    }
}

/// The characters of one rig: playback state, levels, and the plan of the current frame.
#[derive(Debug, Clone)]
pub struct Crowd {
    characters: usize,
    /// The characters in their order, [`SECTION`] in each but the last.
    pub(super) sections: Vec<CrowdSection>,
    /// Seconds since the first frame.
    now_secs: f64,
    /// Views and mode of the last frame.
    views: Vec<View<'static>>,
    mode: Option<Mode>,
    /// The first cell that next takes over what a frame allows.
    next_turn: usize,
    pub(super) plan: Plan,
    sweep: Sweep,
}

impl Crowd {
    /// Makes `characters` characters, all playing the first clip from its beginning.
    pub fn new(model: &CrowdModel, characters: usize) -> Self {
        let levels = model.levels();
        let sections = (0..characters).step_by(SECTION);
        let section = |first| CrowdSection::new(model, first, SECTION.min(characters - first));
        Self {
            characters,
            sections: sections.map(section).collect(),
            now_secs: 0.0,
            views: Vec::with_capacity(8),
            mode: None,
            next_turn: 0,
            plan: Plan::new(characters, levels),
            sweep: Sweep::new(),
        }
    }

    /// Bytes of state per character, without budget and output. One that fades takes 28 more, and each
    /// of a model whose clips move morph targets one more.
    pub const BYTES_PER_CHARACTER: usize = Clocks::BYTES
        + size_of::<Sphere>()
        + WorldBounds::BYTES
        + SectionKeys::BYTES
        + size_of::<u8>()
        + size_of::<[f32; 2]>();

    /// Number of characters.
    pub(crate) fn len(&self) -> usize {
        self.characters
    }

    /// Section of a character, and its index there.
    #[inline]
    pub(super) fn at(&self, character: usize) -> (&CrowdSection, usize) {
        (&self.sections[character / SECTION], character % SECTION)
    }

    /// Returns the playback state of a character.
    pub fn state(&self, character: usize) -> CharacterState {
        let (section, character) = self.at(character);
        section.clocks.state(character)
    }

    /// Returns the clip of a character, and the one that it fades to: the cheap part of
    /// [`state`](Self::state).
    #[inline]
    pub fn clips(&self, character: usize) -> (usize, Option<usize>) {
        let (section, character) = self.at(character);
        section.clocks.clips(character)
    }

    /// Replaces the playback state of a character.
    pub fn play(&mut self, character: usize, player: CharacterState) {
        self.sections[character / SECTION].play(character % SECTION, &player);
    }

    /// Starts a cross-fade of a character to another clip; see [`CharacterState::fade_to`].
    pub fn fade_to(&mut self, character: usize, clip_state: ClipState, secs: f32) {
        let mut state = self.state(character);
        state.fade_to(clip_state, secs);
        self.play(character, state);
    }

    /// Advances every clock, culls against the views, chooses a level for each character and plans
    /// the evaluation. Events come in the order of the characters' sections, 1024 to each: those of
    /// its clips, then its changes of level.
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
        let step = self.begin(model, frame);
        for section in &mut self.sections {
            section.tick(&step, tell);
        }
        self.end(&step)
    }

    /// [`tick`](Self::tick) on several threads: `run` applies the given function to each of the given
    /// sections, in any order and on any threads. State, events and report are those of `tick`.
    ///
    /// Sections that `run` leaves out are ticked afterwards on the calling thread. Allocates where
    /// there are more events than in any earlier call.
    ///
    /// ```
    /// use articula_core::crowd::{Crowd, CrowdModel, CrowdReport, Frame};
    ///
    /// fn tick(crowd: &mut Crowd, model: &CrowdModel, frame: &Frame<'_>) -> CrowdReport {
    ///     crowd.tick_on(model, frame, &mut |_| {}, |sections, tick| {
    ///         let half = sections.len() / 2;
    ///         let (left, right) = sections.split_at_mut(half);
    ///         std::thread::scope(|threads| {
    ///             threads.spawn(|| left.iter_mut().for_each(tick));
    ///             right.iter_mut().for_each(tick);
    ///         });
    ///     })
    /// }
    /// ```
    ///
    /// # Panics
    /// As [`tick`](Self::tick).
    pub fn tick_on(
        &mut self,
        model: &CrowdModel,
        frame: &Frame<'_>,
        tell: &mut dyn FnMut(CrowdEvent),
        run: impl FnOnce(&mut [CrowdSection], &(dyn Fn(&mut CrowdSection) + Sync)),
    ) -> CrowdReport {
        let step = self.begin(model, frame);
        for section in &mut self.sections {
            section.is_ticked = false;
        }
        let tick = |section: &mut CrowdSection| section.tick_and_keep_events(&step);
        run(&mut self.sections, &tick);
        for section in &mut self.sections {
            if !section.is_ticked {
                section.tick_and_keep_events(&step);
            }
            section.events.drain(..).for_each(&mut *tell);
        }
        self.end(&step)
    }

    /// Checks the frame, and finds what has changed since the one before.
    fn begin<'a>(&mut self, model: &'a CrowdModel, frame: &'a Frame<'a>) -> Step<'a> {
        self.check(frame);
        let dt_secs = frame.step_secs();
        self.now_secs += f64::from(dt_secs);
        if let Moved::These(characters) = frame.moved {
            for character in characters.iter().map(|c| *c as usize) {
                let section = &mut self.sections[character / SECTION];
                section.world.touch(character % SECTION);
            }
        }
        let views = match frame.culling {
            Culling::Views(views) => views,
            Culling::Off => &[],
        };
        let allowance = frame.detail.allowance();
        let allowance = allowance.unwrap_or(Allowance::of(1.0));
        let mode = Mode::of(model, frame);
        let before = self.mode.replace(mode);
        let mut known = self.views.iter().zip(views);
        let same_views =
            self.views.len() == views.len() && known.all(|(a, b)| *a == b.unoccluded());
        if !same_views {
            self.views.clear();
            self.views.extend(views.iter().map(View::unoccluded));
        }
        Step {
            model,
            frame,
            views,
            mode,
            allowance,
            turn: self.turn(allowance),
            dt_secs,
            now_secs: self.now_secs,
            same_mode: before == Some(mode),
            same_options: before.is_some_and(|b| b.cache == mode.cache),
            same_views,
        }
    }

    /// The cells that take over an allowance in this frame, so many that all have had their turn within as many
    /// frames as it names.
    fn turn(&mut self, allowance: Allowance) -> Turn {
        let cells = self.characters.div_ceil(CELL);
        let turn = Turn {
            first: self.next_turn,
            count: cells.div_ceil(usize::from(allowance.frames).max(1)),
            cells,
        };
        self.next_turn = (turn.first + turn.count) % cells.max(1);
        turn
    }

    /// Plans the evaluation.
    fn end(&mut self, step: &Step<'_>) -> CrowdReport {
        if self.sections.iter().any(|s| s.is_sorted_anew) {
            let keys = self.sections.iter().map(|s| &s.keys);
            let (morph_levels, _) = step.model.morphs();
            let (palette, lanes) = (&step.model.parts().palette, step.model.evaluator().lanes());
            self.plan.make(keys, palette, lanes, morph_levels);
        }
        self.report(step.model)
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

    /// Counts poses, work and errors of the plan.
    fn report(&self, model: &CrowdModel) -> CrowdReport {
        let mut report = CrowdReport::default();
        for (level, counts) in self.plan.counts().iter().enumerate() {
            let of = |source: Source| counts[source as usize];
            let own = of(Source::Clip) + of(Source::Blend);
            report.own += own;
            report.blended += of(Source::Blend);
            report.cached += of(Source::Cached) + of(Source::Record);
            report.stepped += of(Source::Step);
            report.impostors += of(Source::Impostor);
            report.work += evaluated(model.parts(), level, own as u64);
        }
        for seen in self.sections.iter().map(|s| s.seen) {
            report.visible += seen.visible;
            report.in_margin += seen.in_margin;
            report.bound_px = report.bound_px.max(seen.bound_px);
        }
        report
    }

    /// Nominal nanoseconds of the planned frame, by kind of work. O(levels, and sets of morph target weights).
    pub(super) fn work_ns(&self, model: &CrowdModel) -> Costs {
        let mut work = [0.0; KINDS];
        for (level, counts) in self.plan.counts().iter().enumerate() {
            for source in Source::ALL {
                let count = counts[source as usize];
                if count > 0 {
                    let ns = source.cost_ns(model.parts(), level);
                    work[source.kind()] += count as f64 * f64::from(ns);
                }
            }
        }
        for character in self.draw_list().with_sets() {
            let (section, character) = self.at(character as usize);
            work[FACES] += f64::from(section.morphs_ns(model, character));
        }
        work
    }

    /// Cost of the visible characters by tolerance, with the options by the cost of the frame and by that of
    /// the processor. For one of the two, in turns, as many characters are summed up anew as have all had their turn
    /// within `frames` calls, none if these are 0; in the first call all for both. Each call takes as long as others,
    /// whoever is seen.
    pub(super) fn demand(
        &mut self,
        model: &CrowdModel,
        tolerances: Tolerances,
        frames: usize,
    ) -> &[Demand; 2] {
        if std::mem::replace(&mut self.sweep.is_first, false) {
            for _ in 0..2 {
                self.sum_up(model, tolerances, usize::MAX);
            }
        } else if frames > 0 {
            let visible: usize = self.sections.iter().map(|s| s.seen.visible).sum();
            self.sum_up(model, tolerances, visible.div_ceil(frames).max(1));
        }
        &self.sweep.whole
    }

    /// Sums up so many of the next visible characters, but none of another list of options.
    fn sum_up(&mut self, model: &CrowdModel, tolerances: Tolerances, characters: usize) {
        let sweep = &mut self.sweep;
        let count = self.characters.div_ceil(LANES);
        let mut left = characters;
        while left > 0 && sweep.next_tile < count {
            let section = &self.sections[sweep.next_tile / SECTION_TILES];
            let of = (sweep.next_tile % SECTION_TILES, sweep.list);
            let seen = section.add_demand(model, of, tolerances, &mut sweep.part);
            left = left.saturating_sub(seen);
            sweep.next_tile += 1;
        }
        if sweep.next_tile == count {
            sweep.next_tile = 0;
            sweep.whole[sweep.list] = std::mem::replace(&mut sweep.part, Demand::NONE);
            sweep.list = 1 - sweep.list;
        }
    }

    /// Level at which a character is shown; `None` if it is not visible.
    pub fn level(&self, character: usize) -> Option<usize> {
        let (section, character) = self.at(character);
        section.keys.get(character).level()
    }

    /// Morph level at which a character is shown ([`MorphLods`](super::MorphLods)); `None` if it is
    /// not visible, or its level shows no morph targets.
    pub fn morph_level(&self, model: &CrowdModel, character: usize) -> Option<usize> {
        let (levels, _) = model.morphs();
        self.level(character).filter(|level| *level < levels)?;
        let (section, character) = self.at(character);
        Some(section.morphs.get(character))
    }

    /// Result of culling a character in the last tick.
    pub fn cull_result(&self, character: usize) -> CullResult {
        let (section, character) = self.at(character);
        let (tile, lane) = (character / LANES, character % LANES);
        let is = |bits: &[u8]| bits[tile] >> lane & 1 == 1;
        if !is(&section.sight.near) && !is(&section.sight.visible) {
            return CullResult::default();
        }
        let is_visible = is(&section.sight.visible);
        let is_culled = self.mode.is_some_and(|m| m.is_culled);
        let is_stale = section.world.cells[character / CELL].is_stale;
        let pixels_per_metre = if is_culled && (is_stale || !is_visible) {
            look_at_one(&self.views, section.world.sphere(character)).pixels_per_metre
        } else {
            section.pixels_per_metre(character)
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
    /// trajectory. Hidden characters move too. The model is the one of that tick.
    pub fn root_delta(&self, model: &CrowdModel, character: usize) -> RootDelta {
        let (section, character) = self.at(character);
        section.root_delta(model, character)
    }
}
