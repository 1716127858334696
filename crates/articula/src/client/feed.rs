//! The server's side of a session: messages of the client in, what to send next out.

use super::message::{
    ClientMessage, HeldFiles, SessionDecision, SessionStatistics, SessionUpdate, ShownReport,
    WantedCharacter,
};
use super::pace::Pace;
use super::plan::DeliveryPlan;
use super::planner::{Increment, Planner, flat_form};
use crate::error::{Error, Result};
use crate::item::{AdaptOptions, DecisionReport, Item, ItemBytes, Manifest, decide};
use articula_stream::description::Context;
use std::sync::Arc;

/// Bandwidth that is reckoned with before the client has measured it, bits per second.
const FIRST_BPS: f64 = 500e3;
/// Time between two messages with counters, seconds.
const STATISTICS_SECS: f64 = 1.0;

/// What a message of the client changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FeedChange {
    /// Other characters are wanted than before: each needs a manifest ([`Feed::set_manifest`]).
    Characters,
    /// A character needs another plan ([`Feed::set_plan`]).
    Plan(usize),
}

/// What a server does next.
#[derive(Debug, Clone, PartialEq)]
pub enum FeedNext {
    /// It sends bytes of the file of this number.
    Bytes(Increment, u16),
    /// It tells what was decided.
    Decision(SessionDecision),
    /// It tells that all that the context asks for of a character was sent.
    Complete(u16),
    /// It tells the counters.
    Statistics(SessionStatistics),
    /// It waits for a message, or until this time in seconds.
    Wait(f64),
}

/// What may be sent of a character in a context, with the reasons.
#[derive(Debug, Clone)]
pub struct FeedPlan {
    plan: Option<DeliveryPlan>,
    flat: Option<(String, u64)>,
    report: DecisionReport,
}

impl FeedPlan {
    /// Decides for a context with its bandwidth; `plan` is that of the item for the context without it, which
    /// sessions share.
    ///
    /// # Errors
    /// As [`decide`], and that of the plan if the context gets nothing in 2D either.
    pub fn new(
        plan: Result<DeliveryPlan>,
        manifest: &Manifest,
        context: &Context,
        options: &AdaptOptions,
    ) -> Result<Self> {
        let decided = decide(&Item::elsewhere(manifest.clone()), context, options)?;
        let flat = flat_form(manifest, &decided);
        let plan = match (plan, &flat) {
            (Err(error), None) => return Err(error),
            (plan, _) => plan.ok(),
        };
        Ok(Self {
            plan,
            flat,
            report: DecisionReport::of_decision(&decided),
        })
    }
}

/// A character of a session.
#[derive(Debug, Default)]
struct FeedCharacter {
    wanted: WantedCharacter,
    manifest: Option<Arc<Manifest>>,
    /// BLAKE3 of the manifest that was sent.
    hash: String,
    /// What the client has, once it has told so for this manifest.
    held: Option<ItemBytes>,
    plan: Option<FeedPlan>,
    /// The level that was told; `None` if another decision is to be told.
    told_level: Option<usize>,
    is_told_complete: bool,
}

/// The server's side of a session: a state machine without sockets or clocks. What was sent counts as held; after
/// a loss of the connection the client tells what it has.
#[derive(Debug)]
pub struct Feed {
    context: Context,
    measured_bps: Option<f64>,
    planner: Planner,
    pace: Pace,
    characters: Vec<FeedCharacter>,
    start_secs: f64,
    told_secs: f64,
    statistics: SessionStatistics,
    shown: ShownReport,
}

impl Feed {
    /// Begins a session with the first message of its client.
    ///
    /// # Errors
    /// An [`Error`] if that is no hello.
    pub fn new(hello: ClientMessage, now_secs: f64) -> Result<Self> {
        let ClientMessage::Hello(update) = hello else {
            return Err(Error::unsuited("the first message is no hello"));
        };
        let mut made = Self {
            context: Context::default(),
            measured_bps: None,
            planner: Planner::default(),
            pace: Pace::unbounded(),
            characters: Vec::new(),
            start_secs: now_secs,
            told_secs: now_secs,
            statistics: SessionStatistics::default(),
            shown: ShownReport::default(),
        };
        made.apply(update, now_secs);
        Ok(made)
    }

    /// Takes a message of the client; returns what is to be done.
    ///
    /// # Errors
    /// An [`Error`] for a second hello, and for what is about a character that is not wanted.
    pub fn take(&mut self, message: ClientMessage, now_secs: f64) -> Result<Vec<FeedChange>> {
        match message {
            ClientMessage::Hello(_) => Err(Error::unsuited("a second hello")),
            ClientMessage::Update(update) => Ok(self.apply(update, now_secs)),
            ClientMessage::Held(held) => self.take_held(&held, now_secs).map(|()| Vec::new()),
            ClientMessage::Shown(shown) => {
                self.shown = shown;
                Ok(Vec::new())
            }
        }
    }

    /// Returns the wanted characters, in the order of their numbers.
    pub fn characters(&self) -> impl Iterator<Item = &WantedCharacter> {
        self.characters.iter().map(|of| &of.wanted)
    }

    /// Returns the context of a character.
    pub fn context_of(&self, character: usize) -> Context {
        let mut context = self.context.clone();
        let of = self.characters.get(character);
        if let Some(distance) = of.and_then(|of| of.wanted.distance_m) {
            context.view.distance_m = Some(distance);
        }
        context
    }

    /// Returns what the client said last of what it shows.
    pub fn shown(&self) -> &ShownReport {
        &self.shown
    }

    /// Sets the manifest of a character, which the client is then told; returns whether the client has it
    /// already. Nothing of the character is sent until the client has told what it holds.
    pub fn set_manifest(&mut self, character: usize, manifest: &Arc<Manifest>, hash: &str) -> bool {
        let Some(of) = self.characters.get_mut(character) else {
            return false;
        };
        self.planner.remove(character);
        *of = FeedCharacter {
            wanted: std::mem::take(&mut of.wanted),
            manifest: Some(Arc::clone(manifest)),
            hash: hash.to_owned(),
            ..FeedCharacter::default()
        };
        of.wanted.manifest.as_deref() == Some(hash)
    }

    /// Sets what may be sent of a character.
    pub fn set_plan(&mut self, character: usize, plan: FeedPlan, now_secs: f64) {
        let Some(of) = self.characters.get_mut(character) else {
            return;
        };
        of.told_level = None;
        of.is_told_complete = false;
        let is_known = self.planner.plan(character).is_some();
        let layers = plan.plan.clone().filter(|_| is_known);
        of.plan = Some(plan);
        match layers {
            Some(layers) => self.planner.set_plan(character, &layers),
            None => self.begin(character, now_secs),
        }
    }

    /// Sends nothing of a character until it gets a plan: the context of the moment is refused.
    pub fn refuse_plan(&mut self, character: usize) {
        self.planner.pause(character);
        if let Some(of) = self.characters.get_mut(character) {
            of.plan = None;
        }
    }

    /// What comes next at a time.
    pub fn next(&mut self, now_secs: f64) -> FeedNext {
        if now_secs - self.told_secs >= STATISTICS_SECS {
            self.told_secs = now_secs;
            return FeedNext::Statistics(SessionStatistics {
                secs: now_secs - self.start_secs,
                bandwidth_bps: self.bandwidth(),
                ..self.statistics
            });
        }
        if let Some(told) = self.tell_next() {
            return told;
        }
        let tick = self.told_secs + STATISTICS_SECS;
        let ready = self.pace.ready_secs();
        if ready > now_secs {
            return FeedNext::Wait(ready.min(tick));
        }
        let bandwidth = self.bandwidth();
        let Some(increment) = self.planner.next(now_secs, bandwidth) else {
            // It may just have decided that this was all.
            return self.tell_next().unwrap_or(FeedNext::Wait(tick));
        };
        let bytes = increment.range.end - increment.range.start;
        self.pace.spend(bytes, now_secs);
        self.statistics.bytes += bytes;
        self.statistics.increments += 1;
        let manifest = self.characters[increment.character].manifest.as_ref();
        let mut files = manifest
            .into_iter()
            .flat_map(|manifest| manifest.files.keys());
        match files.position(|file| *file == increment.file) {
            Some(number) if number <= usize::from(u16::MAX) => {
                FeedNext::Bytes(increment, number as u16)
            }
            // A file without a hash: the plan of an item of the old form.
            _ => FeedNext::Wait(now_secs),
        }
    }

    /// What the client is still to be told.
    fn tell_next(&mut self) -> Option<FeedNext> {
        (0..self.characters.len()).find_map(|character| self.tell(character))
    }

    /// What the client is still to be told of a character.
    fn tell(&mut self, character: usize) -> Option<FeedNext> {
        let is_over = self.planner.is_over(character);
        let plan = self.planner.plan(character);
        let (level, levels) = plan.map_or((0, 0), |plan| (plan.target(), plan.levels()));
        let of = &mut self.characters[character];
        of.held.as_ref()?;
        let report = &of.plan.as_ref()?.report;
        let number = u16::try_from(character).unwrap_or(u16::MAX);
        if of.told_level != Some(level) {
            of.told_level = Some(level);
            let decision = SessionDecision::new(number, [level, levels], report);
            return Some(FeedNext::Decision(decision));
        }
        if is_over != of.is_told_complete {
            of.is_told_complete = is_over;
            return is_over.then_some(FeedNext::Complete(number));
        }
        None
    }

    fn apply(&mut self, update: SessionUpdate, now_secs: f64) -> Vec<FeedChange> {
        let mut changes = Vec::new();
        let mut plans = vec![false; self.characters.len()];
        if let Some(context) = update.context.filter(|context| *context != self.context) {
            self.pace.set(context.network.usable_bps(), now_secs);
            self.context = context;
            self.planner.begin_anew();
            plans.fill(true);
        }
        self.measured_bps = update.measured_bps.or(self.measured_bps);
        if let Some(wanted) = update.characters {
            let names = |of: &[WantedCharacter]| -> Vec<String> {
                of.iter().map(|of| of.name.clone()).collect()
            };
            let known: Vec<WantedCharacter> = self.characters().cloned().collect();
            if names(&known) != names(&wanted) {
                changes.push(FeedChange::Characters);
                (0..known.len()).for_each(|character| self.planner.remove(character));
                self.characters.clear();
                let of = |wanted| FeedCharacter {
                    wanted,
                    ..FeedCharacter::default()
                };
                self.characters.extend(wanted.into_iter().map(of));
                return changes;
            }
            for (character, wanted) in wanted.into_iter().enumerate() {
                plans[character] |= wanted.distance_m != known[character].distance_m;
                self.characters[character].wanted = wanted;
                self.place(character, now_secs);
            }
        }
        let plans = plans.iter().enumerate().filter(|(_, changed)| **changed);
        changes.extend(plans.map(|(character, _)| FeedChange::Plan(character)));
        changes
    }

    fn take_held(&mut self, held: &HeldFiles, now_secs: f64) -> Result<()> {
        let character = usize::from(held.character);
        let unknown = || Error::unsuited("bytes held of a character that is not wanted");
        let of = self.characters.get_mut(character).ok_or_else(unknown)?;
        if held.manifest != of.hash {
            // It is of the stage before; that of this one comes.
            return Ok(());
        }
        let bytes = held.bytes();
        let is_known = of.held.replace(bytes.clone()).is_some();
        match is_known && self.planner.plan(character).is_some() {
            true => self.planner.set_held(character, &bytes),
            false => self.begin(character, now_secs),
        }
        Ok(())
    }

    /// Begins to send a character once its plan is there, and what the client holds is known.
    fn begin(&mut self, character: usize, now_secs: f64) {
        let of = &self.characters[character];
        if let (Some(plan), Some(held)) = (&of.plan, &of.held) {
            let sent = (plan.plan.as_ref(), plan.flat.clone());
            let clip = of.wanted.clip.as_deref();
            self.planner.set(character, sent, held, clip);
            self.place(character, now_secs);
        }
    }

    fn place(&mut self, character: usize, now_secs: f64) {
        let wanted = &self.characters[character].wanted;
        let importance = wanted.importance.unwrap_or(1.0);
        let (clip, secs) = (wanted.clip.as_deref(), wanted.position_secs.unwrap_or(0.0));
        self.planner.play(character, clip, secs, now_secs);
        self.planner.weigh(character, importance);
    }

    /// Bits per second that are reckoned with: what the context allows of what the client measures.
    fn bandwidth(&self) -> f64 {
        let measured = self.measured_bps;
        match (self.context.network.usable_bps(), measured) {
            (Some(allowed), _) => allowed,
            (None, Some(measured)) => measured,
            (None, None) => FIRST_BPS,
        }
    }
}
