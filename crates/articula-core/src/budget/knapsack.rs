//! The choice for everyone: greedy by gain per cost, repaired from frame to frame.
//!
//! Source: `docs/methods/motion-lod.md` part 7. The plain form starts everyone at the cheapest option
//! and takes the upgrade with the greatest error drop per cost until the budget is used; its
//! total error differs from the least possible by at most one upgrade. Differs: no heap. The
//! taken upgrades are those above one key, which [`super::frontier`] finds; a repair gives
//! exactly what solving anew would, and looks at the characters that changed and at those whose
//! next or last upgrade lies near that key.

use super::character_entry::{ALARM, BudgetPolicy, CharacterEntry, EMPTY, LodRequest, Watch};
use super::frontier::{Break, Frontier, Span};
use super::lod_options::{LodOption, LodOptionSet, LodOptionSetId, from_fixed, to_fixed};
use super::report::{AllocationReport, OptionChange, survey};
use crate::Mismatch;

/// A key for characters that must be looked at in any case; no upgrade has it.
const TOUCHED: u32 = u32::MAX;
/// Characters that are tested at once.
const ROW: usize = 16;
/// No option: hidden.
const NOTHING: u8 = u8::MAX;

/// The choice for a fixed number of characters, all hidden at first.
///
/// Each frame: [`request`](Self::request) or [`hide`](Self::hide) for every character whose view
/// may have changed, then [`solve`](Self::solve).
#[derive(Debug, Clone)]
pub struct BudgetAllocator {
    policy: BudgetPolicy,
    option_sets: Vec<LodOptionSet>,
    entries: Vec<CharacterEntry>,
    watches: Vec<Watch>,
    /// Keys of the upgrade that each would take next and of the one it took last.
    next_key: Vec<u32>,
    last_key: Vec<u32>,
    /// What is shown now: error, scale, option.
    error_metres: Vec<f32>,
    pixels_per_metre: Vec<f32>,
    shown: Vec<u8>,
    frontier: Frontier,
    /// Cost of the cheapest options, of those chosen and of all that is wanted, fixed point.
    base: u64,
    used: u64,
    demand: u64,
    visible: usize,
    room: u64,
    stirred: bool,
    frame: u32,
    looked_at: Vec<u32>,
    /// Whose turn began in the frame before.
    newly_served: Vec<u32>,
    changes: Vec<OptionChange>,
    per_option: Vec<u32>,
}

impl BudgetAllocator {
    /// A budget for `characters` that are all hidden.
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

    /// Adds the options of a kind of character. Allocates: menus are made when things are put
    /// together.
    ///
    /// # Errors
    /// If there is none or more than 255, or a cost or an error is negative or not a number.
    pub fn add_options(&mut self, lod_options: &[LodOption]) -> Result<LodOptionSetId, Mismatch> {
        let id = LodOptionSetId(self.option_sets.len() as u32);
        self.option_sets.push(LodOptionSet::new(lod_options)?);
        let most = self.per_option.len().max(lod_options.len());
        self.per_option.resize(most, 0);
        Ok(id)
    }

    /// Says how a visible character stands in this frame. It is judged anew only if it was hidden,
    /// has another menu, or its scale changed by more than 10 % (its weight: by more than a
    /// third) since it was judged last; so its error may grow to a tenth above the cap before it is
    /// seen. O(1), does not allocate.
    ///
    /// # Panics
    /// If there is no such character, or the menu is of another budget with more menus.
    #[inline]
    pub fn request(&mut self, character: usize, request: LodRequest) {
        if self.watches[character].is_quiet(&request) {
            self.pixels_per_metre[character] = request.pixels_per_metre;
        } else {
            self.judge(character, &request.tamed());
        }
    }

    /// Says that nobody sees a character: it costs nothing and has no error.
    pub fn hide(&mut self, character: usize) {
        if self.entries[character].visible {
            self.retract(character);
            self.entries[character] = EMPTY;
            self.watches[character] = ALARM;
            self.touch(character);
        }
    }

    /// Has a character judged anew at its next request: its hold ended.
    pub fn requeue(&mut self, character: usize) {
        self.watches[character] = ALARM;
    }

    /// Replaces the policy; everyone is judged anew by it. O(characters), does not allocate.
    pub fn set_policy(&mut self, policy: BudgetPolicy) {
        self.policy = policy;
        self.rebuild();
    }

    /// Gives every option a new cost, by its menu and index. A cost that is no number makes the
    /// option too dear to be taken, a negative one free. Everyone is placed anew. O(characters + options), does not allocate.
    pub fn reprice(&mut self, mut cost: impl FnMut(LodOptionSetId, usize) -> f32) {
        for (id, option_set) in self.option_sets.iter_mut().enumerate() {
            option_set.reprice(|option| cost(LodOptionSetId(id as u32), option));
        }
        self.rebuild();
    }

    /// Chooses for everyone within `budget`, in the units of the menus; what is no number counts
    /// as 0. Does not allocate. Costs hardly more than the report if nothing changed.
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

    /// The option a character is shown with, by its index in the menu's offers; nothing if it is
    /// hidden.
    pub fn choice(&self, character: usize) -> Option<usize> {
        option(self.shown[character]).map(usize::from)
    }

    /// Who changed in the frame that was solved last, in the order of characters.
    pub fn changes(&self) -> &[OptionChange] {
        &self.changes
    }

    /// How many characters are shown with each option, by its index in the menus' offers.
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

    /// Takes a visible character's options out of all sums.
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

    /// Puts a visible character's options into all sums, itself at the cheapest.
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

    /// Looks at one block of characters, another one each frame, so that everyone comes up once in
    /// `patience_frames`: who waits gains weight, who was served long enough loses it again.
    fn age(&mut self) {
        let patience = self.policy.patience_frames as usize;
        if patience == 0 {
            self.newly_served.clear();
            return;
        }
        // Whose turn began is set apart at once, before those who wait overtake it.
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

    /// Finds where the room ends now and moves those characters across who stand on the wrong side.
    fn repair(&mut self) {
        let span = self.frontier.seek(self.room);
        self.look_for(span);
        for k in 0..self.looked_at.len() {
            let character = self.looked_at[k] as usize;
            let (entry, option_set) =
                entry_and_options(&mut self.entries, &self.option_sets, character);
            let before = entry.chosen;
            // Keys fall, but counting on costs less than guessing where they pass the span.
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

    /// Characters that changed, or have an upgrade on the wrong side of the span or in it.
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

    /// Takes what lies above the break, and of what lies on it the first that fit, by character.
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
                    // Nothing behind the first that does not fit, so that a larger budget never
                    // takes anything back.
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

    /// Writes down what follows from a character's choice.
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
