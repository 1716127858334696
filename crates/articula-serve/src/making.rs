//! The queries that are being made, and where those that were are recorded.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::atomic::AtomicUsize;
use std::sync::{Arc, Mutex, PoisonError, Weak};
use tokio::sync::Semaphore;

/// Most queries that wait to be made; others get 503.
const MOST_WAITING: usize = 64;

/// The records, and the queries that are being made.
#[derive(Debug)]
pub(crate) struct Making {
    folder: PathBuf,
    gates: Mutex<HashMap<String, Weak<tokio::sync::Mutex<()>>>>,
    /// Number of records.
    pub(crate) kept: AtomicUsize,
    pub(crate) waiting: Arc<Semaphore>,
    pub(crate) working: Semaphore,
}

impl Making {
    /// Records in a folder; `working` are made at once.
    #[allow(clippy::disallowed_methods, reason = "the store is a folder")]
    pub(crate) fn new(folder: PathBuf, working: usize) -> Self {
        // Without a folder there are none.
        let kept = std::fs::read_dir(&folder).map_or(0, Iterator::count);
        Self {
            folder,
            kept: AtomicUsize::new(kept),
            gates: Mutex::default(),
            waiting: Arc::new(Semaphore::new(MOST_WAITING)),
            working: Semaphore::new(working.max(1)),
        }
    }

    /// The record of a query.
    pub(crate) fn path(&self, key: &str) -> PathBuf {
        self.folder.join(format!("{key}.json"))
    }

    /// The gate of a query, which one request passes at a time.
    pub(crate) fn gate(&self, key: &str) -> Arc<tokio::sync::Mutex<()>> {
        let mut gates = self.gates.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(gate) = gates.get(key).and_then(Weak::upgrade) {
            return gate;
        }
        gates.retain(|_, gate| gate.strong_count() > 0);
        let gate = Arc::default();
        gates.insert(key.to_owned(), Arc::downgrade(&gate));
        gate
    }
}
