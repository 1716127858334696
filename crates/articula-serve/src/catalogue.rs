//! The characters of a folder, and the state of each.

use crate::error::ServeError;
use crate::making::Making;
use crate::metrics::Metrics;
use crate::objects::{Objects, write};
use crate::options::ServeOptions;
use crate::packed::is_packed;
use crate::plans::Plans;
use crate::record::{Records, Served};
use crate::sessions::Sessions;
use crate::source::{PACKED, Source, names, remove_source, sources};
use articula::Format;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, RwLock};
use tokio::sync::{Semaphore, watch};

/// Folder of what the server makes, in that of the characters.
const MADE: &str = ".articula";
/// Longest name in bytes.
const LONGEST: usize = 100;

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

/// The state of a character.
#[derive(Debug, Clone)]
pub struct CharacterState {
    /// How far it is.
    pub progress: Progress,
    /// What of it is served.
    pub(crate) served: Option<Served>,
}

/// A character that waited to be packaged.
#[derive(Debug)]
pub(crate) struct Waiting {
    name: String,
    pub(crate) file: PathBuf,
    generation: u64,
}

/// A character of the folder.
#[derive(Debug)]
struct Character {
    file: PathBuf,
    /// The file of the record of what it was packaged to.
    record: PathBuf,
    /// Raised with each file of this name.
    generation: u64,
    state: watch::Sender<CharacterState>,
}

/// The characters of a folder; clones share them.
#[derive(Debug, Clone)]
pub struct Catalogue(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    root: PathBuf,
    options: ServeOptions,
    objects: Objects,
    records: Records,
    made: Making,
    uploads: Semaphore,
    metrics: Metrics,
    sessions: Arc<Sessions>,
    plans: Plans,
    /// Raised whenever the state of a character changes.
    news: watch::Sender<u64>,
    characters: RwLock<BTreeMap<String, Character>>,
    /// Names of those that wait.
    queue: Mutex<VecDeque<String>>,
    arrived: Condvar,
}

impl Catalogue {
    /// Opens a folder: every `.glb`, `.vrm` and `.fbx` in it is a character, by the name of the file without its
    /// extension, and so is every item in a `.zip` or in a folder of its own. What was packaged before is ready at once.
    ///
    /// # Errors
    /// [`ServeError::Store`] with the folder or file that cannot be read.
    pub fn open(root: &Path, options: &ServeOptions) -> Result<Self, ServeError> {
        let made = root.join(MADE);
        let catalogue = Self(Arc::new(Shared {
            root: root.to_path_buf(),
            objects: Objects::new(made.join("objects"), options),
            records: Records::new(made.join("items"), options),
            made: Making::new(made.join("queries"), options.packaging),
            uploads: Semaphore::new(options.most_uploads),
            options: options.clone(),
            metrics: Metrics::default(),
            sessions: Sessions::new(options.most_sessions),
            plans: Plans::default(),
            news: watch::Sender::new(0),
            characters: RwLock::default(),
            queue: Mutex::default(),
            arrived: Condvar::new(),
        }));
        for file in sources(root)? {
            let (stem, name) = names(&file);
            let is_free = catalogue.state(&stem).is_none();
            catalogue.add(if is_free { stem } else { name }, file)?;
        }
        Ok(catalogue)
    }

    /// Returns the names of all characters with their states, by name.
    pub fn states(&self) -> Vec<(String, CharacterState)> {
        let characters = read_lock(&self.0.characters);
        let states = characters.iter();
        states
            .map(|(name, c)| (name.clone(), c.state.borrow().clone()))
            .collect()
    }

    /// Returns the state of a character.
    pub fn state(&self, name: &str) -> Option<CharacterState> {
        let characters = read_lock(&self.0.characters);
        characters.get(name).map(|c| c.state.borrow().clone())
    }

    /// Tells every later state of a character.
    pub(crate) fn watch(&self, name: &str) -> Option<watch::Receiver<CharacterState>> {
        let characters = read_lock(&self.0.characters);
        characters.get(name).map(|c| c.state.subscribe())
    }

    /// Stores a character under a name, which then waits to be packaged; one of this name is replaced.
    ///
    /// # Errors
    /// [`ServeError::Name`], [`ServeError::Form`] for other bytes than those of a binary glTF, an FBX or an item in one
    /// file, and [`ServeError::Store`].
    pub fn put(&self, name: &str, bytes: &[u8]) -> Result<CharacterState, ServeError> {
        check_name(name)?;
        let extension = match Format::from_bytes(bytes, "") {
            Some(Format::Glb) => "glb",
            Some(Format::Fbx) => "fbx",
            None if is_packed(bytes) => PACKED,
            _ => return Err(ServeError::Form),
        };
        let file = self.0.root.join(format!("{name}.{extension}"));
        write(&file, bytes)?;
        let before = read_lock(&self.0.characters)
            .get(name)
            .map(|c| c.file.clone());
        if let Some(before) = before.filter(|before| *before != file) {
            remove_source(&before)?;
        }
        self.add(name.to_owned(), file)
    }

    /// Removes a character and its file or folder; returns whether there was one. What is made of it stays until the next
    /// server begins, as the same file may come again.
    ///
    /// # Errors
    /// [`ServeError::Store`] if the file cannot be removed; the character stays then.
    pub fn remove(&self, name: &str) -> Result<bool, ServeError> {
        let mut characters = self
            .0
            .characters
            .write()
            .unwrap_or_else(PoisonError::into_inner);
        let Some(known) = characters.get(name) else {
            return Ok(false);
        };
        remove_source(&known.file)?;
        characters.remove(name);
        drop(characters);
        self.0.news.send_modify(|count| *count += 1);
        Ok(true)
    }

    fn add(&self, name: String, file: PathBuf) -> Result<CharacterState, ServeError> {
        let source = Source::read(&file)?;
        let record = self.0.records.path(&source);
        let served = self.0.records.get(&record, &self.0.objects)?;
        let progress = match (&served, self.0.options.read_only) {
            (Some(_), _) => Progress::Ready,
            (None, true) => {
                Progress::Failed("it is not packaged, and the store is read-only".into())
            }
            (None, false) => Progress::Waiting,
        };
        let waits = progress == Progress::Waiting;
        let state = CharacterState { progress, served };
        let mut characters = self
            .0
            .characters
            .write()
            .unwrap_or_else(PoisonError::into_inner);
        match characters.get_mut(&name) {
            Some(known) => {
                (known.file, known.record) = (file, record);
                known.generation += 1;
                known.state.send_replace(state.clone());
            }
            None => {
                let sender = watch::Sender::new(state.clone());
                let character = Character {
                    file,
                    record,
                    generation: 0,
                    state: sender,
                };
                characters.insert(name.clone(), character);
            }
        }
        drop(characters);
        self.0.news.send_modify(|count| *count += 1);
        if waits {
            let mut queue = self.queue();
            queue.retain(|other| *other != name);
            queue.push_back(name);
            self.0.arrived.notify_one();
        }
        Ok(state)
    }

    /// The next character to package; blocks until there is one, or `is_over`.
    pub(crate) fn next(&self, is_over: impl Fn() -> bool) -> Option<Waiting> {
        let mut queue = self.queue();
        loop {
            if is_over() {
                return None;
            }
            if let Some(name) = queue.pop_front() {
                if let Some(character) = read_lock(&self.0.characters).get(&name) {
                    return Some(Waiting {
                        file: character.file.clone(),
                        generation: character.generation,
                        name,
                    });
                }
                continue;
            }
            queue = self
                .0
                .arrived
                .wait(queue)
                .unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Wakes who waits for a character.
    pub(crate) fn wake(&self) {
        let _queue = self.queue();
        self.0.arrived.notify_all();
    }

    fn queue(&self) -> MutexGuard<'_, VecDeque<String>> {
        self.0.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sets how far a character is, and what of it is served, if that is news; nothing, if it was replaced
    /// since.
    pub(crate) fn set(&self, of: &Waiting, progress: Progress, served: Option<Served>) {
        let characters = read_lock(&self.0.characters);
        let character = characters.get(&of.name);
        if let Some(character) = character.filter(|c| c.generation == of.generation) {
            character.state.send_modify(|state| {
                state.progress = progress;
                state.served = served.or_else(|| state.served.take());
            });
            self.0.news.send_modify(|count| *count += 1);
        }
    }

    /// Tells of every change of the state of any character.
    pub(crate) fn news(&self) -> watch::Receiver<u64> {
        self.0.news.subscribe()
    }

    pub(crate) fn sessions(&self) -> &Arc<Sessions> {
        &self.0.sessions
    }

    pub(crate) fn plans(&self) -> &Plans {
        &self.0.plans
    }

    pub(crate) fn options(&self) -> &ServeOptions {
        &self.0.options
    }

    /// A folder in that of what the server makes.
    pub(crate) fn folder(&self, name: &str) -> PathBuf {
        self.0.root.join(MADE).join(name)
    }

    pub(crate) fn objects(&self) -> &Objects {
        &self.0.objects
    }

    /// The records of the sources of all characters, whether they are there or not.
    pub(crate) fn record_files(&self) -> BTreeSet<PathBuf> {
        let characters = read_lock(&self.0.characters);
        characters.values().map(|c| c.record.clone()).collect()
    }

    pub(crate) fn records(&self) -> &Records {
        &self.0.records
    }

    pub(crate) fn made(&self) -> &Making {
        &self.0.made
    }

    /// Places for characters that are put.
    pub(crate) fn uploads(&self) -> &Semaphore {
        &self.0.uploads
    }

    pub(crate) fn metrics(&self) -> &Metrics {
        &self.0.metrics
    }

    /// Checks that the folder can be read.
    pub(crate) fn check(&self) -> Result<(), ServeError> {
        sources(&self.0.root).map(drop)
    }
}

fn read_lock(
    characters: &RwLock<BTreeMap<String, Character>>,
) -> std::sync::RwLockReadGuard<'_, BTreeMap<String, Character>> {
    characters.read().unwrap_or_else(PoisonError::into_inner)
}

/// Checks a name that a client gives.
fn check_name(name: &str) -> Result<(), ServeError> {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    let is_name = (1..=LONGEST).contains(&name.len()) && name.chars().all(is_plain);
    match is_name && !name.starts_with('.') {
        true => Ok(()),
        false => Err(ServeError::Name(name.chars().take(LONGEST).collect())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_in_the_folder() {
        for name in ["knight", "Knight-2_b.x", "a"] {
            assert!(check_name(name).is_ok(), "{name}");
        }
        let long = "a".repeat(LONGEST + 1);
        for name in [
            "",
            ".",
            "..",
            ".articula",
            "a/b",
            "a\\b",
            "a b",
            "ä",
            "%2e",
            &long,
        ] {
            assert!(check_name(name).is_err(), "{name}");
        }
    }
}
