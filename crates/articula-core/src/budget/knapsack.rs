//! Choice of one option for each character: greedy by gain per cost, repaired from frame to frame.
//!
//! Source: `docs/methods/motion-lod.md` part 7. The plain form starts every character at the
//! cheapest option and takes the upgrade with the largest error drop per cost until the budget is
//! used; its total error exceeds the least possible by at most one upgrade. The implementation
//! needs no heap: the upgrades taken are those above one key, which [`super::frontier`] finds. A
//! repair gives exactly the solution of a new start, and visits only the characters that changed
//! and those whose next or last upgrade lies near that key.

use super::character_entry::{ALARM, BudgetPolicy, CharacterEntry, EMPTY, LodRequest, Watch};
use super::frontier::{Break, Frontier, Span};
use super::lod_options::{LodOption, LodOptionSet, LodOptionSetId, from_fixed, to_fixed};
use super::report::{AllocationReport, OptionChange, survey};
use crate::Mismatch;

/// Key of characters that must be visited in any case; no upgrade has it.
const TOUCHED: u32 = u32::MAX;
/// Number of characters tested at once.
const ROW: usize = 16;
/// No option: hidden.
const NOTHING: u8 = u8::MAX;

/// Allocator of a cost budget: chooses an LOD option for each of a fixed number of characters, all
/// hidden at first.
///
/// Each frame: [`request`](Self::request) or [`hide`](Self::hide) for every character whose
/// visibility or size on screen may have changed, then [`solve`](Self::solve).
#[derive(Debug, Clone)]
pub struct BudgetAllocator {
    policy: BudgetPolicy,
    option_sets: Vec<LodOptionSet>,
    entries: Vec<CharacterEntry>,
    watches: Vec<Watch>,
    /// Keys of the next upgrade of each character and of the last one taken.
    next_key: Vec<u32>,
    last_key: Vec<u32>,
    /// Error, pixels per metre and option that are shown now.
    error_metres: Vec<f32>,
    pixels_per_metre: Vec<f32>,
    shown: Vec<u8>,
    frontier: Frontier,
    /// Cost of the cheapest options, of the chosen ones and of the best ones within the policy, in
    /// fixed point.
    base: u64,
    used: u64,
    demand: u64,
    visible: usize,
    room: u64,
    stirred: bool,
    frame: u32,
    looked_at: Vec<u32>,
    /// Characters whose turn began in the frame before.
    newly_served: Vec<u32>,
    changes: Vec<OptionChange>,
    per_option: Vec<u32>,
}

impl BudgetAllocator {
    /// Makes an allocator for `characters` characters, all hidden.
    pub fn new(characters: usize, policy: BudgetPolicy) -> Self {
        Self {
            policy,
            option_sets: Vec::new(),
            entries: vec![EMPTY; characters],
            watches: vec![ALARM; characters],
            next_key: vec![0; characters],
            last_key: vec![TOUCHED; characters],
            error_metres: vec![0.0; characters],
            pixels_per_metre: vec![0.0; characters],
            shown: vec![NOTHING; characters],
            frontier: Frontier::new(),
            base: 0,
            used: 0,
            demand: 0,
            visible: 0,
            room: 0,
            stirred: false,
            frame: 0,
            looked_at: Vec::with_capacity(characters),
            newly_served: Vec::with_capacity(characters),
            changes: Vec::with_capacity(characters),
            per_option: Vec::new(),
        }
    }

    /// Adds the options of a kind of character. Allocates; for set-up, not for frames.
    ///
    /// # Errors
    /// If there are no options or more than 255, a cost is negative or not finite, or an error is
    /// negative or NaN.
    pub fn add_options(&mut self, lod_options: &[LodOption]) -> Result<LodOptionSetId, Mismatch> {
        let id = LodOptionSetId(self.option_sets.len() as u32);
        self.option_sets.push(LodOptionSet::new(lod_options)?);
        let most = self.per_option.len().max(lod_options.len());
        self.per_option.resize(most, 0);
        Ok(id)
    }

    /// Sets the request of a visible character for this frame.
    ///
    /// Its entry is updated only if it was hidden, has another option set, or its pixels per metre
    /// changed by more than 10 % or its weight by more than a third since the last update; so its
    /// error may exceed the cap by a tenth before that. O(1); does not allocate.
    ///
    /// # Panics
    /// If there is no such character, or the option set is of another allocator with more option
    /// sets.
    #[inline]
    pub fn request(&mut self, character: usize, request: LodRequest) {
        if self.watches[character].is_quiet(&request) {
            self.pixels_per_metre[character] = request.pixels_per_metre;
        } else {
            self.judge(character, &request.tamed());
        }
    }

    /// Hides a character: it costs nothing and has no error.
    pub fn hide(&mut self, character: usize) {
        if self.entries[character].visible {
            self.retract(character);
            self.entries[character] = EMPTY;
            self.watches[character] = ALARM;
            self.touch(character);
        }
    }

    /// Forces an update of a character's entry at its next request, for example because a hold
    /// ended.
    pub fn force_update(&mut self, character: usize) {
        self.watches[character] = ALARM;
    }

    /// Replaces the policy and updates all entries. O(characters); does not allocate.
    pub fn set_policy(&mut self, policy: BudgetPolicy) {
        self.policy = policy;
        self.rebuild();
    }

    /// Sets the cost of every option, by its option set and its index in it, and updates all
    /// entries. NaN makes an option too expensive to be chosen, a negative cost makes it free.
    /// O(characters + options); does not allocate.
    pub fn reprice(&mut self, mut cost: impl FnMut(LodOptionSetId, usize) -> f32) {
        for (id, option_set) in self.option_sets.iter_mut().enumerate() {
            option_set.reprice(|option| cost(LodOptionSetId(id as u32), option));
        }
        self.rebuild();
    }

    /// Chooses an option for every character within `budget`, in the cost units of the options; NaN
    /// counts as 0. Does not allocate. If nothing changed, it costs little more than the report.
    pub fn solve(&mut self, budget: f32) -> AllocationReport {
        self.frame = self.frame.wrapping_add(1);
        self.changes.clear();
        self.age();
        let budget = to_fixed(budget);
        let room = budget.saturating_sub(self.base);
        if self.stirred || room != self.room {
            self.room = room;
            self.stirred = false;
            self.repair();
        }
        self.report(budget)
    }

    /// Option of a character, as an index into those given to [`BudgetAllocator::add_options`];
    /// `None` if it is hidden.
    pub fn choice(&self, character: usize) -> Option<usize> {
        option(self.shown[character]).map(usize::from)
    }

    /// Changes made by the last [`BudgetAllocator::solve`], in the order of characters.
    pub fn changes(&self) -> &[OptionChange] {
        &self.changes
    }

    /// Number of characters with each option, by the index of the option in its set.
    pub fn per_option(&self) -> &[u32] {
        &self.per_option
    }

    #[cold]
    fn judge(&mut self, character: usize, request: &LodRequest) {
        if self.entries[character].visible {
            self.retract(character);
        }
        let option_set = &self.option_sets[request.option_set.0 as usize];
        self.entries[character].judge(option_set, request, &self.policy);
        self.watches[character] = Watch::around(&self.entries[character]);
        self.pixels_per_metre[character] = request.pixels_per_metre;
        self.enter(character);
    }

    /// Removes a visible character's options from all sums.
    fn retract(&mut self, character: usize) {
        let entry = &self.entries[character];
        let option_set = &self.option_sets[entry.option_set as usize];
        let base = u64::from(option_set.points()[0].cost);
        for (key, cost) in entry.upgrades(option_set, 0) {
            self.frontier.remove(key, cost);
        }
        self.base -= base;
        self.demand -= u64::from(option_set.points()[usize::from(entry.last)].cost);
        self.used -= u64::from(option_set.points()[usize::from(entry.chosen)].cost);
        self.visible -= 1;
    }

    /// Adds a visible character's options to all sums, with the cheapest one chosen.
    fn enter(&mut self, character: usize) {
        let entry = &mut self.entries[character];
        entry.chosen = 0;
        let option_set = &self.option_sets[entry.option_set as usize];
        let base = u64::from(option_set.points()[0].cost);
        for (key, cost) in entry.upgrades(option_set, 0) {
            self.frontier.add(key, cost);
        }
        self.base += base;
        self.demand += u64::from(option_set.points()[usize::from(entry.last)].cost);
        self.used += base;
        self.visible += 1;
        self.touch(character);
    }

    fn touch(&mut self, character: usize) {
        self.next_key[character] = TOUCHED;
        self.stirred = true;
    }

    fn rebuild(&mut self) {
        self.frontier.clear();
        (self.base, self.used, self.demand, self.visible) = (0, 0, 0, 0);
        for character in 0..self.entries.len() {
            let entry = &mut self.entries[character];
            if self.policy.patience_frames == 0 {
                (entry.ageing, entry.turn) = (1.0, false);
            }
            if entry.visible {
                let request = LodRequest {
                    option_set: LodOptionSetId(entry.option_set),
                    weight: entry.weight,
                    pixels_per_metre: entry.pixels_per_metre,
                };
                entry.judge(
                    &self.option_sets[entry.option_set as usize],
                    &request,
                    &self.policy,
                );
                self.enter(character);
            }
        }
    }

    /// Visits one block of characters, the next one each frame, so that each is visited once in
    /// `patience_frames`: characters that wait gain weight, those that were served for long enough
    /// lose it again.
    fn age(&mut self) {
        let patience = self.policy.patience_frames as usize;
        if patience == 0 {
            self.newly_served.clear();
            return;
        }
        // Characters whose turn began are aged at once, before those that wait overtake them.
        for k in 0..self.newly_served.len() {
            self.age_one(self.newly_served[k] as usize);
        }
        self.newly_served.clear();
        let block = self.entries.len().div_ceil(patience);
        let from = block * (self.frame as usize % patience);
        for character in from..(from + block).min(self.entries.len()) {
            self.age_one(character);
        }
    }

    fn age_one(&mut self, character: usize) {
        let entry = &mut self.entries[character];
        let before = entry.ageing;
        let ageing = entry.aged(self.frame, &self.policy);
        if entry.visible && ageing != before {
            self.retract(character);
            self.entries[character].ageing = ageing;
            self.enter(character);
        }
    }

    /// Finds where the budget ends now and moves the characters on the wrong side across.
    fn repair(&mut self) {
        let span = self.frontier.seek(self.room);
        self.look_for(span);
        for k in 0..self.looked_at.len() {
            let character = self.looked_at[k] as usize;
            let (entry, option_set) =
                entry_and_options(&mut self.entries, &self.option_sets, character);
            let before = entry.chosen;
            // Keys fall, but counting all of them costs less than a branch where they pass the
            // span.
            let above = entry
                .upgrades(option_set, 0)
                .filter(|u| u.0 > span.greatest);
            entry.chosen = above.count() as u8;
            self.next_key[character] = entry.next_key(option_set);
            if entry.visible {
                let cost = |i: u8| u64::from(option_set.points()[usize::from(i)].cost);
                self.used = self.used - cost(before) + cost(entry.chosen);
            }
        }
        let (entries, option_sets, next_key) = (&self.entries, &self.option_sets, &self.next_key);
        let in_span = |c: &&u32| next_key[**c as usize] >= span.least;
        let end = span.find(|each| {
            for character in self.looked_at.iter().filter(in_span) {
                let entry = &entries[*character as usize];
                let upgrades =
                    entry.upgrades(&option_sets[entry.option_set as usize], entry.chosen);
                let within = upgrades.take_while(|u| u.0 >= span.least);
                within.for_each(|(key, cost)| each(key, cost));
            }
        });
        self.settle(end);
    }

    /// Finds the characters that changed, or have an upgrade on the wrong side of the span or in
    /// it.
    fn look_for(&mut self, span: Span) {
        self.looked_at.clear();
        let near = |next: u32, last: u32| (next >= span.least) | (last <= span.greatest);
        let (next, next_rest) = self.next_key.as_chunks::<ROW>();
        let (last, last_rest) = self.last_key.as_chunks::<ROW>();
        let mut note = |from: usize, next: &[u32], last: &[u32]| {
            let pairs = (from as u32..).zip(next.iter().zip(last));
            let found = pairs.filter(|(_, (next, last))| near(**next, **last));
            self.looked_at.extend(found.map(|(character, _)| character));
        };
        for (row, (next, last)) in next.iter().zip(last).enumerate() {
            let any = (0..ROW).fold(false, |any, l| any | near(next[l], last[l]));
            if any {
                note(row * ROW, next, last);
            }
        }
        note(next.len() * ROW, next_rest, last_rest);
    }

    /// Takes the upgrades above the break, and of those on it the first that fit, in the order of
    /// characters.
    fn settle(&mut self, mut end: Break) {
        for k in 0..self.looked_at.len() {
            let character = self.looked_at[k] as usize;
            if self.next_key[character] < end.key {
                self.show(character);
                continue;
            }
            let (entry, option_set) =
                entry_and_options(&mut self.entries, &self.option_sets, character);
            let mut chosen = entry.chosen;
            for (key, cost) in entry.upgrades(option_set, entry.chosen) {
                let cost = u64::from(cost);
                if key == end.key && cost <= end.room {
                    end.room -= cost;
                } else if key == end.key {
                    // Nothing after the first that does not fit, so that a larger budget never
                    // takes an upgrade back.
                    end.room = 0;
                    break;
                } else if key < end.key {
                    break;
                }
                self.used += cost;
                chosen += 1;
            }
            entry.chosen = chosen;
            self.show(character);
        }
    }

    /// Updates everything that follows from a character's choice.
    fn show(&mut self, character: usize) {
        let entry = &mut self.entries[character];
        let (mut now, mut error) = (NOTHING, 0.0);
        (self.next_key[character], self.last_key[character]) = (0, TOUCHED);
        if entry.visible {
            let option_set = &self.option_sets[entry.option_set as usize];
            let point = &option_set.points()[usize::from(entry.chosen)];
            (now, error) = (point.option, point.error_metres);
            self.next_key[character] = entry.next_key(option_set);
            if let Some(i) = entry.chosen.checked_sub(1) {
                self.last_key[character] = entry.key(i, &option_set.steps()[usize::from(i)]);
            }
        }
        let starved = entry.visible && entry.chosen < entry.target;
        match (entry.starved, starved) {
            _ if entry.turn => {}
            (true, false) => {
                (entry.turn, entry.turn_since) = (true, self.frame);
                self.newly_served.push(character as u32);
            }
            (false, true) => entry.waits_since = self.frame,
            _ => {}
        }
        entry.starved = starved;
        self.error_metres[character] = error;
        let before = std::mem::replace(&mut self.shown[character], now);
        if before != now {
            if let Some(option) = option(before) {
                self.per_option[usize::from(option)] -= 1;
            }
            if let Some(option) = option(now) {
                self.per_option[usize::from(option)] += 1;
            }
            self.changes.push(OptionChange {
                character: character as u32,
                from: option(before),
                to: option(now),
            });
        }
    }

    fn report(&self, budget: u64) -> AllocationReport {
        let (worst_px, sum, above_cap) = survey(
            &self.error_metres,
            &self.pixels_per_metre,
            self.policy.cap_px,
        );
        AllocationReport {
            budget: from_fixed(budget),
            used: from_fixed(self.used),
            demand: from_fixed(self.demand),
            visible: self.visible,
            above_cap,
            worst_px,
            mean_px: (sum / self.visible.max(1) as f64) as f32,
            changes: self.changes.len(),
        }
    }
}

fn entry_and_options<'a>(
    entries: &'a mut [CharacterEntry],
    option_sets: &'a [LodOptionSet],
    character: usize,
) -> (&'a mut CharacterEntry, &'a LodOptionSet) {
    let entry = &mut entries[character];
    let option_set = &option_sets[entry.option_set as usize];
    (entry, option_set)
}

fn option(shown: u8) -> Option<u8> {
    (shown != NOTHING).then_some(shown)
}
