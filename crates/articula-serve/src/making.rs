//! The queries that are being made.

use std::collections::HashMap;
use std::sync::atomic::AtomicUsize;
use std::sync::{Arc, Mutex, PoisonError, Weak};
use tokio::sync::Semaphore;

/// Most queries that wait to be made; others get 503.
const MOST_WAITING: usize = 64;

/// The queries that are being made.
#[derive(Debug)]
pub(crate) struct Making {
    gates: Mutex<HashMap<String, Weak<tokio::sync::Mutex<()>>>>,
    /// Number of those that were made and are kept.
    pub(crate) kept: AtomicUsize,
    pub(crate) waiting: Arc<Semaphore>,
    pub(crate) working: Semaphore,
}

impl Making {
    /// So many were made before; `working` are made at once.
    pub(crate) fn new(kept: usize, working: usize) -> Self {
        Self {
            kept: AtomicUsize::new(kept),
            gates: Mutex::default(),
            waiting: Arc::new(Semaphore::new(MOST_WAITING)),
            working: Semaphore::new(working.max(1)),
        }
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
