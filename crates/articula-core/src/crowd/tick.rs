//! One frame of a crowd, from clocks to palettes.

use super::attachment::attachment;
use super::character_state::{CharacterState, ClipState};
use super::crowd_budget::{CrowdBudget, work};
use super::frame::{CacheUse, CrowdEvent, CrowdReport, Culling, Detail, Frame};
use super::level::{Choice, attention, cached_within};
use super::model::CrowdModel;
use super::plan::{Batch, DrawList, Kind, Plan, Poser};
use super::root_path::RootDelta;
use super::share::{ClipWay, Follower, Leader, Sharing};
use crate::Mismatch;
use crate::batch::{BatchPose, Scratch};
use crate::budget::{BudgetPolicy, CostModel};
use crate::level_choice::{level_range, level_within};
use crate::palette::PaletteRows;
use crate::pose_cache::BlendRecord;
use crate::sample::Wrap;
use crate::simd::LANES;
use crate::sphere::Sphere;
use crate::visibility::{Bodies, CullResult, Visibility, cull};
use crate::visibility::{Places, carry};
use glam::Affine3A;
use std::ops::Range;

/// Seconds for which a bound is valid before it is looked up again.
const BOUND_SECS: f32 = 1.0;

/// Level of a character that is not shown.
const HIDDEN: u8 = u8::MAX;
/// Empty range of pixels per metre: the level is chosen again in the next tick.
const ANEW: [f32; 2] = [f32::INFINITY, 0.0];
/// Level of a character before its first frame.
const NEW: u8 = u8::MAX - 1;

/// A tolerance that is the same for all characters, so that levels may be kept while sizes on
/// screen hardly change.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SteadyTolerance {
    px: f32,
}

impl SteadyTolerance {
    /// `Some` if the level of a character depends only on its clip and its size on screen.
    fn of(model: &CrowdModel, frame: &Frame<'_>) -> Option<Self> {
        let Detail::Tolerance { px } = frame.detail else {
            return None;
        };
        let alike = frame.importance.is_empty() && frame.scales.is_empty();
        let plain = alike && !model.has_attention() && !frame.share;
        (plain && frame.cache == CacheUse::Never).then_some(Self { px })
    }
}

/// The characters of one rig: playback state, levels, and the plan of the current frame.
#[derive(Debug, Clone)]
pub struct Crowd {
    states: Vec<CharacterState>,
    levels: Vec<u8>,
    /// Range of pixels per metre in which each character keeps its level: first bound included,
    /// second excluded. Empty if the level has to be chosen again.
    keeps: Vec<[f32; 2]>,
    /// Tolerance that `keeps` was computed for.
    kept_for: Option<SteadyTolerance>,
    /// Model-space bound of each character, and the seconds for which it is still valid.
    bounds: Vec<Sphere>,
    bound_secs: Vec<f32>,
    roots: Vec<RootDelta>,
    // The fields below are recomputed each frame and kept so that nothing is allocated.
    world: Vec<Sphere>,
    seen: Vec<CullResult>,
    ones: Vec<f32>,
    zeros: Vec<f32>,
    sharing: Sharing,
    leader_jobs: Vec<u32>,
    plan: Plan,
    crowd_budget: Option<CrowdBudget>,
}

impl Crowd {
    /// Makes `characters` characters, all playing the first clip from its beginning.
    pub fn new(model: &CrowdModel, characters: usize) -> Self {
        let player = CharacterState::from(ClipState::new(&model.parts().clips, 0));
        let levels = model.levels();
        Self {
            states: vec![player; characters],
            levels: vec![NEW; characters],
            keeps: vec![ANEW; characters],
            kept_for: None,
            bounds: vec![Sphere::default(); characters],
            // Below 0: looked up in the first tick, which spreads the later look-ups over frames.
            bound_secs: vec![-1.0; characters],
            roots: vec![RootDelta::default(); if model.has_paths() { characters } else { 0 }],
            world: vec![Sphere::default(); characters],
            seen: vec![CullResult::default(); characters],
            ones: vec![1.0; characters],
            zeros: vec![0.0; characters],
            sharing: Sharing::new(model.parts().clips.clips(), levels, characters),
            leader_jobs: Vec::with_capacity(characters),
            plan: Plan::new(characters, levels),
            crowd_budget: None,
        }
    }

    /// Bytes of state per character, without budget and output.
    pub const BYTES_PER_CHARACTER: usize = size_of::<CharacterState>()
        + size_of::<u8>()
        + size_of::<[f32; 2]>()
        + size_of::<Sphere>()
        + size_of::<f32>();

    /// Number of characters.
    pub(crate) fn len(&self) -> usize {
        self.states.len()
    }

    /// Returns the playback state of a character.
    pub fn state(&self, character: usize) -> &CharacterState {
        &self.states[character]
    }

    /// Replaces the playback state of a character.
    pub fn play(&mut self, character: usize, player: CharacterState) {
        self.states[character] = player;
        self.bound_secs[character] = -1.0;
        self.keeps[character] = ANEW;
    }

    /// Starts a cross-fade of a character to another clip; see [`CharacterState::fade_to`].
    pub fn fade_to(&mut self, character: usize, clip_state: ClipState, secs: f32) {
        self.states[character].fade_to(clip_state, secs);
        self.bound_secs[character] = -1.0;
        self.keeps[character] = ANEW;
    }

    /// Enables [`Detail::Budget`], with the cost of every level of every clip computed by `costs`.
    /// Allocates.
    ///
    /// # Errors
    /// As [`crate::budget::BudgetAllocator::add_options`].
    pub fn set_budget(
        &mut self,
        model: &CrowdModel,
        policy: BudgetPolicy,
        costs: &CostModel,
    ) -> Result<(), Mismatch> {
        self.crowd_budget = Some(CrowdBudget::new(model, self.len(), policy, costs)?);
        Ok(())
    }

    /// Recomputes the costs of all levels from a cost model, if there is a budget. Does not
    /// allocate.
    pub fn reprice(&mut self, model: &CrowdModel, costs: &CostModel) {
        if let Some(crowd_budget) = &mut self.crowd_budget {
            crowd_budget.reprice(model, costs);
        }
    }

    /// Advances every clock, culls against the views, chooses a level for each character and plans
    /// the evaluation.
    ///
    /// O(characters); does not allocate.
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
        let dt_secs = frame.step_secs();
        self.begin(model, dt_secs);
        self.advance(model, dt_secs, tell);
        self.look(frame);
        let mut report = self.choose(model, frame, tell);
        self.plan.finish(&model.parts().palette, model.morphs().0);
        for batch in self.plan.batches() {
            if !batch.is_cached() {
                report.work += work(model, batch.level(), batch.poses() as u64);
            }
        }
        report
    }

    /// Clears the plan of the frame before.
    fn begin(&mut self, model: &CrowdModel, dt_secs: f32) {
        self.sharing.begin(dt_secs, model.durations());
        self.leader_jobs.clear();
        self.plan.clear();
    }

    /// Advances clocks and root motion, reports events and renews bounds.
    fn advance(&mut self, model: &CrowdModel, dt_secs: f32, tell: &mut dyn FnMut(CrowdEvent)) {
        let durations = model.durations();
        let plain = model.is_plain();
        for (character, player) in self.states.iter_mut().enumerate() {
            let secs = player.from.secs + player.from.speed * dt_secs;
            let within = (0.0..durations[player.from.clip()]).contains(&secs);
            if plain && within && !player.is_fading() {
                // By far the most frequent case: only the time within one clip advances.
                player.from.secs = secs;
            } else {
                let way = advance_one(model, character, player, dt_secs, tell);
                if let Some(root) = self.roots.get_mut(character) {
                    *root = way;
                }
            }
            let left = &mut self.bound_secs[character];
            *left -= dt_secs;
            if *left < 0.0 {
                let (bound, secs) = bound_of(model, player);
                self.bounds[character] = bound;
                // The first bounds are spread, so that they do not all expire in one frame.
                let first = self.levels[character] == NEW;
                let part = (character % 32 + 1) as f32 / 32.0;
                *left = if first { secs * part } else { secs };
            }
        }
    }

    /// Culls all characters against the views.
    fn look(&mut self, frame: &Frame<'_>) {
        let count = self.len();
        let scales = or_all(frame.scales, &self.ones);
        let margins = or_all(frame.cull_margin_metres, &self.zeros);
        let importance = or_all(frame.importance, &self.ones);
        for slice in [scales, margins, importance] {
            assert_eq!(slice.len(), count, "expected one entry for each character");
        }
        for places in [frame.positions.len(), frame.rotations.len()] {
            assert_eq!(
                places, count,
                "expected one position and one rotation for each character"
            );
        }
        match frame.culling {
            Culling::Off => self.seen.fill(CullResult {
                pixels_per_metre: f32::MAX,
                visibility: Visibility::Visible,
            }),
            Culling::Views(views) => {
                // Lengths were just checked, so neither can fail.
                if let Ok(places) =
                    Places::new(frame.positions, frame.rotations, scales, &self.bounds)
                {
                    carry(places, &mut self.world);
                }
                if let Ok(bodies) = Bodies::new(&self.world, margins) {
                    cull(views, bodies, &mut self.seen);
                }
            }
        }
    }

    /// Chooses a level for every visible character and plans the evaluation.
    fn choose(
        &mut self,
        model: &CrowdModel,
        frame: &Frame<'_>,
        tell: &mut dyn FnMut(CrowdEvent),
    ) -> CrowdReport {
        let mut report = CrowdReport::default();
        if let (Detail::Budget { cost }, Some(crowd_budget)) =
            (frame.detail, &mut self.crowd_budget)
        {
            report.budget =
                Some(crowd_budget.spend(cost, frame, &self.states, &self.seen, &self.bounds));
        }
        let (mut unchanged, mut bound_part) = (0, 0f32);
        let kept = SteadyTolerance::of(model, frame);
        if kept != self.kept_for {
            self.keeps.fill(ANEW);
            self.kept_for = kept;
        }
        for character in 0..self.len() {
            let seen = self.seen[character];
            let [least, most] = self.keeps[character];
            if seen.visibility == Visibility::Visible
                && (least..most).contains(&seen.pixels_per_metre)
            {
                // By far the most frequent case: visible, and about as large as before.
                unchanged += 1;
                bound_part = bound_part.max(seen.pixels_per_metre / most);
                let level = usize::from(self.levels[character]);
                self.plan
                    .add(level, Kind::Clip, Poser::Character(character));
                continue;
            }
            if seen.visibility != Visibility::Visible {
                report.in_margin += usize::from(seen.visibility == Visibility::Margin);
                if self.levels[character] != HIDDEN {
                    self.set_level(model, character, (None, 0.0), tell);
                    self.keeps[character] = ANEW;
                }
                continue;
            }
            report.visible += 1;
            let choice = self.choice(model, frame, character);
            let pixels_per_metre = choice.pixels_per_metre;
            self.set_level(
                model,
                character,
                (Some(choice.level), pixels_per_metre),
                tell,
            );
            self.keeps[character] = self.keeping(model, character, choice.level);
            self.show(model, frame, character, choice, &mut report);
        }
        report.visible += unchanged;
        report.own += unchanged;
        if let Some(SteadyTolerance { px }) = kept {
            report.bound_px = report.bound_px.max(bound_part * px);
        }
        report
    }

    /// Range of pixels per metre in which a level need not be chosen again.
    fn keeping(&self, model: &CrowdModel, character: usize, level: usize) -> [f32; 2] {
        let player = &self.states[character];
        match self.kept_for {
            Some(SteadyTolerance { px }) if !player.is_fading() => {
                level_range(model.errors_of(player.from.clip()), level, px)
            }
            _ => ANEW,
        }
    }

    /// Chooses the level of a visible character.
    fn choice(&self, model: &CrowdModel, frame: &Frame<'_>, character: usize) -> Choice {
        let player = &self.states[character];
        let (from, to) = player.clips();
        let pixels_per_metre = self.seen[character].pixels_per_metre * frame.scale(character);
        let coarsest = model.levels() - 1;
        let shown = Some(usize::from(self.levels[character])).filter(|l| *l <= coarsest);
        let mut tolerance_metres = 0.0;
        let level = match frame.detail {
            Detail::Full => 0,
            Detail::Level(level) => level.min(coarsest),
            Detail::Budget { .. } => {
                let crowd_budget = self.crowd_budget.as_ref();
                let found = crowd_budget.and_then(|p| p.level(character));
                found.unwrap_or(coarsest)
            }
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

    /// Plans the pose of a character: cached, shared or evaluated for it alone.
    fn show(
        &mut self,
        model: &CrowdModel,
        frame: &Frame<'_>,
        character: usize,
        choice: Choice,
        report: &mut CrowdReport,
    ) {
        let player = &self.states[character];
        let fading = player.fade != 0.0;
        if choice.cached {
            let bound_px = choice.error_metres * choice.pixels_per_metre;
            report.bound_px = report.bound_px.max(bound_px);
            report.cached += 1;
            let located =
                model.parts().cache.as_ref().and_then(|cache| {
                    cache.locate(player.from.clip(), choice.level, player.from.secs)
                });
            match located {
                Some(record) if frame.cache == CacheUse::Gpu => {
                    self.plan.record(choice.level, record.of(character as u32));
                }
                _ => {
                    let poser = Poser::Character(character);
                    self.plan.add(choice.level, Kind::Cached, poser);
                }
            }
            return;
        }
        if shares(frame, player) && choice.slack_metres > 0.0 {
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
                report.sharing_characters += 1;
                let whole = choice.error_metres + choice.slack_metres;
                report.bound_px = report.bound_px.max(whole * choice.pixels_per_metre);
                if leader == self.leader_jobs.len() {
                    report.shared_poses += 1;
                    let poser = Poser::Leader(leader);
                    let job = self.plan.add(choice.level, Kind::Clip, poser);
                    self.leader_jobs.push(job);
                }
                self.plan
                    .follow(choice.level, character, self.leader_jobs[leader]);
                return;
            }
        }
        report.own += 1;
        let bound_px = choice.error_metres * choice.pixels_per_metre;
        report.bound_px = report.bound_px.max(bound_px);
        report.blended += usize::from(fading);
        let kind = if fading { Kind::Blend } else { Kind::Clip };
        self.plan
            .add(choice.level, kind, Poser::Character(character));
    }

    /// Stores a level, and reports an event if it changed. A metre of the character spans
    /// `pixels_per_metre`.
    #[inline]
    fn set_level(
        &mut self,
        model: &CrowdModel,
        character: usize,
        (level, pixels_per_metre): (Option<usize>, f32),
        tell: &mut dyn FnMut(CrowdEvent),
    ) {
        let now = level.map_or(HIDDEN, |l| l as u8);
        let before = std::mem::replace(&mut self.levels[character], now);
        let before = if before == NEW { HIDDEN } else { before };
        if before == now {
            return;
        }
        let from = Some(usize::from(before)).filter(|_| before != HIDDEN);
        let (a, b) = self.states[character].clips();
        let error = |level: Option<usize>| level.map_or(0.0, |l| model.error_metres(a, b, l));
        let jump_px = match (from, level) {
            (Some(_), Some(_)) => (error(from) + error(level)) * pixels_per_metre,
            _ => 0.0,
        };
        tell(CrowdEvent::Level {
            character,
            from,
            to: level,
            jump_px,
        });
    }

    /// Level at which a character is shown; `None` if it is not visible.
    pub fn level(&self, character: usize) -> Option<usize> {
        Some(usize::from(self.levels[character])).filter(|l| *l < usize::from(NEW))
    }

    /// Result of culling a character in the last tick.
    pub fn cull_result(&self, character: usize) -> CullResult {
        self.seen[character]
    }

    /// Root motion of a character in the last tick, in the space of its root; zero if no clip has a
    /// trajectory. Hidden characters move too.
    pub fn root_delta(&self, character: usize) -> RootDelta {
        self.roots.get(character).copied().unwrap_or_default()
    }

    /// Model-from-joint matrix of a joint at full detail, whatever the level and visibility of the
    /// character. O(depth); does not allocate.
    ///
    /// # Panics
    /// If there is no such character or joint.
    pub fn attachment(&self, model: &CrowdModel, character: usize, joint: usize) -> Affine3A {
        let shown = self.states[character].shown(&model.parts().clips);
        attachment(&model.parts().clips, &shown, joint)
    }

    /// Draw list of the last tick: the visible characters by level, and where their palettes are.
    pub fn draw_list(&self) -> &DrawList {
        self.plan.draw_list()
    }

    /// Range of matrices that a range of batches writes, among all matrices of the frame.
    ///
    /// # Panics
    /// If the range ends beyond the batches.
    pub fn matrices_of(&self, batches: Range<usize>) -> Range<usize> {
        assert!(
            batches.end <= self.draw_list().batches,
            "the range of batches is out of bounds"
        );
        self.plan.first_matrix(batches.start)..self.plan.first_matrix(batches.end)
    }

    /// Returns the batches from `first` on that write about `1 / parts` of all matrices, for
    /// distribution over threads. Empty when no batches are left.
    pub fn share_of_batches(&self, first: usize, parts: usize) -> Range<usize> {
        let count = self.draw_list().batches;
        let aim = self.plan.first_matrix(first) + self.draw_list().matrices.div_ceil(parts.max(1));
        let mut end = (first + 1).min(count);
        while end < count && self.plan.first_matrix(end) < aim {
            end += 1;
        }
        first.min(count)..end
    }

    /// Writes the palettes of a range of batches. Ranges are independent: the bytes are the same in
    /// whatever order and on whatever threads they are evaluated.
    ///
    /// O(joints of the batches); does not allocate.
    ///
    /// # Panics
    /// If `out` does not have the rows of [`Crowd::matrices_of`] this range, in the form of the
    /// model, or `scratch` is not of the model's evaluator.
    pub fn evaluate(
        &self,
        model: &CrowdModel,
        batches: Range<usize>,
        mut out: PaletteRows<'_>,
        scratch: &mut Scratch,
    ) {
        let evaluator = model.evaluator();
        let rows = model.parts().form.rows();
        let first = self.matrices_of(batches.clone());
        assert_eq!(
            out.len(),
            first.len() * rows,
            "the output must hold every palette"
        );
        let first = first.start;
        for at in batches {
            let batch = self.plan.batches()[at];
            let matrices = self.matrices_of(at..at + 1);
            let part = (matrices.start - first) * rows..(matrices.end - first) * rows;
            if batch.is_cached() {
                self.blend(model, &batch, out.part(part));
                continue;
            }
            let mut shown = [BatchPose::from(model.parts().clips.cursor(0, 0.0)); LANES];
            for (shown, poser) in shown.iter_mut().zip(self.plan.posers(&batch)) {
                *shown = self.posed(model, poser);
            }
            let shown = &shown[..batch.poses()];
            evaluator.evaluate(batch.level(), shown, out.part(part), scratch);
        }
    }

    /// Writes the morph target weights of a range of sets, for each as many as the mesh has targets
    /// ([`MorphClips::targets`](super::MorphClips::targets)), at the character's own times: a
    /// character with a shared or cached pose has its own face. Ranges are independent, as of
    /// [`Crowd::evaluate`].
    ///
    /// O(targets of the sets); does not allocate.
    ///
    /// # Panics
    /// If the range ends beyond [`DrawList::morph_sets`], or `out` does not have the weights of these
    /// sets.
    pub fn evaluate_morphs(&self, model: &CrowdModel, sets: Range<usize>, out: &mut [f32]) {
        let (_, targets) = model.morphs();
        assert!(
            sets.end <= self.draw_list().morph_sets(),
            "the range of morph sets is out of bounds"
        );
        assert_eq!(
            out.len(),
            sets.len() * targets,
            "the output must hold the weights of every set"
        );
        let Some(morphs) = model.parts().morphs.as_ref().filter(|_| targets > 0) else {
            return;
        };
        for (set, out) in sets.zip(out.chunks_exact_mut(targets)) {
            let character = self.draw_list().character_of(set);
            morphs.sample(&self.states[character], out);
        }
    }

    /// Blends cached palettes.
    fn blend(&self, model: &CrowdModel, batch: &Batch, out: PaletteRows<'_>) {
        let Some(cache) = model.parts().cache.as_ref() else {
            return;
        };
        let mut records = [BlendRecord::default(); LANES];
        for (record, poser) in records.iter_mut().zip(self.plan.posers(batch)) {
            if let Poser::Character(character) = poser {
                let ClipState { secs, clip, .. } = self.states[character].from;
                let located = cache.locate(usize::from(clip), batch.level(), secs);
                *record = located.unwrap_or_default();
            }
        }
        let records = &records[..batch.poses()];
        cache.blend(batch.level(), records, model.parts().backend, out);
    }

    #[inline]
    fn posed(&self, model: &CrowdModel, poser: Poser) -> BatchPose {
        match poser {
            Poser::Character(c) => self.states[c].shown(&model.parts().clips),
            Poser::Leader(l) => {
                let Leader { clip, secs } = self.sharing.leaders()[l];
                model.parts().clips.cursor(usize::from(clip), secs).into()
            }
        }
    }
}

fn or_all<'a>(given: &'a [f32], all: &'a [f32]) -> &'a [f32] {
    if given.is_empty() { all } else { given }
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

/// Advances one character, reports its events and returns its root motion.
fn advance_one(
    model: &CrowdModel,
    character: usize,
    player: &mut CharacterState,
    dt_secs: f32,
    tell: &mut dyn FnMut(CrowdEvent),
) -> RootDelta {
    let (way, _) = player.advance(model, dt_secs, &mut |clip, event, weight| {
        tell(CrowdEvent::Clip {
            character,
            clip,
            id: event.id,
            weight,
        });
    });
    way
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
