//! Options of a server.

use crate::watcher::RequestWatcher;
use articula::OpenOptions;
use articula::item::PackageOptions;
use std::path::PathBuf;
use std::time::Duration;

/// Options of [`Catalogue::open`](crate::Catalogue::open).
#[derive(Debug, Clone)]
pub struct ServeOptions {
    /// Whether nothing is written: only what is packaged is served, and nothing is taken.
    pub read_only: bool,
    /// The file of the catalogue; without one it is `.articula/catalogue.sqlite3` in the folder. A folder on a network disk
    /// has it elsewhere: SQLite's locks and logs need a disk of this machine.
    pub catalogue: Option<PathBuf>,
    /// What a client that puts a character must know (`Authorization: Bearer TOKEN`); anyone may without.
    pub token: Option<String>,
    /// Origin of web pages that may read what is served, such as `https://example.com`, or `*` for all; none without.
    pub allow_origin: Option<String>,
    /// Folder of web pages that are served below `/studio/`; without one those that are built in with the feature
    /// `studio`, if any.
    pub studio: Option<PathBuf>,
    /// Most bytes of a character that is put.
    pub most_bytes: usize,
    /// Most characters that are put at once, whose bytes are in memory; others get 503.
    pub most_uploads: usize,
    /// Least rate of its body in bits per second, after the time of `silence`.
    pub least_upload_bps: f64,
    /// Most connections at once; others get 503 and are closed. Sessions do not count.
    pub most_connections: usize,
    /// Most connections and sessions of one client address at once, of IPv6 of one network of 64 bits; others get 429 and
    /// are closed. Without it an address may have all: behind a proxy there is one.
    pub most_of_address: Option<usize>,
    /// Time for the head of a request, and for the next one on a connection.
    pub silence: Duration,
    /// Time for a client to take something of an answer.
    pub patience: Duration,
    /// Time for open connections to end when the server is stopped.
    pub drain: Duration,
    /// Bits per second of each connection and session, as of a slow network; as fast as it takes them without.
    pub throttle_bps: Option<f64>,
    /// Most requests that are answered at once; others get 503.
    pub most_requests: usize,
    /// Most sessions at once; others get 503.
    pub most_sessions: usize,
    /// Most bytes of objects that are kept in memory.
    pub most_recent_bytes: u64,
    /// Who is told of every request.
    pub watcher: Option<RequestWatcher>,
    /// Most files and cuts by query that are kept; beyond, other queries get 507.
    pub most_made: usize,
    /// Number of characters that are packaged at once.
    pub packaging: usize,
    /// How characters are opened.
    pub open: OpenOptions,
    /// How they are packaged.
    pub package: PackageOptions,
}

impl Default for ServeOptions {
    /// Characters of up to 256 MB, 8 at once, at 512 kbit/s at least; 900 connections, 512 requests and 2048 sessions at once; 20 s for a
    /// request, a minute for an answer, 10 s to end; 256 MB in memory, 10,000 files
    /// and cuts by query; two characters packaged at once, as `articula package` does.
    fn default() -> Self {
        Self {
            read_only: false,
            catalogue: None,
            token: None,
            allow_origin: None,
            studio: None,
            most_bytes: 256 << 20,
            most_uploads: 8,
            least_upload_bps: 512e3,
            // Most systems let a process open 1024 files.
            most_connections: 900,
            most_of_address: None,
            silence: Duration::from_secs(20),
            patience: Duration::from_secs(60),
            drain: Duration::from_secs(10),
            throttle_bps: None,
            most_requests: 512,
            most_sessions: 2048,
            most_recent_bytes: 256 << 20,
            watcher: None,
            most_made: 10_000,
            packaging: 2,
            open: OpenOptions::default(),
            package: PackageOptions::default(),
        }
    }
}
