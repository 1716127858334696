//! The client in a session: the server decides, and its caller passes messages on.

use super::character::ClientCharacter;
use super::machine::{Client, Session};
use super::message::{
    ClientMessage, HeldFiles, SESSION_VERSION, ServerMessage, SessionDecision, SessionUpdate,
    ShownReport, WantedCharacter,
};
use crate::error::{Context as _, Error, Result};
use crate::item::{ItemReceiver, decompressed};
use articula_stream::decide::Transfer;

/// Longest pause within one transfer whatever the server does, seconds.
const TRANSFER_PAUSE_SECS: f64 = 0.05;
/// A server that keeps to a bandwidth pauses as long as it takes at that bandwidth; more than this many times is the network's.
const PACED: f64 = 2.0;
/// Time between two updates, seconds.
const UPDATE_SECS: f64 = 1.0;

impl Client {
    /// Begins a session: returns the first message to send. What was under way is given up.
    pub fn hello(&mut self, now_secs: f64) -> ClientMessage {
        self.session = Session {
            updated_secs: Some(now_secs),
            last_arrival_secs: now_secs,
            ..Session::default()
        };
        self.asked.clear();
        self.stages.clear();
        (0..self.characters.len()).for_each(|number| self.restore(number));
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
    /// As [`Self::answer`]; what the server says is wrong with the session. What is wrong with one character is
    /// noted there.
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
                    self.characters[number].set_whole(is_whole);
                    self.characters[number].note_plan();
                } else {
                    let most = self.options.open.limits.bytes;
                    let manifest = decompressed(&bytes, most).context("manifest")?;
                    if blake3::hash(&manifest).to_hex().as_str() != hash {
                        return Err(Error::unsuited("manifest: its hash is another one"));
                    }
                    self.take_manifest(number, hash, &manifest, is_whole)?;
                }
                let of = &self.characters[number];
                // What is on the way since it was told is not held twice.
                let told = self.session.held.insert(number, of.manifest.clone());
                if told.as_ref() == Some(&of.manifest) {
                    return Ok(None);
                }
                Ok(Some(self.held(character, number)))
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
                self.session.is_owed = true;
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
                Ok(is_fault.then(|| self.held(character, number)))
            }
            ServerMessage::Decision(decision) => {
                let number = self.known(decision.character)?;
                self.characters[number].fault = None;
                self.session.decisions.insert(number, decision);
                Ok(None)
            }
            ServerMessage::Complete { .. } => {
                self.session.is_owed = false;
                Ok(None)
            }
            ServerMessage::Statistics(_) => Ok(None),
            ServerMessage::Error(error) => match error.character {
                Some(character) => {
                    let number = self.known(character)?;
                    self.characters[number].fault = Some(error.error);
                    Ok(None)
                }
                None => Err(Error::unsuited(error.error)),
            },
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

    /// The message about what is here of a character.
    fn held(&self, character: u16, number: usize) -> ClientMessage {
        let of = &self.characters[number];
        let held = of.receiver.as_ref().map(ItemReceiver::held);
        let held = held.unwrap_or_default();
        ClientMessage::Held(HeldFiles::of(character, of.manifest.clone(), &held))
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
        let usable = self.context.network.usable_bps();
        let paced_secs = usable.map_or(0.0, |bps| PACED * 8.0 * bytes as f64 / bps);
        // While the server has more to send, messages come in one piece after each piece of the network.
        let is_network = self.session.is_owed && now_secs - last > paced_secs;
        if is_network || now_secs - last <= TRANSFER_PAUSE_SECS {
            self.transfers.add(Transfer {
                bytes,
                first_byte_secs: last,
                last_byte_secs: now_secs,
            });
        }
    }
}
