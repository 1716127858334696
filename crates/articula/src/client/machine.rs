//! The client: bytes and times in, requests and poses out.

use super::character::ClientCharacter;
use super::message::SessionDecision;
use super::pace::Pace;
use super::plan::DeliveryPlan;
use super::planner::{Increment, Planner, flat_form};
use super::report::CharacterReport;
use super::transfers::Transfers;
use crate::error::{Context as _, Error, Result};
use crate::item::{AdaptOptions, Item, ItemReceiver, decide};
use crate::open::OpenOptions;
use articula_stream::decide::FrameTimeSwitch;
use articula_stream::description::Context;
use std::collections::BTreeMap;

/// Pause after a request that failed, seconds; twice as long after each further one, up to the longest.
pub(super) const PAUSE_SECS: f64 = 0.25;
/// Faults of the bytes of one character after which it is given up.
const MOST_FAULTS: u32 = 8;
/// Levels of articulation that slow frames are left with, at least.
const MOST_ARTICULATION: usize = 6;

/// Options of a [`Client`].
#[derive(Debug, Clone)]
pub struct ClientOptions {
    /// How characters are opened.
    pub open: OpenOptions,
    /// Options of decisions.
    pub adapt: AdaptOptions,
    /// Requests for bytes that are under way at once.
    pub requests: usize,
}

impl Default for ClientOptions {
    /// Four requests at once.
    fn default() -> Self {
        Self {
            open: OpenOptions::default(),
            adapt: AdaptOptions::default(),
            requests: 4,
        }
    }
}

/// A request under way.
#[derive(Debug)]
pub(super) enum Asked {
    Manifest(usize),
    /// Bytes, and when they were asked for.
    Increment(Increment, f64),
}

/// A client of a server of characters, over HTTP requests or in a session: a state machine without sockets,
/// clocks or threads.
///
/// ```text
/// over HTTP:    next_request ─▶ (the caller fetches) ─▶ answer
/// in a session: hello, update, shown ─▶ (the caller sends); (the caller receives) ─▶ take ─▶ messages to send
/// each frame:   frame ─▶ character: figure, player with its pose, report
/// ```
///
/// Times are seconds on one clock of the caller. After a connection was lost, [`Client::hello`] begins another
/// session, and what is here stays.
#[derive(Debug)]
pub struct Client {
    pub(super) options: ClientOptions,
    pub(super) context: Context,
    pub(super) planner: Planner,
    pub(super) characters: Vec<ClientCharacter>,
    pub(super) transfers: Transfers,
    pub(super) pace: Pace,
    pub(super) asked: BTreeMap<u64, Asked>,
    /// Manifests that arrived while bytes of the stage before are under way.
    pub(super) stages: BTreeMap<usize, (Vec<u8>, bool)>,
    pub(super) next_id: u64,
    pub(super) resume_secs: f64,
    pub(super) pause_secs: f64,
    pub(super) faults: BTreeMap<usize, u32>,
    /// Decides by the times of frames.
    pub(super) articulation: Option<FrameTimeSwitch>,
    pub(super) articulation_level: usize,
    pub(super) session: Session,
}

/// State of a session.
#[derive(Debug, Default)]
pub(super) struct Session {
    /// When the last update was sent; `None` before the hello.
    pub(super) updated_secs: Option<f64>,
    /// Whether something changed since.
    pub(super) is_changed: bool,
    pub(super) last_arrival_secs: f64,
    /// Whether the server has begun to send, and has not said that this was all.
    pub(super) is_owed: bool,
    pub(super) decisions: BTreeMap<usize, SessionDecision>,
    /// The manifests for which the server knows what is held.
    pub(super) held: BTreeMap<usize, String>,
}

impl Client {
    /// Creates a client without characters, in a context.
    ///
    /// # Errors
    /// An [`Error`] that names a value of the context out of its bounds.
    pub fn new(context: &Context, options: &ClientOptions) -> Result<Self> {
        context.check()?;
        let mut made = Self {
            options: options.clone(),
            context: Context::default(),
            planner: Planner::default(),
            characters: Vec::new(),
            transfers: Transfers::default(),
            pace: Pace::unbounded(),
            asked: BTreeMap::new(),
            stages: BTreeMap::new(),
            next_id: 0,
            resume_secs: f64::NEG_INFINITY,
            pause_secs: PAUSE_SECS,
            faults: BTreeMap::new(),
            articulation: None,
            articulation_level: 0,
            session: Session::default(),
        };
        made.set_context(context, 0.0)?;
        Ok(made)
    }

    /// Adds a character by its name at the server; returns its number.
    pub fn add(&mut self, name: &str) -> usize {
        self.characters.push(ClientCharacter::new(name));
        self.session.is_changed = true;
        self.characters.len() - 1
    }

    /// Returns a character.
    pub fn character(&self, character: usize) -> Option<&ClientCharacter> {
        self.characters.get(character)
    }

    /// Returns the context.
    pub fn context(&self) -> &Context {
        &self.context
    }

    /// Changes network, device, wishes or view. A bandwidth of the context bounds what is asked for; without
    /// one, only the measured one does.
    ///
    /// # Errors
    /// An [`Error`] that names a value of the context out of its bounds, or a character that gets nothing in
    /// it; the context is changed nevertheless.
    pub fn set_context(&mut self, context: &Context, now_secs: f64) -> Result<()> {
        context.check()?;
        self.context = context.clone();
        self.pace.set(context.network.usable_bps(), now_secs);
        let budget_ns = context.terminal.frame_budget_ms.map(|ms| 1e6 * ms);
        self.articulation = budget_ns.map(|ns| FrameTimeSwitch::new(ns, MOST_ARTICULATION));
        self.articulation_level = 0;
        self.session.is_changed = true;
        self.planner.begin_anew();
        let mut planned = Ok(());
        for character in 0..self.characters.len() {
            planned = planned.and(self.plan_again(character));
        }
        planned
    }

    /// Sets how much a character matters, relative to others, and how far it is from the camera.
    ///
    /// # Errors
    /// As [`Self::set_context`].
    pub fn set_view(
        &mut self,
        character: usize,
        importance: f64,
        distance_m: Option<f64>,
    ) -> Result<()> {
        let Some(of) = self.characters.get_mut(character) else {
            return Err(Error::argument("there is no such character"));
        };
        of.importance = importance;
        let is_moved = of.distance_m != distance_m;
        of.distance_m = distance_m;
        self.session.is_changed = true;
        self.planner.weigh(character, importance);
        match is_moved {
            true => self.plan_again(character),
            false => Ok(()),
        }
    }

    /// Plays another motion of a character, from its beginning; the first one without a name that it has.
    pub fn play(&mut self, character: usize, clip: Option<&str>, now_secs: f64) {
        self.play_from(character, clip, 0.0, now_secs);
    }

    /// Plays another motion of a character from a time within it on, such as where another device has left it.
    pub fn play_from(
        &mut self,
        character: usize,
        clip: Option<&str>,
        from_secs: f64,
        now_secs: f64,
    ) {
        if let Some(of) = self.characters.get_mut(character) {
            of.play(clip, from_secs);
            self.planner.play(character, clip, from_secs, now_secs);
            self.session.is_changed = true;
        }
    }

    /// Moves time on by a step: shows what has arrived, and plays.
    ///
    /// # Errors
    /// An [`Error`] that names the file that is malformed.
    pub fn frame(&mut self, now_secs: f64, dt_secs: f64) -> Result<()> {
        for (number, character) in self.characters.iter_mut().enumerate() {
            let plan = self.planner.plan(number);
            let shown = character.frame(plan, now_secs, dt_secs, self.articulation_level);
            shown.with_context(|| character.name.clone())?;
            let (clip, secs) = (character.clip.as_deref(), character.position_secs());
            self.planner.play(number, clip, secs, now_secs);
        }
        Ok(())
    }

    /// Tells how long the device took for a frame: beyond the budget of the context fewer joints move, from the
    /// finest level of articulation down.
    pub fn frame_took(&mut self, now_secs: f64, ns: f64) {
        if let Some(switch) = &mut self.articulation {
            self.articulation_level = MOST_ARTICULATION - switch.update(now_secs, ns);
        }
    }

    /// Returns what is shown of a character, in numbers.
    pub fn report(&self, character: usize) -> CharacterReport {
        let of = self.characters.get(character);
        let mut report = of.map(ClientCharacter::report).unwrap_or_default();
        if let Some(plan) = self.planner.plan(character) {
            report.target = plan.target();
        }
        if let Some(decision) = self.session.decisions.get(&character) {
            report.target = decision.level;
        }
        report
    }

    /// Returns the measured bandwidth, bits per second.
    pub fn measured_bps(&self) -> f64 {
        self.transfers.bits_per_second()
    }

    /// Whether all characters are there as far as the context asks for them.
    pub fn is_complete(&self) -> bool {
        (0..self.characters.len()).all(|character| self.report(character).is_complete)
    }

    /// Bits per second that are reckoned with.
    pub(super) fn bandwidth(&self) -> f64 {
        let measured = self.transfers.bits_per_second();
        self.context
            .network
            .usable_bps()
            .map_or(measured, |allowed| allowed.min(measured))
    }

    fn context_of(&self, character: usize) -> Context {
        let mut context = self.context.clone();
        if let Some(distance) = self.characters[character].distance_m {
            context.view.distance_m = Some(distance);
        }
        context
    }

    pub(super) fn take_manifest(
        &mut self,
        number: usize,
        hash: String,
        bytes: &[u8],
        is_whole: bool,
    ) -> Result<()> {
        let of = &mut self.characters[number];
        let receiver = match &of.receiver {
            None => ItemReceiver::new(bytes, &self.options.open),
            Some(before) => before.renewed(bytes),
        };
        of.receiver = Some(receiver.with_context(|| of.name.clone())?);
        of.manifest = hash;
        of.set_whole(is_whole);
        of.note_stage();
        self.plan(number)
    }

    /// Plans a character anew from its manifest.
    fn plan(&mut self, number: usize) -> Result<()> {
        let context = self.context_of(number);
        let of = &self.characters[number];
        let Some(receiver) = &of.receiver else {
            return Ok(());
        };
        let (manifest, held) = (receiver.manifest(), receiver.held());
        // Until a plan is found.
        self.planner.pause(number);
        let options = &self.options.adapt;
        let plan = DeliveryPlan::new(manifest, &context, options);
        let flat = match of.figure() {
            // Who shows the figure goes on.
            Some(_) => None,
            None => {
                let decided = decide(&Item::elsewhere(manifest.clone()), &context, options);
                flat_form(manifest, &decided.with_context(|| of.name.clone())?)
            }
        };
        let plan = match (plan, &flat) {
            (Err(error), None) => return Err(error).with_context(|| of.name.clone()),
            (plan, _) => plan.ok(),
        };
        let clip = of.clip.as_deref();
        self.planner.set(number, (plan.as_ref(), flat), &held, clip);
        self.planner.weigh(number, of.importance);
        self.characters[number].note_plan();
        Ok(())
    }

    /// Plans a character anew after a change of the context.
    fn plan_again(&mut self, number: usize) -> Result<()> {
        let Some(receiver) = &self.characters[number].receiver else {
            return Ok(());
        };
        let context = self.context_of(number);
        match DeliveryPlan::new(receiver.manifest(), &context, &self.options.adapt) {
            Ok(plan) if self.planner.plan(number).is_some() => {
                self.planner.set_plan(number, &plan);
                self.characters[number].note_plan();
                Ok(())
            }
            _ => self.plan(number),
        }
    }

    pub(super) fn take_bytes(
        &mut self,
        number: usize,
        file: &str,
        offset: u64,
        bytes: &[u8],
    ) -> Result<()> {
        let of = &mut self.characters[number];
        let Some(receiver) = &mut of.receiver else {
            return Ok(());
        };
        of.bytes += bytes.len() as u64;
        match receiver.receive(file, offset, bytes) {
            Ok(change) => of.note(&change),
            Err(error) => {
                let faults = self.faults.entry(number).or_default();
                *faults += 1;
                if *faults >= MOST_FAULTS {
                    return Err(error).with_context(|| of.name.clone());
                }
                of.note_plan();
                self.restore(number);
            }
        }
        Ok(())
    }

    /// Tells the planner what is there and under way, after something was not.
    pub(super) fn restore(&mut self, number: usize) {
        let receiver = self.characters[number].receiver.as_ref();
        let mut held = receiver.map(ItemReceiver::held).unwrap_or_default();
        for asked in self.asked.values() {
            if let Asked::Increment(of, _) = asked
                && of.character == number
            {
                held.add(&of.file, std::iter::once(of.range.clone()));
            }
        }
        self.planner.set_held(number, &held);
    }
}
