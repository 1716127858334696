//! The loop that shows a character: what arrives, what is asked for, and a picture of each moment.

use super::captions::Captions;
use super::event::{Event, Key};
use super::fetch::Fetchers;
use super::link::Link;
use super::monitor::Sample;
use super::output::Output;
use super::phase::Phase;
use super::slider::Slider;
use crate::commands::server::Server;
use crate::fault::clean;
use anyhow::{Context as _, anyhow, bail};
use articula::Figure;
use articula::client::{Client, ClientAnswer, ClientCharacter};
use articula_report::{Artist, thread_ns};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::time::{Duration, Instant};

/// Pictures per second.
const FPS: f64 = 20.0;
/// Time without anything to show after which nothing is expected any more.
const WAIT: Duration = Duration::from_secs(60);
/// Time until a session that was lost is begun again, and how often that is tried in a row.
const PAUSE: Duration = Duration::from_millis(500);
const MOST_TRIES: u32 = 10;
/// Bandwidth from which keys move it, when it had no bound, bits per second.
const FIRST_BPS: f64 = 1e6;
/// Distance from which keys move it, metres.
const FIRST_DISTANCE_M: f64 = 3.5;

/// How the network is used.
enum Network {
    Http(Fetchers),
    Session {
        link: Link,
        /// When another session begins, after one was lost.
        again: Option<Instant>,
        tries: u32,
    },
}

/// What is shown.
pub(super) struct Show<'a> {
    pub(super) server: Server,
    pub(super) start: Instant,
    pub(super) client: Client,
    /// Whether the server decides, in a session.
    pub(super) is_session: bool,
    pub(super) slider: Option<&'a Slider>,
    /// Seconds to show from the first picture on; `None` until the user ends it.
    pub(super) seconds: Option<f64>,
    pub(super) has_monitor: bool,
}

/// What was shown.
#[derive(Debug)]
pub(super) struct Shown {
    pub(super) first_picture: Option<Instant>,
    pub(super) pictures: usize,
    /// A moment of each second, and each at which another level was there.
    pub(super) samples: Vec<Sample>,
    /// The times between two movements of the slider.
    pub(super) phases: Vec<Phase>,
}

/// What changes while it is shown.
struct State {
    shown: Shown,
    /// When the last picture was made.
    last: Instant,
    /// Time, bytes and pictures at the last sample.
    sampled: (Instant, u64, usize),
    captions: Option<Captions>,
    /// What the last picture showed.
    picture: Option<Sample>,
    /// Mean time of a picture, nanoseconds.
    frame_ns: f64,
    has_monitor: bool,
    is_over: bool,
}

impl Show<'_> {
    /// Shows until the end; `events` has what `sender` is given.
    pub(super) fn run(
        mut self,
        events: &Receiver<Event>,
        sender: &Sender<Event>,
        output: &mut Output<'_>,
    ) -> anyhow::Result<Shown> {
        let mut network = match self.is_session {
            true => Network::Session {
                link: Link::start(&self.server, self.client.hello(self.now()), sender),
                again: None,
                tries: 0,
            },
            false => Network::Http(Fetchers::start(&self.server, self.start, sender)),
        };
        let mut state = State {
            shown: Shown {
                first_picture: None,
                pictures: 0,
                samples: Vec::new(),
                phases: Vec::new(),
            },
            last: self.start,
            sampled: (self.start, 0, 0),
            captions: None,
            picture: None,
            frame_ns: 0.0,
            has_monitor: self.has_monitor,
            is_over: false,
        };
        while !state.is_over {
            // What is drawn of a figure is made once.
            let figure = self.client.character(0).and_then(|of| of.figure()).cloned();
            let version = self.client.character(0).map(|of| of.version());
            self.show_figure(
                figure.as_ref(),
                version,
                &mut state,
                (&mut network, events, sender),
                output,
            )?;
        }
        Ok(state.shown)
    }

    /// Shows one figure, until there is another one or the end.
    fn show_figure(
        &mut self,
        figure: Option<&Arc<Figure>>,
        version: Option<u64>,
        state: &mut State,
        (network, events, sender): (&mut Network, &Receiver<Event>, &Sender<Event>),
        output: &mut Output<'_>,
    ) -> anyhow::Result<()> {
        let size = output.size(state.has_monitor);
        let mut artist = figure.map(|figure| Artist::of_figure(figure, size));
        let has_monitor = state.has_monitor;
        while !state.is_over && state.has_monitor == has_monitor {
            self.slide(state)?;
            self.ask(network, sender);
            let began = thread_ns();
            let (now, dt) = (self.now(), state.last.elapsed().as_secs_f64());
            state.last = Instant::now();
            self.client.frame(now, dt)?;
            if self.client.character(0).map(|of| of.version()) != version {
                return Ok(());
            }
            if let Some(artist) = &mut artist {
                self.draw(artist, state, output, began)?;
            } else if self.start.elapsed() > WAIT {
                bail!("nothing to show has arrived in {} s", WAIT.as_secs());
            }
            self.listen(state, (network, events, sender))?;
        }
        Ok(())
    }

    /// Draws a picture, and takes a sample where it is time.
    fn draw(
        &mut self,
        artist: &mut Artist<'_>,
        state: &mut State,
        output: &mut Output<'_>,
        began: u64,
    ) -> anyhow::Result<()> {
        let player = self.client.character(0).and_then(|of| of.player());
        let player = player.context("a figure without a player")?;
        let morphs = player.morph_weights().to_vec();
        let picture = artist
            .figure(player.pose(), morphs)
            .context("the picture")?;
        let ns = thread_ns().saturating_sub(began) as f64;
        state.frame_ns += 0.1 * (ns - state.frame_ns);
        self.client.frame_took(self.now(), ns);
        let is_first = state.shown.first_picture.is_none();
        let first = *state.shown.first_picture.get_or_insert_with(Instant::now);
        let mut sample = Sample::of(&self.client);
        let before = state.shown.samples.last();
        let elapsed = state.sampled.0.elapsed().as_secs_f64();
        if state.captions.is_none() {
            state.captions = Captions::of(&self.client);
        }
        sample.caption = state.captions.as_ref().and_then(|all| self.caption(all));
        sample.secs = first.elapsed().as_secs_f64();
        sample.frame_ms = state.frame_ns / 1e6;
        let bytes = sample.shown.bytes.saturating_sub(state.sampled.1);
        sample.bytes_per_second = bytes as f64 / elapsed.max(1e-3);
        sample.fps = (state.shown.pictures - state.sampled.2) as f64 / elapsed.max(1e-3);
        if let Some(phase) = state.shown.phases.last_mut() {
            phase.add(&sample, ns / 1e6);
        }
        state.picture = Some(sample.clone());
        let is_news = before.is_none_or(|before| {
            (before.shown.level, before.shown.is_complete)
                != (sample.shown.level, sample.shown.is_complete)
        });
        let below = match state.has_monitor {
            true => sample.monitor(&self.client),
            // In the place of numbers.
            false => vec![sample.caption.clone().unwrap_or_else(|| sample.line())],
        };
        output.show(state.shown.pictures, &picture, &below)?;
        state.shown.pictures += 1;
        if is_first || is_news || elapsed >= 1.0 {
            if elapsed >= 1.0 || is_first {
                state.sampled = (Instant::now(), sample.shown.bytes, state.shown.pictures);
            }
            state.shown.samples.push(sample);
        }
        if self
            .seconds
            .is_some_and(|most| first.elapsed().as_secs_f64() >= most)
        {
            state.is_over = true;
        }
        Ok(())
    }

    /// Moves the slider of the bandwidth.
    fn slide(&mut self, state: &mut State) -> anyhow::Result<()> {
        let Some(slider) = self.slider else {
            return Ok(());
        };
        let secs = state
            .shown
            .first_picture
            .map_or(0.0, |first| first.elapsed().as_secs_f64());
        let bps = slider.at(secs);
        let last = state.shown.phases.last();
        if last.is_none_or(|last| last.slider_bps != bps) {
            let phase = Phase::new(secs, bps, state.picture.as_ref());
            state.shown.phases.push(phase);
        }
        if bps != self.client.context().network.available_bps {
            let mut context = self.client.context().clone();
            context.network.available_bps = bps;
            self.client.set_context(&context, self.now())?;
        }
        Ok(())
    }

    /// Asks for what the client lacks.
    fn ask(&mut self, network: &mut Network, sender: &Sender<Event>) {
        let now = self.now();
        match network {
            Network::Http(fetchers) => {
                while let Some((id, request)) = self.client.next_request(now) {
                    fetchers.ask(id, request);
                }
            }
            Network::Session { link, again, .. } => {
                if again.is_some_and(|at| Instant::now() >= at) {
                    *again = None;
                    *link = Link::start(&self.server, self.client.hello(now), sender);
                }
                if let Some(update) = self.client.update(now) {
                    link.send(update);
                }
            }
        }
    }

    /// Takes what happens until the next picture is due.
    fn listen(
        &mut self,
        state: &mut State,
        (network, events, sender): (&mut Network, &Receiver<Event>, &Sender<Event>),
    ) -> anyhow::Result<()> {
        let due = state.last + Duration::from_secs_f64(1.0 / FPS);
        loop {
            let left = due.saturating_duration_since(Instant::now());
            match events.recv_timeout(left) {
                Ok(event) => self.happened(event, network, state)?,
                Err(RecvTimeoutError::Timeout) => return Ok(()),
                Err(RecvTimeoutError::Disconnected) => bail!("the threads of the network ended"),
            }
            if state.is_over {
                return Ok(());
            }
            // What arrived leads to the next requests, and the first picture waits for nothing.
            self.ask(network, sender);
            if state.shown.first_picture.is_none() {
                return Ok(());
            }
        }
    }

    fn happened(
        &mut self,
        event: Event,
        network: &mut Network,
        state: &mut State,
    ) -> anyhow::Result<()> {
        let now = self.now();
        match event {
            Event::Answer(id, answer) => self.client.answer(id, answer, now)?,
            // Before anything came, the address may be wrong.
            Event::Fault(_, error) if self.client.report(0).bytes == 0 => return Err(error),
            Event::Fault(id, _) => self.client.answer(id, ClientAnswer::Failed, now)?,
            Event::Message(message) => {
                let answer = self.client.take(message, now)?;
                let of = self.client.character(0);
                if let Some(fault) = of.and_then(ClientCharacter::fault) {
                    bail!(clean(fault));
                }
                if let Network::Session { link, tries, .. } = network {
                    *tries = 0;
                    answer.into_iter().for_each(|answer| link.send(answer));
                }
            }
            Event::Lost(error) => {
                if let Network::Session { again, tries, .. } = network {
                    *tries += 1;
                    if *tries >= MOST_TRIES || self.client.report(0).bytes == 0 {
                        return Err(error);
                    }
                    *again = Some(Instant::now() + PAUSE);
                }
            }
            Event::Key(key) => self.pressed(key, state)?,
        }
        Ok(())
    }

    fn pressed(&mut self, key: Key, state: &mut State) -> anyhow::Result<()> {
        let mut context = self.client.context().clone();
        let scaled = |value: f64, up: bool| if up { 2.0 * value } else { 0.5 * value };
        match key {
            Key::Bandwidth(up) => {
                let before = context.network.available_bps.unwrap_or(FIRST_BPS);
                context.network.available_bps = Some(scaled(before, up).clamp(1e3, 1e9));
            }
            Key::Distance(nearer) => {
                let known = self.client.character(0).and_then(|of| of.distance_m());
                let before = known
                    .or(context.view.distance_m)
                    .unwrap_or(FIRST_DISTANCE_M);
                let distance_m = scaled(before, !nearer).clamp(0.25, 500.0);
                self.client.set_view(0, 1.0, Some(distance_m))?;
            }
            Key::Clip(place) => {
                let clips = self.clips();
                if let Some(clip) = clips.get(place) {
                    self.client.play(0, Some(clip), self.now());
                }
            }
            Key::Monitor => state.has_monitor = !state.has_monitor,
            Key::Quit => state.is_over = true,
        }
        if context != *self.client.context() {
            self.client.set_context(&context, self.now())?;
        }
        Ok(())
    }

    /// The clips of the character, in the order of their keys.
    fn clips(&self) -> Vec<String> {
        let player = self.client.character(0).and_then(|of| of.player());
        let clips = player.map_or(&[][..], |player| player.model().clips());
        clips.iter().map(|clip| clip.name.clone()).collect()
    }

    /// What is said now.
    fn caption(&self, captions: &Captions) -> Option<String> {
        let of = self.client.character(0)?;
        let playing = of.player()?.state()?;
        let clips = of.player()?.model().clips();
        let clip = clips
            .get(playing.clip_state().clip())
            .map(|clip| &*clip.name);
        captions.at(clip, of.position_secs()).map(str::to_owned)
    }

    fn now(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }
}

impl Shown {
    /// The time of the first picture.
    pub(super) fn first_picture_secs(&self, start: Instant) -> anyhow::Result<f64> {
        let first = self
            .first_picture
            .ok_or_else(|| anyhow!("nothing arrived to be shown"))?;
        Ok((first - start).as_secs_f64())
    }
}
