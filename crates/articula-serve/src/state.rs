//! How far each character is, and who waits for news of it.

use crate::database::jobs::JobState;
use crate::served::Served;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};
use tokio::sync::watch;

/// How far a character is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case", tag = "state", content = "why")]
pub enum Progress {
    /// It waits for a thread that packages.
    Waiting,
    /// It is being packaged; stages are served.
    Packaging,
    /// All of it is served.
    Ready,
    /// It cannot be packaged, for this reason.
    Failed(String),
}

impl Progress {
    /// The same without the reason.
    pub(crate) fn state(&self) -> JobState {
        match self {
            Self::Waiting => JobState::Waiting,
            Self::Packaging => JobState::Packaging,
            Self::Ready => JobState::Ready,
            Self::Failed(_) => JobState::Failed,
        }
    }
}

/// The state of a character.
#[derive(Debug, Clone)]
pub struct CharacterState {
    /// How far it is.
    pub progress: Progress,
    /// What of it is served.
    pub(crate) served: Option<Served>,
}

/// A character of the folder.
#[derive(Debug)]
struct Character {
    path: PathBuf,
    /// What packages it; another one if another file takes its name.
    job: String,
    state: watch::Sender<CharacterState>,
}

/// All characters, by name.
#[derive(Debug)]
pub(crate) struct Characters {
    all: RwLock<BTreeMap<String, Character>>,
    /// Raised whenever the state of a character changes.
    news: watch::Sender<u64>,
}

impl Characters {
    pub(crate) fn new() -> Self {
        Self {
            all: RwLock::default(),
            news: watch::Sender::new(0),
        }
    }

    /// The names of all characters with their states, by name.
    pub(crate) fn states(&self) -> Vec<(String, CharacterState)> {
        let all = self.read();
        let states = all.iter();
        states
            .map(|(name, of)| (name.clone(), of.state.borrow().clone()))
            .collect()
    }

    /// Numbers of characters in each state.
    pub(crate) fn counts(&self) -> [(JobState, usize); 4] {
        let all = self.read();
        let in_state = |state| {
            let states = all.values().map(|of| of.state.borrow().progress.state());
            (state, states.filter(|other| *other == state).count())
        };
        JobState::ALL.map(in_state)
    }

    pub(crate) fn state(&self, name: &str) -> Option<CharacterState> {
        let all = self.read();
        all.get(name).map(|of| of.state.borrow().clone())
    }

    /// Tells every later state of a character.
    pub(crate) fn watch(&self, name: &str) -> Option<watch::Receiver<CharacterState>> {
        self.read().get(name).map(|of| of.state.subscribe())
    }

    /// Tells of every change of the state of any character.
    pub(crate) fn news(&self) -> watch::Receiver<u64> {
        self.news.subscribe()
    }

    /// The file of a character.
    pub(crate) fn path(&self, name: &str) -> Option<PathBuf> {
        self.read().get(name).map(|of| of.path.clone())
    }

    /// The file of a character that a job packages.
    pub(crate) fn path_of_job(&self, job: &str) -> Option<PathBuf> {
        let all = self.read();
        let mut of_job = all.values().filter(|of| of.job == job);
        of_job.next().map(|of| of.path.clone())
    }

    /// The names of characters of a file that a job packages.
    pub(crate) fn names_of_job(&self, job: &str, path: &Path) -> Vec<String> {
        let all = self.read();
        let of_job = all
            .iter()
            .filter(|(_, of)| of.job == job && of.path == path);
        of_job.map(|(name, _)| name.clone()).collect()
    }

    /// Adds a character, or puts it in the place of one of the same name.
    pub(crate) fn put(&self, name: String, path: PathBuf, job: String, state: CharacterState) {
        let mut all = self.write();
        match all.get_mut(&name) {
            Some(known) => {
                (known.path, known.job) = (path, job);
                known.state.send_replace(state);
            }
            None => {
                let state = watch::Sender::new(state);
                all.insert(name, Character { path, job, state });
            }
        }
        drop(all);
        self.raise();
    }

    pub(crate) fn remove(&self, name: &str) {
        self.write().remove(name);
        self.raise();
    }

    /// Sets how far the characters of a job are, and what of them is served, if that is news.
    pub(crate) fn set(&self, job: &str, progress: &Progress, served: Option<&Served>) {
        for of in self.read().values().filter(|of| of.job == job) {
            of.state.send_modify(|state| {
                state.progress = progress.clone();
                state.served = served.cloned().or_else(|| state.served.take());
            });
        }
        self.raise();
    }

    fn raise(&self) {
        self.news.send_modify(|count| *count += 1);
    }

    fn read(&self) -> RwLockReadGuard<'_, BTreeMap<String, Character>> {
        self.all.read().unwrap_or_else(PoisonError::into_inner)
    }

    fn write(&self) -> RwLockWriteGuard<'_, BTreeMap<String, Character>> {
        self.all.write().unwrap_or_else(PoisonError::into_inner)
    }
}
