//! One session: messages of its client, manifests of the catalogue, bytes of the store.
#![allow(clippy::disallowed_methods, reason = "a session has a clock")]

use crate::catalogue::Catalogue;
use crate::metrics::Metrics;
use crate::objects::Coding;
use crate::served::Served;
use crate::sessions::{OpenSession, SessionCharacter};
use crate::state::Progress;
use articula::client::{
    ClientMessage, Feed, FeedChange, FeedNext, Increment, ServerMessage, SessionError,
};
use axum::body::Bytes;
use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use std::time::{Duration, Instant};
use tokio::time::{sleep, timeout};

/// Time for the first message, and for one of a client that says nothing else.
const SILENCE: Duration = Duration::from_secs(30);
/// Time in which a client takes a message.
const STALL: Duration = Duration::from_secs(30);
/// Messages of a client in a second.
const MOST_MESSAGES: u32 = 100;

/// Why a session ends, as its client is told; nothing if the client is gone.
struct End(Option<String>);

impl End {
    fn gone() -> Self {
        Self(None)
    }

    fn fault(what: impl ToString) -> Self {
        Self(Some(what.to_string()))
    }
}

/// Serves a session until its client leaves.
pub(super) async fn run(mut socket: WebSocket, catalogue: Catalogue, place: OpenSession) {
    let End(why) = match Session::begin(&mut socket, catalogue, place).await {
        Ok(mut session) => session.serve(&mut socket).await,
        Err(end) => end,
    };
    if let Some(error) = why {
        let fault = SessionError {
            character: None,
            error: error.clone(),
        };
        let close = CloseFrame {
            code: close_code::POLICY,
            reason: error.chars().take(60).collect::<String>().into(),
        };
        let goodbye = async {
            let _ = socket.send(message(&ServerMessage::Error(fault))).await;
            let _ = socket.send(Message::Close(Some(close))).await;
        };
        // A client that takes nothing is left.
        let _ = timeout(Duration::from_secs(2), goodbye).await;
    }
}

/// A session that has begun.
struct Session {
    catalogue: Catalogue,
    place: OpenSession,
    feed: Feed,
    start: Instant,
    /// What of each character the client was told of.
    told: Vec<Told>,
    heard: Instant,
    /// Messages of the second that begins at a time.
    flood: (Instant, u32),
}

/// What a client was told of a character.
#[derive(Default)]
struct Told {
    /// The item of the manifest that it has.
    served: Option<Served>,
    is_whole: bool,
    /// Why it gets nothing of it, or nothing more.
    error: Option<String>,
}

impl Session {
    async fn begin(
        socket: &mut WebSocket,
        catalogue: Catalogue,
        place: OpenSession,
    ) -> Result<Self, End> {
        let start = Instant::now();
        let first = timeout(SILENCE, socket.recv()).await;
        let first = first.map_err(|_| End::fault("no hello came"))?;
        let hello = read(first)?.ok_or_else(End::gone)?;
        let feed = Feed::new(hello, 0.0).map_err(End::fault)?;
        let mut session = Self {
            catalogue,
            place,
            feed,
            start,
            told: Vec::new(),
            heard: start,
            flood: (start, 0),
        };
        session.want();
        Ok(session)
    }

    fn now(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    async fn serve(&mut self, socket: &mut WebSocket) -> End {
        let mut news = self.catalogue.characters().news();
        // What was there before counts too.
        news.mark_changed();
        loop {
            let is_news = news.has_changed().unwrap_or(false);
            let is_unknown = |told: &Told| told.served.is_none() && told.error.is_none();
            if is_news || self.told.iter().any(is_unknown) {
                news.mark_unchanged();
                if let Err(end) = self.tell_manifests(socket).await {
                    return end;
                }
            }
            let next = self.feed.next(self.now());
            let done = match next {
                FeedNext::Wait(until_secs) => {
                    let wait = Duration::from_secs_f64((until_secs - self.now()).max(0.001));
                    tokio::select! {
                        came = socket.recv() => self.hear(socket, came).await,
                        // It is looked at above.
                        _ = news.changed() => {
                            news.mark_changed();
                            Ok(())
                        }
                        () = sleep(wait) => self.check_silence(),
                    }
                }
                next => match self.say(socket, next).await {
                    // What the client says counts before the next bytes.
                    Ok(()) => tokio::select! {
                        biased;
                        came = socket.recv() => self.hear(socket, came).await,
                        () = std::future::ready(()) => Ok(()),
                    },
                    Err(end) => Err(end),
                },
            };
            if let Err(end) = done {
                return end;
            }
        }
    }

    fn check_silence(&self) -> Result<(), End> {
        match self.heard.elapsed() > SILENCE {
            true => Err(End::fault("no message for 30 s")),
            false => Ok(()),
        }
    }

    /// Takes a message of the client.
    async fn hear(
        &mut self,
        socket: &mut WebSocket,
        came: Option<Result<Message, axum::Error>>,
    ) -> Result<(), End> {
        let Some(message) = read(came)? else {
            return Ok(());
        };
        self.heard = Instant::now();
        if self.flood.0.elapsed() > Duration::from_secs(1) {
            self.flood = (self.heard, 0);
        }
        self.flood.1 += 1;
        if self.flood.1 > MOST_MESSAGES {
            return Err(End::fault("more than 100 messages in a second"));
        }
        let changes = self.feed.take(message, self.now()).map_err(End::fault)?;
        for change in changes {
            match change {
                FeedChange::Characters => self.want(),
                FeedChange::Plan(character) => self.plan(socket, character).await?,
            }
        }
        let shown = self.feed.shown().clone();
        self.place.report(|report| {
            report.shown = shown;
            for (known, wanted) in report.characters.iter_mut().zip(self.feed.characters()) {
                known.clip.clone_from(&wanted.clip);
                known.position_secs = wanted.position_secs.unwrap_or_default();
            }
        });
        Ok(())
    }

    /// Notes other characters.
    fn want(&mut self) {
        let names: Vec<String> = self.feed.characters().map(|of| of.name.clone()).collect();
        self.told = names.iter().map(|_| Told::default()).collect();
        let of = |name| SessionCharacter {
            name,
            ..SessionCharacter::default()
        };
        let characters = names.into_iter().map(of).collect();
        self.place.report(|report| report.characters = characters);
    }

    /// Tells the client of stages that it does not know.
    async fn tell_manifests(&mut self, socket: &mut WebSocket) -> Result<(), End> {
        let names: Vec<String> = self.feed.characters().map(|of| of.name.clone()).collect();
        for (character, name) in names.iter().enumerate() {
            let Some(state) = self.catalogue.state(name) else {
                let why = format!("{name}: there is no such character");
                self.refuse(socket, character, why).await?;
                continue;
            };
            if let Progress::Failed(why) = &state.progress {
                let why = format!("{name}: {why}");
                self.refuse(socket, character, why).await?;
                continue;
            }
            let is_whole = state.progress == Progress::Ready;
            let Some(served) = state.served else { continue };
            let told = &self.told[character];
            let known = told.served.as_ref();
            let is_known = known.is_some_and(|known| known.name == served.name);
            if is_known && told.is_whole == is_whole {
                continue;
            }
            self.tell_manifest(socket, character, served, is_whole)
                .await?;
        }
        Ok(())
    }

    /// Tells the client once why it gets nothing of a character. The others go on.
    async fn refuse(
        &mut self,
        socket: &mut WebSocket,
        character: usize,
        error: String,
    ) -> Result<(), End> {
        let told = &mut self.told[character];
        if told.error.as_ref() == Some(&error) {
            return Ok(());
        }
        told.error = Some(error.clone());
        let fault = SessionError {
            character: Some(character as u16),
            error,
        };
        self.send(socket, &ServerMessage::Error(fault)).await
    }

    async fn tell_manifest(
        &mut self,
        socket: &mut WebSocket,
        character: usize,
        served: Served,
        is_whole: bool,
    ) -> Result<(), End> {
        let hash = served.name.as_str().to_owned();
        let known = self.told[character].served.as_ref();
        let is_same = known.is_some_and(|known| known.name == served.name);
        let is_known = match is_same {
            true => true,
            false => self.feed.set_manifest(character, &served.manifest, &hash),
        };
        let bytes = match is_known {
            true => Bytes::new(),
            false => {
                let found = self.bytes(&served, None, Coding::Brotli).await?;
                found.ok_or_else(|| End::fault("the manifest is not there any more"))?
            }
        };
        self.told[character] = Told {
            served: Some(served),
            is_whole,
            error: None,
        };
        let hash = blake3::Hash::from_hex(&hash).map_err(End::fault)?;
        let told = ServerMessage::Manifest {
            character: character as u16,
            is_whole,
            hash: *hash.as_bytes(),
            bytes: bytes.to_vec(),
        };
        self.send(socket, &told).await?;
        match is_same {
            true => Ok(()),
            false => self.plan(socket, character).await,
        }
    }

    /// Plans a character for the context of the moment.
    async fn plan(&mut self, socket: &mut WebSocket, character: usize) -> Result<(), End> {
        let told = self.told.get(character);
        let Some(served) = told.and_then(|told| told.served.as_ref()) else {
            return Ok(());
        };
        let (hash, manifest) = (served.name.clone(), served.manifest.clone());
        let context = self.feed.context_of(character);
        let catalogue = self.catalogue.clone();
        let made = tokio::task::spawn_blocking(move || {
            catalogue.plans().get(hash.as_str(), &manifest, &context)
        });
        match made.await.map_err(End::fault)? {
            Ok(plan) => {
                self.told[character].error = None;
                self.feed.set_plan(character, plan, self.now());
                Ok(())
            }
            Err(error) => {
                self.feed.refuse_plan(character);
                self.refuse(socket, character, error.to_string()).await
            }
        }
    }

    /// Sends what comes next.
    async fn say(&mut self, socket: &mut WebSocket, next: FeedNext) -> Result<(), End> {
        let said = match next {
            FeedNext::Wait(_) => return Ok(()),
            FeedNext::Bytes(increment, file) => {
                let bytes = self.increment(&increment, file).await?;
                let metrics = self.catalogue.metrics();
                Metrics::add(&metrics.increments, 1);
                bytes
            }
            FeedNext::Decision(decision) => {
                let (number, level, levels) = (decision.character, decision.level, decision.levels);
                self.place.report(|report| {
                    if let Some(of) = report.characters.get_mut(usize::from(number)) {
                        (of.level, of.levels, of.is_complete) = (level, levels, false);
                    }
                });
                ServerMessage::Decision(decision)
            }
            FeedNext::Complete(character) => {
                self.place.report(|report| {
                    if let Some(of) = report.characters.get_mut(usize::from(character)) {
                        of.is_complete = true;
                    }
                });
                ServerMessage::Complete { character }
            }
            FeedNext::Statistics(statistics) => {
                self.place.report(|report| report.sent = statistics);
                ServerMessage::Statistics(statistics)
            }
        };
        self.send(socket, &said).await
    }

    async fn increment(&self, of: &Increment, file: u16) -> Result<ServerMessage, End> {
        let told = self.told.get(of.character);
        let served = told.and_then(|told| told.served.as_ref());
        let served = served.ok_or_else(|| End::fault("bytes of nothing"))?;
        let lost = || End::fault(format!("{} is not there any more", of.file));
        let short = match of.is_whole {
            true => self.bytes(served, Some(&of.file), Coding::Brotli).await?,
            false => None,
        };
        let is_compressed = short.is_some();
        let bytes = match short {
            Some(short) => short.to_vec(),
            None => {
                let whole = self.bytes(served, Some(&of.file), Coding::Identity).await?;
                let range = of.range.start as usize..of.range.end as usize;
                let whole = whole.ok_or_else(lost)?;
                whole.get(range).ok_or_else(lost)?.to_vec()
            }
        };
        Ok(ServerMessage::Bytes {
            character: of.character as u16,
            file,
            offset: of.range.start,
            is_compressed,
            bytes,
        })
    }

    /// The bytes of a file of an item, or of its manifest.
    async fn bytes(
        &self,
        served: &Served,
        file: Option<&str>,
        coding: Coding,
    ) -> Result<Option<Bytes>, End> {
        let name = match file {
            Some(file) => served.files.get(file).cloned(),
            None => Some(served.name.clone()),
        };
        let Some(name) = name else { return Ok(None) };
        if let Some(recent) = self.catalogue.objects().recent(&name, coding) {
            return Ok(recent);
        }
        let catalogue = self.catalogue.clone();
        let read = tokio::task::spawn_blocking(move || catalogue.objects().get(&name, coding));
        read.await.map_err(End::fault)?.map_err(End::fault)
    }

    async fn send(&self, socket: &mut WebSocket, said: &ServerMessage) -> Result<(), End> {
        let said = message(said);
        let bytes = match &said {
            Message::Binary(bytes) => bytes.len() as u64,
            _ => 0,
        };
        Metrics::add(&self.catalogue.metrics().session_bytes, bytes);
        match timeout(STALL, socket.send(said)).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) => Err(End::gone()),
            Err(_) => Err(End::fault("the client takes nothing")),
        }
    }
}

fn message(said: &ServerMessage) -> Message {
    Message::Binary(said.to_bytes().into())
}

/// A message of a client, if that is what came.
fn read(came: Option<Result<Message, axum::Error>>) -> Result<Option<ClientMessage>, End> {
    match came {
        None | Some(Ok(Message::Close(_))) => Err(End::gone()),
        Some(Err(error)) => Err(End::fault(error)),
        Some(Ok(Message::Binary(bytes))) => {
            ClientMessage::read(&bytes).map(Some).map_err(End::fault)
        }
        Some(Ok(Message::Text(_))) => Err(End::fault("a message is text; they are binary")),
        Some(Ok(Message::Ping(_) | Message::Pong(_))) => Ok(None),
    }
}
