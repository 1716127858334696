//! Requests of a client over HTTP, on threads of their own.

use super::event::Event;
use crate::commands::server::{Answer, Server};
use anyhow::bail;
use articula::client::{ClientAnswer, ClientRequest, Increment};
use articula::item::decompressed;
use articula::stream::decide::Transfer;
use articula_serve::path_of;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// Requests at once: one waits for the next stage.
const THREADS: usize = 5;
/// Longest time to wait for a stage, seconds.
const WAIT_SECS: u32 = 30;

/// Threads that fetch what a client asks for; they end with their queue.
pub(super) struct Fetchers(Sender<(u64, ClientRequest)>);

impl Fetchers {
    /// Starts the threads. Times are since `start`.
    pub(super) fn start(server: &Server, start: Instant, events: &Sender<Event>) -> Self {
        let (sender, asked) = channel();
        let asked = Arc::new(Mutex::new(asked));
        for _ in 0..THREADS {
            let (server, asked) = (server.clone(), Arc::clone(&asked));
            let events = events.clone();
            std::thread::spawn(move || run(&server, &asked, start, &events));
        }
        Self(sender)
    }

    /// Fetches what is asked for.
    pub(super) fn ask(&self, id: u64, request: ClientRequest) {
        // Threads end when nobody listens.
        let _ = self.0.send((id, request));
    }
}

fn run(
    server: &Server,
    asked: &Mutex<Receiver<(u64, ClientRequest)>>,
    start: Instant,
    events: &Sender<Event>,
) {
    loop {
        let next = asked.lock().unwrap_or_else(PoisonError::into_inner).recv();
        let Ok((id, request)) = next else { return };
        let event = match fetch(server, &request, start) {
            Ok(answer) => Event::Answer(id, answer),
            Err(error) => Event::Fault(id, error),
        };
        if events.send(event).is_err() {
            return;
        }
    }
}

/// Fetches one request; an error is one that another try does not mend, or that of the network.
fn fetch(server: &Server, request: &ClientRequest, start: Instant) -> anyhow::Result<ClientAnswer> {
    match request {
        ClientRequest::Manifest { name, known } => {
            let path = format!("/v1/characters/{}", path_of(name));
            let at = format!("{path}/manifest.json?wait={WAIT_SECS}");
            let tag = known.as_ref().map(|hash| format!("\"{hash}\""));
            let headers = tag.as_deref().map(|tag| ("If-None-Match", tag));
            let answer = server.get(&at, headers.as_slice())?;
            let is_whole = answer.state == "ready";
            match answer.status {
                200 => Ok(ClientAnswer::Manifest {
                    bytes: answer.body,
                    is_whole,
                }),
                304 | 503 => Ok(ClientAnswer::Unchanged { is_whole }),
                _ => bail!("{path}: {}", answer.fault()),
            }
        }
        ClientRequest::Bytes { object, increment } => bytes(server, object, increment, start),
    }
}

fn bytes(
    server: &Server,
    object: &str,
    of: &Increment,
    start: Instant,
) -> anyhow::Result<ClientAnswer> {
    let path = format!("/v1/o/{object}");
    let count = of.range.end - of.range.start;
    let range = format!("bytes={}-{}", of.range.start, of.range.end - 1);
    let header = match of.is_whole {
        true => ("Accept-Encoding", "br"),
        false => ("Range", &*range),
    };
    let answer = server.get(&path, &[header])?;
    let sent = answer.body.len() as u64;
    let Answer { first_byte, .. } = answer;
    let body = match (answer.status, of.is_whole) {
        (200, true) if answer.coding == "br" => decompressed(&answer.body, count)?,
        (200, true) | (206, false) => answer.body,
        _ => bail!("{}: {}", of.file, answer.fault()),
    };
    if body.len() as u64 != count {
        bail!("{}: {} bytes came, expected {count}", of.file, body.len());
    }
    let transfer = Transfer {
        bytes: sent,
        first_byte_secs: (first_byte - start).as_secs_f64(),
        last_byte_secs: start.elapsed().as_secs_f64(),
    };
    Ok(ClientAnswer::Bytes {
        bytes: body,
        transfer,
    })
}
