//! Counters, as Prometheus reads them.

use std::fmt::Write;
use std::sync::atomic::{AtomicU64, Ordering};

/// What a server has done since its start.
#[derive(Debug, Default)]
pub(crate) struct Metrics {
    pub(crate) requests: AtomicU64,
    pub(crate) refused: AtomicU64,
    pub(crate) overloaded: AtomicU64,
    pub(crate) body_bytes: AtomicU64,
    pub(crate) ranges: AtomicU64,
    pub(crate) not_modified: AtomicU64,
    pub(crate) stages: AtomicU64,
    pub(crate) packaged: AtomicU64,
    pub(crate) failed: AtomicU64,
    pub(crate) recent: AtomicU64,
    pub(crate) made: AtomicU64,
    pub(crate) swept: AtomicU64,
    pub(crate) sessions: AtomicU64,
    pub(crate) increments: AtomicU64,
    pub(crate) session_bytes: AtomicU64,
}

impl Metrics {
    pub(crate) fn add(counter: &AtomicU64, more: u64) {
        counter.fetch_add(more, Ordering::Relaxed);
    }

    /// The text of `/metrics`, with the number of characters in each state.
    pub(crate) fn text(&self, states: &[(&str, usize)]) -> String {
        let counters = [
            ("requests", "Requests.", &self.requests),
            (
                "refused",
                "Answers with a status of 400 or more.",
                &self.refused,
            ),
            (
                "overloaded",
                "Requests beyond those that are answered at once.",
                &self.overloaded,
            ),
            (
                "body_bytes",
                "Bytes of bodies that were sent.",
                &self.body_bytes,
            ),
            ("ranges", "Answers with a part of a body.", &self.ranges),
            (
                "not_modified",
                "Answers without a body, which the client has.",
                &self.not_modified,
            ),
            ("stages", "Stages of items that were made.", &self.stages),
            ("packaged", "Characters that were packaged.", &self.packaged),
            (
                "failed",
                "Characters that could not be packaged.",
                &self.failed,
            ),
            (
                "recent",
                "Answers with an object that was in memory.",
                &self.recent,
            ),
            (
                "made",
                "Files and cuts that were made by query.",
                &self.made,
            ),
            (
                "swept",
                "Files that were removed since nothing named them any more.",
                &self.swept,
            ),
            ("sessions", "Sessions that were opened.", &self.sessions),
            (
                "increments",
                "Ranges of files that were sent in sessions.",
                &self.increments,
            ),
            (
                "session_bytes",
                "Bytes of messages that were sent in sessions.",
                &self.session_bytes,
            ),
        ];
        let mut text = String::new();
        for (name, help, counter) in counters {
            let value = counter.load(Ordering::Relaxed);
            // Writing to a string cannot fail.
            let _ = writeln!(text, "# HELP articula_{name}_total {help}");
            let _ = writeln!(text, "# TYPE articula_{name}_total counter");
            let _ = writeln!(text, "articula_{name}_total {value}");
        }
        text.push_str("# HELP articula_characters Characters by their state.\n");
        text.push_str("# TYPE articula_characters gauge\n");
        for (state, count) in states {
            let _ = writeln!(text, "articula_characters{{state=\"{state}\"}} {count}");
        }
        text
    }
}
