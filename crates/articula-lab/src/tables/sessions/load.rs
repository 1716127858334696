//! Clients of sessions: they read messages and decode nothing.

use crate::tables::served::Served;
use anyhow::{Context, Result};
use articula::client::{
    ClientMessage, HeldFiles, SESSION_VERSION, ServerMessage, SessionUpdate, WantedCharacter,
};
use articula::item::{Manifest, decompressed};
use articula::stream::description::Context as Situation;
use futures_util::{SinkExt, StreamExt};
use std::fmt::Write as _;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use tokio_tungstenite::tungstenite::Message;

/// Time between two changes of the view of a session.
const CHANGE: Duration = Duration::from_secs(1);
/// Time in which all sessions begin, and which is not measured, as a share of the load, and at most.
const WARM_SHARE: f64 = 0.25;
const WARM_SECS: f64 = 5.0;
/// Most bytes of a manifest.
const MOST_MANIFEST_BYTES: u64 = 1 << 24;
/// What a load gave.
pub(super) struct Load {
    sessions: usize,
    lost: usize,
    secs: f64,
    units: u64,
    bytes: u64,
    /// Seconds from a message to the decision about it, rising.
    latencies: Vec<f64>,
    /// Memory of the process over time: seconds, bytes.
    memory: Vec<(f64, u64)>,
}

#[derive(Debug, Default)]
struct Tally {
    units: AtomicU64,
    bytes: AtomicU64,
    lost: AtomicUsize,
    latencies: Mutex<Vec<f64>>,
}

impl Load {
    /// Runs sessions at a bandwidth each.
    pub(super) fn run(served: &Served, sessions: usize, bps: f64, secs: f64) -> Result<Self> {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let runtime = tokio::runtime::Builder::new_multi_thread();
        let runtime = { runtime }.worker_threads(threads).enable_all().build()?;
        Ok(runtime.block_on(Self::loaded(served.at, (sessions, bps), secs)))
    }

    async fn loaded(at: SocketAddr, (sessions, bps): (usize, f64), secs: f64) -> Self {
        let tally = Arc::new(Tally::default());
        let warm_secs = WARM_SECS.min(WARM_SHARE * secs);
        let tasks: Vec<_> = (0..sessions)
            .map(|number| {
                let tally = Arc::clone(&tally);
                // They do not all begin at once.
                let pause = warm_secs * 0.8 * number as f64 / sessions as f64;
                tokio::spawn(async move {
                    let pause = Duration::from_secs_f64(pause);
                    if session(at, bps, pause, &tally).await.is_err() {
                        tally.lost.fetch_add(1, Ordering::Relaxed);
                    }
                })
            })
            .collect();
        tokio::time::sleep(Duration::from_secs_f64(warm_secs)).await;
        lock(&tally.latencies).clear();
        let count = |of: &AtomicU64| of.load(Ordering::Relaxed);
        let before = (count(&tally.units), count(&tally.bytes));
        let start = Instant::now();
        let mut memory = Vec::new();
        while start.elapsed().as_secs_f64() < secs {
            memory.push((start.elapsed().as_secs_f64(), memory_bytes()));
            tokio::time::sleep(Duration::from_secs_f64((secs / 10.0).min(5.0))).await;
        }
        let elapsed = start.elapsed().as_secs_f64();
        memory.push((elapsed, memory_bytes()));
        tasks.iter().for_each(tokio::task::JoinHandle::abort);
        let mut latencies = std::mem::take(&mut *lock(&tally.latencies));
        latencies.sort_by(f64::total_cmp);
        Self {
            sessions,
            lost: tally.lost.load(Ordering::Relaxed),
            secs: elapsed,
            units: count(&tally.units) - before.0,
            bytes: count(&tally.bytes) - before.1,
            latencies,
            memory,
        }
    }

    fn latency_ms(&self, share: f64) -> f64 {
        let at = (share * self.latencies.len() as f64) as usize;
        let last = self.latencies.len().saturating_sub(1);
        1e3 * self
            .latencies
            .get(at.min(last))
            .copied()
            .unwrap_or(f64::NAN)
    }

    pub(super) fn write(&self, page: &mut String, what: &str) {
        let each = self.units as f64 / self.secs / self.sessions as f64;
        let megabytes = |at: Option<&(f64, u64)>| at.map_or(0.0, |(_, bytes)| *bytes as f64 / 1e6);
        // Writing to a string cannot fail.
        let _ = write!(
            page,
            "## Sessions\n\n{what}.\n\n\
             | ranges a second and session | MB/s in all | latency, median | 95 % | 99 % | greatest | \
             sessions lost | memory at first | memory at last |\n\
             | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n\
             | {each:.1} | {:.2} | {:.1} ms | {:.1} ms | {:.1} ms | {:.0} ms | {} | {:.0} MB | {:.0} MB |\n\n",
            self.bytes as f64 / 1e6 / self.secs,
            self.latency_ms(0.5),
            self.latency_ms(0.95),
            self.latency_ms(0.99),
            self.latency_ms(1.0),
            self.lost,
            megabytes(self.memory.first()),
            megabytes(self.memory.last()),
        );
    }

    pub(super) fn csv(&self) -> String {
        let mut csv = "secs,memory_bytes\n".to_owned();
        for (secs, bytes) in &self.memory {
            let _ = writeln!(csv, "{secs:.1},{bytes}");
        }
        csv
    }
}

/// One session until it is dropped; an error if the server ends it.
async fn session(at: SocketAddr, bps: f64, pause: Duration, tally: &Tally) -> Result<()> {
    tokio::time::sleep(pause).await;
    let (socket, _) = tokio_tungstenite::connect_async(format!("ws://{at}/v1/session")).await?;
    let (mut sender, mut messages) = socket.split();
    let wanted = WantedCharacter {
        name: "character".to_owned(),
        ..WantedCharacter::default()
    };
    let situation = |is_near: bool| {
        let mut situation = Situation::default();
        situation.network.available_bps = Some(bps);
        situation.view.distance_m = Some(if is_near { 2.0 } else { 3.0 });
        Some(situation)
    };
    let hello = ClientMessage::Hello(SessionUpdate {
        version: SESSION_VERSION,
        context: situation(true),
        characters: Some(vec![wanted]),
        ..SessionUpdate::default()
    });
    sender.send(binary(&hello)).await?;
    // All but the motions, which it always lacks.
    let mut held = HeldFiles::default();
    let mut change = tokio::time::interval(CHANGE);
    let (mut is_near, mut asked) = (true, None);
    loop {
        let message = tokio::select! {
            message = messages.next() => message.context("the server ended the session")??,
            _ = change.tick() => {
                // Until the first decision there is nothing to change.
                if asked.is_none() && !held.manifest.is_empty() {
                    is_near = !is_near;
                    let update = ClientMessage::Update(SessionUpdate {
                        context: situation(is_near),
                        ..SessionUpdate::default()
                    });
                    asked = Some(Instant::now());
                    sender.send(binary(&update)).await?;
                }
                continue;
            }
        };
        let Message::Binary(bytes) = message else {
            continue;
        };
        let is_forgotten = match ServerMessage::read(&bytes)? {
            ServerMessage::Manifest { hash, bytes, .. } => {
                let manifest = decompressed(&bytes, MOST_MANIFEST_BYTES)?;
                let manifest: Manifest = serde_json::from_slice(&manifest)?;
                held.manifest = hash.iter().map(|byte| format!("{byte:02x}")).collect();
                let files = manifest.sizes().into_iter();
                let files = files.filter(|(file, _)| !file.ends_with(".abp"));
                held.files = files
                    .map(|(file, bytes)| (file.to_owned(), vec![[0, bytes]]))
                    .collect();
                true
            }
            ServerMessage::Bytes { bytes, .. } => {
                tally.units.fetch_add(1, Ordering::Relaxed);
                tally.bytes.fetch_add(bytes.len() as u64, Ordering::Relaxed);
                false
            }
            ServerMessage::Decision(_) => {
                if let Some(asked) = asked.take() {
                    lock(&tally.latencies).push(Instant::elapsed(&asked).as_secs_f64());
                }
                false
            }
            ServerMessage::Complete { .. } => true,
            ServerMessage::Statistics(_) => false,
            ServerMessage::Error(error) => anyhow::bail!("{}", error.error),
        };
        if is_forgotten {
            sender
                .send(binary(&ClientMessage::Held(held.clone())))
                .await?;
        }
    }
}

fn binary(message: &ClientMessage) -> Message {
    Message::Binary(message.to_bytes().into())
}

fn lock<T>(of: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Memory of the process; 0 where the system does not tell.
fn memory_bytes() -> u64 {
    let told = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let pages = told
        .split_whitespace()
        .nth(1)
        .and_then(|pages| pages.parse::<u64>().ok());
    4096 * pages.unwrap_or(0)
}
