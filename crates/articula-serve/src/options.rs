//! Options of a server.

use articula::OpenOptions;
use articula::item::PackageOptions;

/// Options of [`Catalogue::open`](crate::Catalogue::open).
#[derive(Debug, Clone)]
pub struct ServeOptions {
    /// Whether nothing is written: only what is packaged is served, and nothing is taken.
    pub read_only: bool,
    /// What a client that puts a character must know (`Authorization: Bearer TOKEN`); anyone may without.
    pub token: Option<String>,
    /// Most bytes of a character that is put.
    pub most_bytes: usize,
    /// Most requests that are answered at once; others get 503.
    pub most_requests: usize,
    /// Most sessions at once; others get 503.
    pub most_sessions: usize,
    /// Most bytes of objects that are kept in memory.
    pub most_recent_bytes: u64,
    /// Number of characters that are packaged at once.
    pub packaging: usize,
    /// How characters are opened.
    pub open: OpenOptions,
    /// How they are packaged.
    pub package: PackageOptions,
}

impl Default for ServeOptions {
    /// Characters of up to 256 MB, 512 requests and 2048 sessions at once, 256 MB in memory, two characters packaged at once, as `articula
    /// package` does.
    fn default() -> Self {
        Self {
            read_only: false,
            token: None,
            most_bytes: 256 << 20,
            most_requests: 512,
            most_sessions: 2048,
            most_recent_bytes: 256 << 20,
            packaging: 2,
            open: OpenOptions::default(),
            package: PackageOptions::default(),
        }
    }
}
