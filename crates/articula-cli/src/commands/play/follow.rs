//! What is fetched of a character: what is decided of each stage, and not held yet.

use super::server::Server;
use anyhow::{Context as _, bail};
use articula::item::{AdaptOptions, ItemReceiver};
use articula::stream::description::Context;
use articula::{Figure, OpenOptions};
use std::sync::mpsc::Sender;
use std::time::Duration;

/// Longest time to wait for the next stage, seconds.
const WAIT_SECS: u32 = 30;
/// Time between requests to a server that has nothing yet.
const PAUSE: Duration = Duration::from_millis(200);

/// A character as far as it is here.
pub(crate) struct Arrived {
    pub(crate) figure: Figure,
    /// Bytes that were received, without manifests.
    pub(crate) bytes: u64,
    /// Bound of the error of what is shown.
    pub(crate) error_px: f64,
    /// Whether nothing is left to fetch.
    pub(crate) is_all: bool,
}

/// Fetches a character.
pub(crate) struct Follower {
    server: Server,
    path: String,
    context: Context,
    receiver: Option<ItemReceiver>,
    /// Tag of the manifest that is held.
    tag: String,
    bytes: u64,
}

impl Follower {
    pub(crate) fn new(server: Server, name: &str, context: Context) -> Self {
        Self {
            server,
            path: format!("/v1/characters/{}", encoded(name)),
            context,
            receiver: None,
            tag: String::new(),
            bytes: 0,
        }
    }

    /// Fetches stage after stage and hands over each, until all is here or nobody takes it.
    pub(crate) fn follow(mut self, arrivals: &Sender<Arrived>) -> anyhow::Result<()> {
        loop {
            let path = format!("{}/manifest.json?wait={WAIT_SECS}", self.path);
            let tag = self.tag.clone();
            let answer = self.server.get(&path, &[("If-None-Match", &tag)])?;
            match answer.status {
                200 => {}
                304 if self.is_ready()? => return Ok(()),
                304 => continue,
                503 => {
                    std::thread::sleep(PAUSE);
                    continue;
                }
                _ => bail!("{}: {}", self.path, answer.fault()),
            }
            self.tag = answer.tag;
            let options = OpenOptions::default();
            let receiver = match &self.receiver {
                None => ItemReceiver::new(&answer.body, &options),
                Some(before) => before.renewed(&answer.body),
            };
            let mut receiver = receiver.with_context(|| self.path.clone())?;
            let error_px = self.fetch(&mut receiver)?;
            let figure = Figure::new(receiver.character()?)?;
            let is_all = self.is_ready()?;
            self.receiver = Some(receiver);
            let arrived = Arrived {
                figure,
                bytes: self.bytes,
                error_px,
                is_all,
            };
            if arrivals.send(arrived).is_err() {
                return Ok(());
            }
        }
    }

    /// Whether the server has made all of the character.
    fn is_ready(&self) -> anyhow::Result<bool> {
        let state = self.server.get(&self.path, &[])?;
        let state: serde_json::Value = serde_json::from_slice(&state.body)?;
        Ok(state["state"] != "packaging" && state["state"] != "waiting")
    }

    /// Fetches what the choice for the context needs; returns the bound of its error.
    fn fetch(&mut self, receiver: &mut ItemReceiver) -> anyhow::Result<f64> {
        let decided = receiver.decide(&self.context, &AdaptOptions::default())?;
        let Some(cut) = &decided.cut else {
            let least = decided.least_bytes.unwrap_or_default();
            bail!(
                "{}: nothing fits this bandwidth in 2 s; the least is {least} bytes",
                self.path
            );
        };
        let missing = receiver.missing(cut)?;
        for (file, ranges) in missing.files() {
            let Some(entry) = receiver.manifest().files.get(file) else {
                bail!("{}: {file} has no hash", self.path);
            };
            let path = format!("/v1/o/{}", entry.hash);
            for range in ranges.ranges() {
                let value = format!("bytes={}-{}", range.start, range.end - 1);
                let answer = self.server.get(&path, &[("Range", &value)])?;
                if answer.status != 206 || answer.body.len() as u64 != range.end - range.start {
                    bail!("{file}: {}", answer.fault());
                }
                self.bytes += answer.body.len() as u64;
                receiver.receive(file, range.start, &answer.body)?;
            }
        }
        Ok(decided.decision.error_px)
    }
}

/// A name as a segment of a path.
fn encoded(name: &str) -> String {
    let is_plain = |byte: &u8| byte.is_ascii_alphanumeric() || b"-_.~".contains(byte);
    let each = name.bytes().map(|byte| match is_plain(&byte) {
        true => char::from(byte).to_string(),
        false => format!("%{byte:02X}"),
    });
    each.collect()
}
