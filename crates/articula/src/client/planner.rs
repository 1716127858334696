//! What comes next of all characters of a client: one bandwidth, shared by importance.

use super::order::{CharacterPlan, Chunk};
use super::plan::DeliveryPlan;
use crate::item::{ItemBytes, ItemCut, ItemDecision, Manifest};
use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;

/// Least share of the importance that counts, so that nobody waits for ever.
const LEAST_IMPORTANCE: f64 = 1e-3;

/// Bytes of a file of a character that a client gets next.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Increment {
    /// Number of the character.
    pub character: usize,
    /// Name of the file in its item.
    pub file: String,
    /// The bytes.
    pub range: Range<u64>,
    /// Whether these are all bytes of the file, which then may travel compressed.
    pub is_whole: bool,
}

/// Decides what comes next: of all characters first the least that is shown, then what refines them, in turns
/// by importance. The server of a session and a client that fetches by itself decide by the same.
#[derive(Debug, Default)]
pub(super) struct Planner {
    characters: BTreeMap<usize, Entry>,
}

/// A character.
#[derive(Debug)]
struct Entry {
    plan: Option<CharacterPlan>,
    /// A form in 2D that comes before everything else.
    flat: VecDeque<Chunk>,
    importance: f64,
    /// Bytes that came, by importance: who has the fewest is next.
    served: f64,
    position: Position,
    /// Whether nothing comes for now, since the context of the moment is refused.
    is_paused: bool,
}

/// Where in its clip a character is.
#[derive(Debug, Clone, Copy, Default)]
struct Position {
    secs: f64,
    at_secs: f64,
}

impl Planner {
    /// Sets what may come of a character: the layers of a plan, and before them a form in 2D. `clip` is the
    /// motion that plays.
    pub(super) fn set(
        &mut self,
        character: usize,
        (plan, flat): (Option<&DeliveryPlan>, Option<(String, u64)>),
        held: &ItemBytes,
        clip: Option<&str>,
    ) {
        let flat = flat.into_iter().map(|(file, bytes)| Chunk {
            file,
            range: 0..bytes,
            is_whole: true,
        });
        let flat = flat.filter(|chunk| !held.has(&chunk.file, &chunk.range));
        let mut plan = plan.map(|plan| CharacterPlan::new(plan, held));
        if let Some(plan) = &mut plan {
            plan.play(clip);
        }
        let before = self.characters.remove(&character);
        // Who comes later begins where the others are.
        let least = self.least_served();
        let (importance, served, position) = match before {
            Some(before) => (before.importance, before.served, before.position),
            None => (1.0, least, Position::default()),
        };
        let entry = Entry {
            plan,
            flat: flat.collect(),
            importance,
            served,
            position,
            is_paused: false,
        };
        self.characters.insert(character, entry);
    }

    /// Changes the levels of quality of a character.
    pub(super) fn set_plan(&mut self, character: usize, plan: &DeliveryPlan) {
        let Some(entry) = self.characters.get_mut(&character) else {
            return;
        };
        entry.is_paused = false;
        if let Some(plan_of) = &mut entry.plan {
            plan_of.set_plan(plan);
        }
    }

    /// Sends nothing more of a character until it gets another plan. What was sent stays known.
    pub(super) fn pause(&mut self, character: usize) {
        if let Some(entry) = self.characters.get_mut(&character) {
            entry.is_paused = true;
        }
    }

    /// Tells what is there of a character after all.
    pub(super) fn set_held(&mut self, character: usize, held: &ItemBytes) {
        if let Some(plan) = self.plan_mut(character) {
            plan.set_held(held);
        }
    }

    /// Sets which motion of a character plays, and where in it a time is.
    pub(super) fn play(&mut self, character: usize, clip: Option<&str>, secs: f64, now_secs: f64) {
        let Some(entry) = self.characters.get_mut(&character) else {
            return;
        };
        let expected = entry.position.at(now_secs);
        entry.position = Position {
            secs,
            at_secs: now_secs,
        };
        if let Some(plan) = &mut entry.plan {
            plan.play(clip);
            // A jump, more than the clocks differ.
            if (expected - secs).abs() > 1.0 {
                plan.begin_anew();
            }
        }
    }

    /// Sets how much a character matters, relative to others; 1 at first.
    pub(super) fn weigh(&mut self, character: usize, importance: f64) {
        let least = self.least_served();
        let importance = match importance.is_finite() {
            true => importance.max(LEAST_IMPORTANCE),
            false => 1.0,
        };
        let entry = self.characters.get_mut(&character);
        if let Some(entry) = entry.filter(|entry| entry.importance != importance) {
            entry.importance = importance;
            // What was saved under another importance does not count.
            entry.served = entry.served.min(least);
        }
    }

    /// Leaves a character out.
    pub(super) fn remove(&mut self, character: usize) {
        self.characters.remove(&character);
    }

    /// Orders everything anew, as after a change of the bandwidth.
    pub(super) fn begin_anew(&mut self) {
        let plans = self.characters.values_mut();
        plans
            .filter_map(|entry| entry.plan.as_mut())
            .for_each(CharacterPlan::begin_anew);
    }

    /// The next bytes at a time, for a bandwidth; `None` if all that the context asks for is there or on the
    /// way.
    pub(super) fn next(&mut self, now_secs: f64, bits_per_second: f64) -> Option<Increment> {
        let all: f64 = self.characters.values().map(|entry| entry.importance).sum();
        loop {
            for entry in self.characters.values_mut() {
                let share = entry.importance / all.max(f64::MIN_POSITIVE);
                if let Some(plan) = &mut entry.plan {
                    let position = entry.position.at(now_secs);
                    plan.order(now_secs, position, share * bits_per_second);
                }
            }
            let waiting = self
                .characters
                .iter_mut()
                .filter(|(_, entry)| !entry.is_over());
            let (character, entry) = waiting.min_by(|(_, a), (_, b)| {
                let base = b.is_base_next().cmp(&a.is_base_next());
                base.then(a.served.total_cmp(&b.served))
            })?;
            // What was in its turn may be there; then there is another order.
            if let Some(chunk) = entry.next() {
                return Some(Increment {
                    character: *character,
                    file: chunk.file,
                    range: chunk.range,
                    is_whole: chunk.is_whole,
                });
            }
        }
    }

    /// Whether all that the context asks for of a character is there or on the way.
    pub(super) fn is_over(&self, character: usize) -> bool {
        self.characters.get(&character).is_none_or(Entry::is_over)
    }

    pub(super) fn plan(&self, character: usize) -> Option<&CharacterPlan> {
        self.characters.get(&character)?.plan.as_ref()
    }

    fn plan_mut(&mut self, character: usize) -> Option<&mut CharacterPlan> {
        self.characters.get_mut(&character)?.plan.as_mut()
    }

    fn least_served(&self) -> f64 {
        let served = self.characters.values().map(|entry| entry.served);
        served.reduce(f64::min).unwrap_or(0.0)
    }
}

impl Entry {
    fn is_over(&self) -> bool {
        self.is_paused
            || self.flat.is_empty() && self.plan.as_ref().is_none_or(CharacterPlan::is_over)
    }

    /// The next bytes, with those that go on where they end.
    fn next(&mut self) -> Option<Chunk> {
        let mut chunk = match (self.flat.pop_front(), &mut self.plan) {
            (Some(flat), _) => flat,
            (None, plan) => plan.as_mut()?.next()?,
        };
        if let Some(plan) = self.plan.as_mut().filter(|_| !chunk.is_whole) {
            while let Some(next) = plan.next_after(&chunk) {
                chunk.range.end = next.range.end;
            }
        }
        let bytes = (chunk.range.end - chunk.range.start) as f64;
        self.served += bytes / self.importance;
        Some(chunk)
    }

    fn is_base_next(&self) -> bool {
        let plan = self.plan.as_ref();
        !self.flat.is_empty() || plan.is_some_and(CharacterPlan::is_base_next)
    }
}

impl Position {
    fn at(self, now_secs: f64) -> f64 {
        self.secs + now_secs - self.at_secs
    }
}

/// The form in 2D that a client shows first, where its bandwidth does not carry the least in 3D in time, or
/// it asks for one: file and bytes.
pub(super) fn flat_form(manifest: &Manifest, decided: &ItemDecision) -> Option<(String, u64)> {
    let Some(ItemCut::Flat(form)) = decided.cut else {
        return None;
    };
    let form = manifest.flat.get(form)?;
    Some((form.file.clone(), form.bytes))
}
