//! The client over HTTP: it decides by itself, and its caller fetches.

use super::machine::{Asked, Client, PAUSE_SECS};
use super::planner::Increment;
use crate::error::Result;
use articula_stream::decide::Transfer;

/// Longest pause after requests that failed, seconds.
const LONGEST_PAUSE_SECS: f64 = 8.0;

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

impl Client {
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
        let bytes = under_way.filter(|asked| matches!(asked, Asked::Increment(..)));
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
        Some((self.ask(Asked::Increment(increment, now_secs)), request))
    }

    /// Takes what came of a request. A number that is unknown, as of a request that was made twice, is left
    /// out.
    ///
    /// # Errors
    /// An [`Error`](crate::Error) that names the character: a malformed manifest, one that gets nothing in this context,
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
                of.set_whole(is_whole && of.receiver.is_some());
                of.note_plan();
                if of.receiver.is_none() {
                    self.pause(now_secs);
                }
                Ok(())
            }
            (Asked::Increment(increment, asked_secs), ClientAnswer::Bytes { bytes, transfer }) => {
                self.transfers.answered(transfer, asked_secs);
                let (number, file) = (increment.character, &increment.file);
                self.take_bytes(number, file, increment.range.start, &bytes)?;
                self.take_stages()
            }
            (Asked::Increment(increment, _), _) => {
                // The server may have another item by now: then its manifest says so.
                self.characters[increment.character].is_whole = false;
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

    /// Goes on with manifests that arrived, of characters of which no bytes of the stage before are under way.
    fn take_stages(&mut self) -> Result<()> {
        let is_busy = |number: usize| {
            let mut asked = self.asked.values();
            asked.any(|asked| matches!(asked, Asked::Increment(of, _) if of.character == number))
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

    fn ask(&mut self, asked: Asked) -> u64 {
        self.next_id += 1;
        self.asked.insert(self.next_id, asked);
        self.next_id
    }

    fn pause(&mut self, now_secs: f64) {
        self.resume_secs = now_secs + self.pause_secs;
        self.pause_secs = (2.0 * self.pause_secs).min(LONGEST_PAUSE_SECS);
    }
}
