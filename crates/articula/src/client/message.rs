//! Messages of a session between a client and a server.
//!
//! Form: `docs/formats/session.md`.

use crate::error::{Context as _, Error, Result};
use crate::item::{DecisionReport, ItemBytes};
use articula_stream::description::Context;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Version of the form.
pub const SESSION_VERSION: u32 = 1;
/// Most bytes of a message.
pub const MOST_MESSAGE_BYTES: usize = 1 << 20;
/// Most characters of a session.
pub const MOST_CHARACTERS: usize = 64;

/// What a client sends.
#[derive(Debug, Clone, PartialEq)]
pub enum ClientMessage {
    /// The first message: the version, and all that an update has.
    Hello(SessionUpdate),
    /// What has changed.
    Update(SessionUpdate),
    /// The bytes of an item that the client has.
    Held(HeldFiles),
    /// What is shown, about once a second.
    Shown(ShownReport),
}

/// What a server sends.
#[derive(Debug, Clone, PartialEq)]
pub enum ServerMessage {
    /// The manifest of a character, as far as it is made.
    Manifest {
        /// Number of the character.
        character: u16,
        /// Whether it is the manifest of the whole item.
        is_whole: bool,
        /// Its BLAKE3.
        hash: [u8; 32],
        /// Its bytes, compressed with `br`; none if the client named it as known.
        bytes: Vec<u8>,
    },
    /// Bytes of a file.
    Bytes {
        /// Number of the character.
        character: u16,
        /// Number of the file: its place among those of the manifest's member `files`.
        file: u16,
        /// First byte of the range; 0 of a compressed file.
        offset: u64,
        /// Whether these are all bytes of the file, compressed with `br`.
        is_compressed: bool,
        /// The bytes.
        bytes: Vec<u8>,
    },
    /// What was decided for a character.
    Decision(SessionDecision),
    /// All that the context asks for has been sent.
    Complete {
        /// Number of the character.
        character: u16,
    },
    /// Counters, about once a second.
    Statistics(SessionStatistics),
    /// What is wrong.
    Error(SessionError),
}

/// The state of a client; members that are missing stay as they were.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SessionUpdate {
    /// [`SESSION_VERSION`]; 0 in an update.
    #[serde(skip_serializing_if = "is_zero")]
    pub version: u32,
    /// Network, device, wishes and view of all characters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub context: Option<Context>,
    /// Bandwidth as the client measures it, bits per second.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured_bps: Option<f64>,
    /// All characters that are wanted, in the order of their numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub characters: Option<Vec<WantedCharacter>>,
}

/// A character that a client wants.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WantedCharacter {
    /// Its name at the server.
    pub name: String,
    /// How much it matters, relative to others; 1 if it is missing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub importance: Option<f64>,
    /// Metres from the camera, in place of the context's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_m: Option<f64>,
    /// Name of the motion that plays; the first one if it is missing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clip: Option<String>,
    /// Time within it in seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position_secs: Option<f64>,
    /// BLAKE3 of the manifest that the client has, 64 hexadecimal digits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub manifest: Option<String>,
}

/// Which bytes of an item a client has.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HeldFiles {
    /// Number of the character.
    pub character: u16,
    /// BLAKE3 of the manifest, 64 hexadecimal digits.
    pub manifest: String,
    /// Of each file the ranges: first byte and number of bytes.
    pub files: BTreeMap<String, Vec<[u64; 2]>>,
}

impl HeldFiles {
    /// The ranges of all files.
    pub(super) fn bytes(&self) -> ItemBytes {
        let mut held = ItemBytes::default();
        for (file, ranges) in &self.files {
            let ranges = ranges.iter();
            let ranges = ranges.map(|[start, count]| *start..start.saturating_add(*count));
            held.add(file, ranges);
        }
        held
    }

    pub(super) fn of(character: u16, manifest: String, held: &ItemBytes) -> Self {
        let files = held.files().map(|(file, ranges)| {
            let ranges = ranges.ranges().iter();
            let ranges = ranges.map(|range| [range.start, range.end - range.start]);
            (file.to_owned(), ranges.collect())
        });
        Self {
            character,
            manifest,
            files: files.collect(),
        }
    }
}

/// What a client shows.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ShownReport {
    /// Frames per second.
    pub fps: f64,
    /// Processor time of a frame in milliseconds.
    pub frame_ms: f64,
    /// Joints that are sampled in a frame, of all characters.
    pub joints: u64,
    /// Times at which a character waited for its motion, since the start.
    pub stalls: u64,
}

/// What was decided for a character.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SessionDecision {
    /// Number of the character.
    pub character: u16,
    /// Level of quality that the bandwidth carries, 1 to `levels`.
    pub level: usize,
    /// Number of levels of quality.
    pub levels: usize,
    /// The decision about the item, as `articula adapt --json` tells it.
    pub decision: serde_json::Value,
}

impl SessionDecision {
    pub(super) fn new(character: u16, level: [usize; 2], report: &DecisionReport) -> Self {
        Self {
            character,
            level: level[0],
            levels: level[1],
            // Names and numbers cannot fail.
            decision: serde_json::to_value(report).unwrap_or_default(),
        }
    }
}

/// Counters of a session.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SessionStatistics {
    /// Seconds since the hello.
    pub secs: f64,
    /// Bytes of files that were sent.
    pub bytes: u64,
    /// Ranges of files that were sent.
    pub increments: u64,
    /// The bandwidth that is reckoned with, bits per second.
    pub bandwidth_bps: f64,
}

/// What is wrong with a session, or with one character of it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SessionError {
    /// Number of the character; null if the session ends.
    pub character: Option<u16>,
    /// What is wrong.
    pub error: String,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_zero(version: &u32) -> bool {
    *version == 0
}

const HELLO: u8 = 0x01;
const UPDATE: u8 = 0x02;
const HELD: u8 = 0x03;
const SHOWN: u8 = 0x04;
const MANIFEST: u8 = 0x81;
const BYTES: u8 = 0x82;
const DECISION: u8 = 0x83;
const COMPLETE: u8 = 0x84;
const STATISTICS: u8 = 0x85;
const ERROR: u8 = 0x86;

impl ClientMessage {
    /// Writes the message.
    pub fn to_bytes(&self) -> Vec<u8> {
        match self {
            Self::Hello(update) => with_json(HELLO, update),
            Self::Update(update) => with_json(UPDATE, update),
            Self::Held(held) => with_json(HELD, held),
            Self::Shown(shown) => with_json(SHOWN, shown),
        }
    }

    /// Reads a message.
    ///
    /// # Errors
    /// An [`Error`] that names the kind of the message and its member: an unknown kind, malformed JSON, values
    /// out of their bounds, more than [`MOST_MESSAGE_BYTES`].
    pub fn read(bytes: &[u8]) -> Result<Self> {
        let (kind, body) = split(bytes)?;
        match kind {
            HELLO => {
                let update: SessionUpdate = json(body).context("hello")?;
                if update.version != SESSION_VERSION {
                    let what = format!(
                        "version: found {}, expected {SESSION_VERSION}",
                        update.version
                    );
                    return Err(Error::unsuited(what)).context("hello");
                }
                update.check().context("hello")?;
                Ok(Self::Hello(update))
            }
            UPDATE => {
                let update: SessionUpdate = json(body).context("update")?;
                update.check().context("update")?;
                Ok(Self::Update(update))
            }
            HELD => Ok(Self::Held(json(body).context("held")?)),
            SHOWN => Ok(Self::Shown(json(body).context("shown")?)),
            _ => Err(unknown(kind)),
        }
    }
}

impl SessionUpdate {
    fn check(&self) -> Result<()> {
        if let Some(context) = &self.context {
            context.check()?;
        }
        let number = |name: &str, value: Option<f64>, least: f64| match value {
            Some(value) if !(value >= least && value.is_finite()) => {
                let what = format!("{name}: found {value}, expected at least {least}");
                Err(Error::argument(what))
            }
            _ => Ok(()),
        };
        number("measured_bps", self.measured_bps, 0.0)?;
        let characters = self.characters.as_deref().unwrap_or_default();
        if characters.len() > MOST_CHARACTERS {
            let what = format!(
                "characters: {}, at most {MOST_CHARACTERS}",
                characters.len()
            );
            return Err(Error::argument(what));
        }
        for character in characters {
            number("importance", character.importance, 0.0)?;
            number("distance_m", character.distance_m, 1e-3)?;
            number("position_secs", character.position_secs, 0.0)?;
        }
        Ok(())
    }
}

impl ServerMessage {
    /// Writes the message.
    pub fn to_bytes(&self) -> Vec<u8> {
        match self {
            Self::Manifest {
                character,
                is_whole,
                hash,
                bytes,
            } => {
                let mut made = Vec::with_capacity(36 + bytes.len());
                made.push(MANIFEST);
                made.extend(character.to_le_bytes());
                made.push(u8::from(*is_whole));
                made.extend(hash);
                made.extend(bytes);
                made
            }
            Self::Bytes {
                character,
                file,
                offset,
                is_compressed,
                bytes,
            } => {
                let mut made = Vec::with_capacity(14 + bytes.len());
                made.push(BYTES);
                made.extend(character.to_le_bytes());
                made.extend(file.to_le_bytes());
                made.push(u8::from(*is_compressed));
                made.extend(offset.to_le_bytes());
                made.extend(bytes);
                made
            }
            Self::Decision(decision) => with_json(DECISION, decision),
            Self::Complete { character } => {
                let [low, high] = character.to_le_bytes();
                vec![COMPLETE, low, high]
            }
            Self::Statistics(statistics) => with_json(STATISTICS, statistics),
            Self::Error(error) => with_json(ERROR, error),
        }
    }

    /// Reads a message.
    ///
    /// # Errors
    /// An [`Error`] that names the kind of the message: an unknown kind, one that ends early, malformed JSON,
    /// more than [`MOST_MESSAGE_BYTES`].
    pub fn read(bytes: &[u8]) -> Result<Self> {
        let (kind, body) = split(bytes)?;
        Ok(match kind {
            MANIFEST => {
                let (head, rest) = head::<35>(body, "manifest")?;
                let mut hash = [0; 32];
                hash.copy_from_slice(&head[3..]);
                Self::Manifest {
                    character: u16::from_le_bytes([head[0], head[1]]),
                    is_whole: flag(head[2], "manifest")?,
                    hash,
                    bytes: rest.to_vec(),
                }
            }
            BYTES => {
                let (head, rest) = head::<13>(body, "bytes")?;
                let mut offset = [0; 8];
                offset.copy_from_slice(&head[5..]);
                Self::Bytes {
                    character: u16::from_le_bytes([head[0], head[1]]),
                    file: u16::from_le_bytes([head[2], head[3]]),
                    is_compressed: flag(head[4], "bytes")?,
                    offset: u64::from_le_bytes(offset),
                    bytes: rest.to_vec(),
                }
            }
            DECISION => Self::Decision(json(body).context("decision")?),
            COMPLETE => {
                let (head, rest) = head::<2>(body, "complete")?;
                if !rest.is_empty() {
                    return Err(Error::unsuited("bytes after the end")).context("complete");
                }
                Self::Complete {
                    character: u16::from_le_bytes(head),
                }
            }
            STATISTICS => Self::Statistics(json(body).context("statistics")?),
            ERROR => Self::Error(json(body).context("error")?),
            _ => return Err(unknown(kind)),
        })
    }
}

fn with_json(kind: u8, body: &impl Serialize) -> Vec<u8> {
    let mut made = vec![kind];
    // Names and numbers cannot fail.
    let _ = serde_json::to_writer(&mut made, body);
    made
}

fn split(bytes: &[u8]) -> Result<(u8, &[u8])> {
    if bytes.len() > MOST_MESSAGE_BYTES {
        let what = format!("{} bytes, at most {MOST_MESSAGE_BYTES}", bytes.len());
        return Err(Error::unsuited(what)).context("message");
    }
    let empty = || Error::unsuited("it is empty");
    let (kind, body) = bytes.split_first().ok_or_else(empty).context("message")?;
    Ok((*kind, body))
}

fn json<T: DeserializeOwned>(body: &[u8]) -> Result<T> {
    serde_json::from_slice(body).map_err(|error| Error::unsuited(error.to_string()))
}

fn head<'a, const N: usize>(body: &'a [u8], name: &str) -> Result<([u8; N], &'a [u8])> {
    let ends = || Error::unsuited("it ends early");
    let (head, rest) = body.split_first_chunk().ok_or_else(ends).context(name)?;
    Ok((*head, rest))
}

fn flag(byte: u8, name: &str) -> Result<bool> {
    match byte {
        0 | 1 => Ok(byte == 1),
        _ => Err(Error::unsuited(format!("a flag is {byte}"))).context(name),
    }
}

fn unknown(kind: u8) -> Error {
    Error::unsuited(format!("message: unknown kind {kind:#04x}"))
}
