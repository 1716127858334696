//! The client: bytes and times in, requests and poses out.

use super::character::ClientCharacter;
use super::message::{
    ClientMessage, HeldFiles, SESSION_VERSION, ServerMessage, SessionDecision, SessionUpdate,
    ShownReport, WantedCharacter,
};
use super::pace::Pace;
use super::plan::DeliveryPlan;
use super::planner::{Increment, Planner, flat_form};
use super::report::CharacterReport;
use crate::error::{Context as _, Error, Result};
use crate::item::{AdaptOptions, ItemReceiver, decompressed};
use crate::open::OpenOptions;
use articula_stream::decide::{FrameTimeSwitch, ThroughputEstimator, ThroughputOptions, Transfer};
use articula_stream::description::Context;
use std::collections::BTreeMap;

/// Pause after a request that failed, seconds; twice as long after each further one, up to the longest.
const PAUSE_SECS: f64 = 0.25;
const LONGEST_PAUSE_SECS: f64 = 8.0;
/// Faults of the bytes of one character after which it is given up.
const MOST_FAULTS: u32 = 8;
/// Longest pause within one transfer of a session, seconds.
const TRANSFER_PAUSE_SECS: f64 = 0.05;
/// Shortest transfer that is told apart: a short body comes together with its head, at no rate at all.
const LEAST_TRANSFER_SECS: f64 = 1e-3;
/// Time between two updates of a session, seconds.
const UPDATE_SECS: f64 = 1.0;
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

/// What a client asks for over HTTP (`docs/formats/delivery.md`).
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ClientRequest {
    /// The manifest of a character.
    Manifest {
        /// Name of the character.
        name: String,
        /// BLAKE3 of the manifest that is here: the answer may wait for another one.
        known: Option<String>,
    },
    /// Bytes of an object.
    Bytes {
        /// Its name, the BLAKE3 of the file.
        object: String,
        /// Which bytes of which file of which character these are. All bytes of a file are asked for without a
        /// range, so that they may travel compressed.
        increment: Increment,
    },
}

/// What came of a request.
#[derive(Debug, Clone, PartialEq)]
pub enum ClientAnswer {
    /// A manifest.
    Manifest {
        /// Its bytes.
        bytes: Vec<u8>,
        /// Whether the server has made all of the character.
        is_whole: bool,
    },
    /// There is no other manifest, or none yet.
    Unchanged {
        /// Whether the server has made all of the character.
        is_whole: bool,
    },
    /// The bytes that were asked for, not compressed.
    Bytes {
        /// The bytes.
        bytes: Vec<u8>,
        /// The transfer of the body as it was sent.
        transfer: Transfer,
    },
    /// Nothing came; the request is made again after a pause.
    Failed,
}

/// A request under way.
#[derive(Debug)]
enum Asked {
    Manifest(usize),
    Increment(Increment),
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
    options: ClientOptions,
    context: Context,
    planner: Planner,
    characters: Vec<ClientCharacter>,
    throughput: ThroughputEstimator,
    pace: Pace,
    asked: BTreeMap<u64, Asked>,
    /// Manifests that arrived while bytes of the stage before are under way.
    stages: BTreeMap<usize, (Vec<u8>, bool)>,
    next_id: u64,
    resume_secs: f64,
    pause_secs: f64,
    faults: BTreeMap<usize, u32>,
    /// Decides by the times of frames.
    articulation: Option<FrameTimeSwitch>,
    articulation_level: usize,
    session: Session,
}

/// State of a session.
#[derive(Debug, Default)]
struct Session {
    /// When the last update was sent; `None` before the hello.
    updated_secs: Option<f64>,
    /// Whether something changed since.
    is_changed: bool,
    last_arrival_secs: f64,
    decisions: BTreeMap<usize, SessionDecision>,
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
            throughput: ThroughputEstimator::new(ThroughputOptions::default()),
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
        if let Some(of) = self.characters.get_mut(character) {
            of.play(clip);
            self.planner.play(character, clip, 0.0, now_secs);
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
        let mut report = of
            .map(|of| of.report(self.planner.plan(character)))
            .unwrap_or_default();
        if let Some(decision) = self.session.decisions.get(&character) {
            report.target = decision.level;
        }
        report
    }

    /// Returns the measured bandwidth, bits per second.
    pub fn measured_bps(&self) -> f64 {
        self.throughput.bits_per_second()
    }

    /// Whether all characters are there as far as the context asks for them.
    pub fn is_complete(&self) -> bool {
        (0..self.characters.len()).all(|character| self.report(character).is_complete)
    }

    // Over HTTP.

    /// Returns the next request, with a number for its answer; `None` if there is nothing to ask for now. It
    /// is called until then, and again after each answer and each frame.
    pub fn next_request(&mut self, now_secs: f64) -> Option<(u64, ClientRequest)> {
        if now_secs < self.resume_secs {
            return None;
        }
        let waits = |number: &usize| {
            !self
                .asked
                .values()
                .any(|asked| matches!(asked, Asked::Manifest(n) if n == number))
        };
        let mut lacking = (0..self.characters.len())
            .filter(|n| !self.characters[*n].is_whole && !self.stages.contains_key(n));
        if let Some(number) = lacking.find(waits) {
            let of = &self.characters[number];
            let request = ClientRequest::Manifest {
                name: of.name.clone(),
                known: of.receiver.as_ref().map(|_| of.manifest.clone()),
            };
            return Some((self.ask(Asked::Manifest(number)), request));
        }
        let under_way = self.asked.values();
        let bytes = under_way.filter(|asked| matches!(asked, Asked::Increment(_)));
        let is_busy = bytes.count() >= self.options.requests.max(1);
        if is_busy || !self.stages.is_empty() || now_secs < self.pace.ready_secs() {
            return None;
        }
        let bandwidth = self.bandwidth();
        let increment = self.planner.next(now_secs, bandwidth)?;
        let files = &self.characters[increment.character]
            .receiver
            .as_ref()?
            .manifest()
            .files;
        let object = files.get(&increment.file)?.hash.clone();
        let request = ClientRequest::Bytes {
            object,
            increment: increment.clone(),
        };
        self.pace
            .spend(increment.range.end - increment.range.start, now_secs);
        Some((self.ask(Asked::Increment(increment)), request))
    }

    /// Takes what came of a request. A number that is unknown, as of a request that was made twice, is left
    /// out.
    ///
    /// # Errors
    /// An [`Error`] that names the character: a malformed manifest, one that gets nothing in this context,
    /// bytes that are damaged again and again.
    pub fn answer(&mut self, id: u64, answer: ClientAnswer, now_secs: f64) -> Result<()> {
        let Some(asked) = self.asked.remove(&id) else {
            return Ok(());
        };
        if answer != ClientAnswer::Failed {
            self.pause_secs = PAUSE_SECS;
        }
        match (asked, answer) {
            (Asked::Manifest(number), ClientAnswer::Manifest { bytes, is_whole }) => {
                self.stages.insert(number, (bytes, is_whole));
                self.take_stages()
            }
            (Asked::Manifest(number), ClientAnswer::Unchanged { is_whole }) => {
                let of = &mut self.characters[number];
                of.is_whole = is_whole && of.receiver.is_some();
                if of.receiver.is_none() {
                    self.pause(now_secs);
                }
                Ok(())
            }
            (Asked::Increment(increment), ClientAnswer::Bytes { bytes, transfer }) => {
                self.throughput.add(Transfer {
                    first_byte_secs: transfer
                        .first_byte_secs
                        .min(transfer.last_byte_secs - LEAST_TRANSFER_SECS),
                    ..transfer
                });
                let (number, file) = (increment.character, &increment.file);
                self.take_bytes(number, file, increment.range.start, &bytes)?;
                self.take_stages()
            }
            (Asked::Increment(increment), _) => {
                self.restore(increment.character);
                self.pause(now_secs);
                self.take_stages()
            }
            (Asked::Manifest(_), _) => {
                self.pause(now_secs);
                Ok(())
            }
        }
    }

    // In a session.

    /// Begins a session: returns the first message to send. What was under way is given up.
    pub fn hello(&mut self, now_secs: f64) -> ClientMessage {
        self.session = Session {
            updated_secs: Some(now_secs),
            last_arrival_secs: now_secs,
            ..Session::default()
        };
        self.asked.clear();
        self.stages.clear();
        let update = SessionUpdate {
            version: SESSION_VERSION,
            ..self.state()
        };
        ClientMessage::Hello(update)
    }

    /// Returns what has changed since the last message, or the measured bandwidth and the positions once a
    /// second; `None` if there is nothing to tell.
    pub fn update(&mut self, now_secs: f64) -> Option<ClientMessage> {
        let last = self.session.updated_secs?;
        if !self.session.is_changed && now_secs - last < UPDATE_SECS {
            return None;
        }
        let mut update = self.state();
        if !self.session.is_changed {
            update.context = None;
        }
        self.session.updated_secs = Some(now_secs);
        self.session.is_changed = false;
        Some(ClientMessage::Update(update))
    }

    /// Returns a message about what is shown.
    pub fn shown(&self, fps: f64, frame_ms: f64) -> ClientMessage {
        let players = self.characters.iter().filter_map(ClientCharacter::player);
        let joints: usize = players.map(|player| player.report().sampled.len()).sum();
        ClientMessage::Shown(ShownReport {
            fps,
            frame_ms,
            joints: joints as u64,
            stalls: self.characters.iter().map(|of| of.stalls).sum(),
        })
    }

    /// Takes a message of the server; returns what is to be answered.
    ///
    /// # Errors
    /// As [`Self::answer`]; what the server says is wrong.
    pub fn take(&mut self, message: ServerMessage, now_secs: f64) -> Result<Option<ClientMessage>> {
        match message {
            ServerMessage::Manifest {
                character,
                is_whole,
                hash,
                bytes,
            } => {
                let number = self.known(character)?;
                let hash = blake3::Hash::from_bytes(hash).to_hex().to_string();
                if bytes.is_empty() {
                    self.characters[number].is_whole = is_whole;
                } else {
                    let most = self.options.open.limits.bytes;
                    let manifest = decompressed(&bytes, most).context("manifest")?;
                    if blake3::hash(&manifest).to_hex().as_str() != hash {
                        return Err(Error::unsuited("manifest: its hash is another one"));
                    }
                    self.take_manifest(number, hash, &manifest, is_whole)?;
                }
                let of = &self.characters[number];
                let held = of
                    .receiver
                    .as_ref()
                    .map(ItemReceiver::held)
                    .unwrap_or_default();
                let held = HeldFiles::of(character, of.manifest.clone(), &held);
                Ok(Some(ClientMessage::Held(held)))
            }
            ServerMessage::Bytes {
                character,
                file,
                offset,
                is_compressed,
                bytes,
            } => {
                let number = self.known(character)?;
                self.measure(bytes.len() as u64, now_secs);
                let receiver = self.characters[number].receiver.as_ref();
                let mut files = receiver.into_iter().flat_map(|r| &r.manifest().files);
                let unknown = || Error::unsuited("bytes of a file that the item does not have");
                let (name, entry) = files.nth(usize::from(file)).ok_or_else(unknown)?;
                let (name, most) = (name.clone(), entry.bytes);
                let bytes = match is_compressed {
                    true => decompressed(&bytes, most).with_context(|| name.clone())?,
                    false => bytes,
                };
                let faults = self.faults.get(&number).copied();
                self.take_bytes(number, &name, offset, &bytes)?;
                // The server sends again what it thinks is here.
                let is_fault = self.faults.get(&number).copied() != faults;
                Ok(is_fault.then(|| {
                    let of = &self.characters[number];
                    let held = of
                        .receiver
                        .as_ref()
                        .map(ItemReceiver::held)
                        .unwrap_or_default();
                    ClientMessage::Held(HeldFiles::of(character, of.manifest.clone(), &held))
                }))
            }
            ServerMessage::Decision(decision) => {
                let number = self.known(decision.character)?;
                self.session.decisions.insert(number, decision);
                Ok(None)
            }
            ServerMessage::Complete { .. } | ServerMessage::Statistics(_) => Ok(None),
            ServerMessage::Error(error) => Err(Error::unsuited(error.error)),
        }
    }

    /// Returns what the server decided last for a character.
    pub fn decision(&self, character: usize) -> Option<&SessionDecision> {
        self.session.decisions.get(&character)
    }

    fn known(&self, character: u16) -> Result<usize> {
        let number = usize::from(character);
        let unknown = || Error::unsuited("a message about a character that was not asked for");
        self.characters
            .get(number)
            .map(|_| number)
            .ok_or_else(unknown)
    }

    /// The state of the client for a message.
    fn state(&self) -> SessionUpdate {
        let characters = self.characters.iter().map(|of| WantedCharacter {
            name: of.name.clone(),
            importance: Some(of.importance),
            distance_m: of.distance_m,
            clip: of.clip.clone(),
            position_secs: Some(of.position_secs()),
            manifest: of.receiver.as_ref().map(|_| of.manifest.clone()),
        });
        SessionUpdate {
            version: 0,
            context: Some(self.context.clone()),
            measured_bps: Some(self.measured_bps()),
            characters: Some(characters.collect()),
        }
    }

    /// Measures the bandwidth by messages that follow each other.
    fn measure(&mut self, bytes: u64, now_secs: f64) {
        let last = std::mem::replace(&mut self.session.last_arrival_secs, now_secs);
        if now_secs - last <= TRANSFER_PAUSE_SECS {
            self.throughput.add(Transfer {
                bytes,
                first_byte_secs: last.min(now_secs - LEAST_TRANSFER_SECS),
                last_byte_secs: now_secs,
            });
        }
    }

    // Both.

    fn ask(&mut self, asked: Asked) -> u64 {
        self.next_id += 1;
        self.asked.insert(self.next_id, asked);
        self.next_id
    }

    fn pause(&mut self, now_secs: f64) {
        self.resume_secs = now_secs + self.pause_secs;
        self.pause_secs = (2.0 * self.pause_secs).min(LONGEST_PAUSE_SECS);
    }

    /// Bits per second that are reckoned with.
    fn bandwidth(&self) -> f64 {
        let measured = self.throughput.bits_per_second();
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

    fn take_manifest(
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
        of.is_whole = is_whole;
        of.note_stage();
        self.plan(number)
    }

    /// Goes on with manifests that arrived, of characters of which no bytes of the stage before are under way.
    fn take_stages(&mut self) -> Result<()> {
        let is_busy = |number: usize| {
            let mut asked = self.asked.values();
            asked.any(|asked| matches!(asked, Asked::Increment(of) if of.character == number))
        };
        let ready: Vec<usize> = self
            .stages
            .keys()
            .copied()
            .filter(|n| !is_busy(*n))
            .collect();
        for number in ready {
            if let Some((bytes, is_whole)) = self.stages.remove(&number) {
                let hash = blake3::hash(&bytes).to_hex().to_string();
                self.take_manifest(number, hash, &bytes, is_whole)?;
            }
        }
        Ok(())
    }

    /// Plans a character anew from its manifest.
    fn plan(&mut self, number: usize) -> Result<()> {
        let context = self.context_of(number);
        let of = &self.characters[number];
        let Some(receiver) = &of.receiver else {
            return Ok(());
        };
        let (manifest, held) = (receiver.manifest(), receiver.held());
        let options = &self.options.adapt;
        let plan = DeliveryPlan::new(manifest, &context, options);
        let flat = match of.figure() {
            // Who shows the figure goes on.
            Some(_) => None,
            None => flat_form(manifest, &context, options).with_context(|| of.name.clone())?,
        };
        let plan = match (plan, &flat) {
            (Err(error), None) => return Err(error).with_context(|| of.name.clone()),
            (plan, _) => plan.ok(),
        };
        let clip = of.clip.as_deref();
        self.planner.set(number, (plan.as_ref(), flat), &held, clip);
        self.planner.weigh(number, of.importance);
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

    fn take_bytes(&mut self, number: usize, file: &str, offset: u64, bytes: &[u8]) -> Result<()> {
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
    fn restore(&mut self, number: usize) {
        let receiver = self.characters[number].receiver.as_ref();
        let mut held = receiver.map(ItemReceiver::held).unwrap_or_default();
        for asked in self.asked.values() {
            if let Asked::Increment(of) = asked
                && of.character == number
            {
                held.add(&of.file, std::iter::once(of.range.clone()));
            }
        }
        self.planner.set_held(number, &held);
    }
}
