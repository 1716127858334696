//! What is shown of sessions to people and programs.

use articula::client::{SessionStatistics, ShownReport};
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// A session as JSON.
#[derive(Debug, Clone, Default, Serialize)]
pub(crate) struct SessionReport {
    /// Number, in the order of arrival.
    pub(crate) number: u64,
    /// Its characters.
    pub(crate) characters: Vec<SessionCharacter>,
    /// Counters of the server.
    pub(crate) sent: SessionStatistics,
    /// What the client says that it shows.
    pub(crate) shown: ShownReport,
}

/// A character of a session.
#[derive(Debug, Clone, Default, Serialize)]
pub(crate) struct SessionCharacter {
    pub(crate) name: String,
    /// The motion that plays, and the time within it as the client told it last: where another device goes on.
    pub(crate) clip: Option<String>,
    pub(crate) position_secs: f64,
    /// Level of quality that the bandwidth carries, and their number.
    pub(crate) level: usize,
    pub(crate) levels: usize,
    /// Whether all that the context asks for was sent.
    pub(crate) is_complete: bool,
}

/// The sessions of a server.
#[derive(Debug)]
pub(crate) struct Sessions {
    places: Arc<Semaphore>,
    all: Mutex<(u64, BTreeMap<u64, SessionReport>)>,
}

/// A session that is open; it leaves the list when this is dropped.
#[derive(Debug)]
pub(crate) struct OpenSession {
    sessions: Arc<Sessions>,
    number: u64,
    _place: OwnedSemaphorePermit,
}

impl Sessions {
    pub(crate) fn new(most: usize) -> Arc<Self> {
        Arc::new(Self {
            places: Arc::new(Semaphore::new(most.min(Semaphore::MAX_PERMITS))),
            all: Mutex::default(),
        })
    }

    /// Opens a session; `None` if there are too many.
    pub(crate) fn open(self: &Arc<Self>) -> Option<OpenSession> {
        let place = Arc::clone(&self.places).try_acquire_owned().ok()?;
        let mut all = self.lock();
        all.0 += 1;
        let number = all.0;
        let report = SessionReport {
            number,
            ..SessionReport::default()
        };
        all.1.insert(number, report);
        Some(OpenSession {
            sessions: Arc::clone(self),
            number,
            _place: place,
        })
    }

    /// Returns all sessions that are open.
    pub(crate) fn reports(&self) -> Vec<SessionReport> {
        self.lock().1.values().cloned().collect()
    }

    fn lock(&self) -> MutexGuard<'_, (u64, BTreeMap<u64, SessionReport>)> {
        self.all.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl OpenSession {
    /// Changes what is shown.
    pub(crate) fn report(&self, change: impl FnOnce(&mut SessionReport)) {
        if let Some(report) = self.sessions.lock().1.get_mut(&self.number) {
            change(report);
        }
    }
}

impl Drop for OpenSession {
    fn drop(&mut self) {
        self.sessions.lock().1.remove(&self.number);
    }
}
