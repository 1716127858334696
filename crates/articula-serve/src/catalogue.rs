//! The characters of a folder: their files, their rows in the catalogue, and what is told of them.

use crate::database::characters::CharacterRow;
use crate::database::jobs::{self, JobState};
use crate::database::{Database, Opened, characters, variants};
use crate::error::ServeError;
use crate::found::{Found, file_of};
use crate::making::Making;
use crate::metrics::Metrics;
use crate::objects::{Objects, write};
use crate::options::ServeOptions;
use crate::packed::is_packed;
use crate::plans::Plans;
use crate::queue::Queue;
use crate::served::Served;
use crate::sessions::Sessions;
use crate::source::{PACKED, names, remove_source, sources};
use crate::state::{CharacterState, Characters, Progress};
use crate::takeover::take_over;
use articula::Format;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::Semaphore;

/// Folder of what the server makes, in that of the characters.
const MADE: &str = ".articula";
/// The catalogue, in that folder.
const DATABASE: &str = "catalogue.sqlite3";
/// Longest name in bytes.
const LONGEST: usize = 100;

/// A job that a thread has.
#[derive(Debug)]
pub(crate) struct Taken {
    pub(crate) job: String,
    pub(crate) path: PathBuf,
}

/// The characters of a folder; clones share them.
#[derive(Debug, Clone)]
pub struct Catalogue(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    root: PathBuf,
    options: ServeOptions,
    objects: Objects,
    database: Database,
    notes: Vec<String>,
    made: Making,
    uploads: Semaphore,
    metrics: Metrics,
    sessions: Arc<Sessions>,
    plans: Plans,
    characters: Characters,
    queue: Queue,
    /// One file is stored or removed at a time, so that its row says what there is.
    change: Mutex<()>,
}

impl Catalogue {
    /// Opens a folder: every `.glb`, `.vrm` and `.fbx` in it is a character, by the name of the file without its
    /// extension, and so is every item in a `.zip` or in a folder of its own. What was packaged before is ready at once.
    ///
    /// # Errors
    /// [`ServeError::Store`] with the folder or file that cannot be read or written, and what mends it;
    /// [`ServeError::Locked`] if another program writes to the catalogue for long.
    pub fn open(root: &Path, options: &ServeOptions) -> Result<Self, ServeError> {
        let made = root.join(MADE);
        let objects = Objects::new(made.join("objects"), options);
        let place = options.catalogue.clone();
        let is_ours = place.is_none();
        let place = place.unwrap_or_else(|| made.join(DATABASE));
        let opened = match options.read_only {
            true => Opened {
                database: Database::open_read_only(&place)?,
                note: None,
            },
            false => Database::open(&place, is_ours)?,
        };
        let Opened { database, note } = opened;
        let taken = take_over(&made, &objects, &database, options.read_only)?;
        let catalogue = Self(Arc::new(Shared {
            root: root.to_path_buf(),
            objects,
            made: Making::new(database.read(variants::count)?, options.packaging),
            database,
            notes: note.into_iter().chain(taken).collect(),
            uploads: Semaphore::new(options.most_uploads),
            options: options.clone(),
            metrics: Metrics::default(),
            sessions: Sessions::new(options.most_sessions),
            plans: Plans::default(),
            characters: Characters::new(),
            queue: Queue::default(),
            change: Mutex::default(),
        }));
        catalogue.find()?;
        Ok(catalogue)
    }

    /// Finds the characters of the folder, and lets those wait that are not packaged.
    fn find(&self) -> Result<(), ServeError> {
        let known = self.0.database.read(characters::all)?;
        let by_file: BTreeMap<_, _> = known.iter().map(|row| (&row.file, row)).collect();
        let mut found = BTreeMap::new();
        for path in sources(&self.0.root)? {
            let row = by_file.get(&file_of(&path)).copied();
            let of = Found::new(path, row, self.options())?;
            let (stem, name) = names(&of.path);
            let name = if found.contains_key(&stem) {
                name
            } else {
                stem
            };
            let state = self.state_of(&of.job)?;
            found.insert(name, (of, state));
        }
        if !self.options().read_only {
            self.record(&known, &found)?;
        }
        for (name, (of, state)) in found {
            self.show(name, of, state);
        }
        Ok(())
    }

    /// Records what was found, where it is not what was known.
    fn record(
        &self,
        known: &[CharacterRow],
        found: &BTreeMap<String, (Found, CharacterState)>,
    ) -> Result<(), ServeError> {
        let by_name: BTreeMap<_, _> = known.iter().map(|row| (&row.name, row)).collect();
        self.0.database.write(|db| {
            jobs::take_up(db)?;
            for (name, (of, state)) in found {
                if state.progress == Progress::Waiting {
                    jobs::wait(db, &of.job)?;
                }
                let row = of.row(name);
                if by_name.get(name) != Some(&&row) {
                    characters::put(db, &row)?;
                }
            }
            for row in known.iter().filter(|row| !found.contains_key(&row.name)) {
                characters::remove(db, &row.name)?;
            }
            Ok(())
        })
    }

    /// How far a job is when its character is found.
    fn state_of(&self, job: &str) -> Result<CharacterState, ServeError> {
        let known = self.0.database.read(|db| jobs::get(db, job))?;
        let ready = known.as_ref().filter(|of| of.state == JobState::Ready);
        let item = ready.and_then(|of| of.item.as_deref());
        let served = item.and_then(|item| Served::find(item, &self.0.objects));
        let progress = match (&served, self.options().read_only) {
            (Some(_), _) => Progress::Ready,
            (None, false) => Progress::Waiting,
            (None, true) => {
                let why = known.and_then(|of| of.why);
                let not_packaged = || "it is not packaged, and the store is read-only".to_owned();
                Progress::Failed(why.unwrap_or_else(not_packaged))
            }
        };
        Ok(CharacterState { progress, served })
    }

    /// Shows a character, which may wait.
    fn show(&self, name: String, of: Found, state: CharacterState) {
        let waits = state.progress == Progress::Waiting;
        let job = of.job.clone();
        self.0.characters.put(name, of.path, of.job, state);
        if waits {
            self.0.queue.push(job);
        }
    }

    /// Returns the names of all characters with their states, by name.
    pub fn states(&self) -> Vec<(String, CharacterState)> {
        self.0.characters.states()
    }

    /// Returns the state of a character.
    pub fn state(&self, name: &str) -> Option<CharacterState> {
        self.0.characters.state(name)
    }

    /// Returns what whoever runs the server should know, a line each: that the catalogue was damaged, and what was taken over
    /// of an earlier version.
    pub fn notes(&self) -> &[String] {
        &self.0.notes
    }

    /// Stores a character under a name, which then waits to be packaged; one of this name is replaced.
    ///
    /// # Errors
    /// [`ServeError::Name`], [`ServeError::Form`] for other bytes than those of a binary glTF, an FBX or an item in one
    /// file, [`ServeError::Full`], [`ServeError::Locked`] and [`ServeError::Store`].
    pub fn put(&self, name: &str, bytes: &[u8]) -> Result<CharacterState, ServeError> {
        check_name(name)?;
        let extension = match Format::from_bytes(bytes, "") {
            Some(Format::Glb) => "glb",
            Some(Format::Fbx) => "fbx",
            None if is_packed(bytes) => PACKED,
            _ => return Err(ServeError::Form),
        };
        let file = self.0.root.join(format!("{name}.{extension}"));
        let _change = self.change();
        let before = self.0.characters.path(name);
        write(&file, bytes)?;
        if let Some(before) = before.as_ref().filter(|before| **before != file) {
            remove_source(before)?;
        }
        let added = self.add(name.to_owned(), file.clone());
        if added.is_err() && before.is_none() {
            // What was not accepted is not there at the next start.
            let _ = remove_source(&file);
        }
        added
    }

    /// Removes a character and its file or folder; returns whether there was one. What is made of it stays until the next
    /// server begins, as the same file may come again.
    ///
    /// # Errors
    /// [`ServeError::Store`] if the file cannot be removed; the character stays then.
    pub fn remove(&self, name: &str) -> Result<bool, ServeError> {
        let _change = self.change();
        let Some(path) = self.0.characters.path(name) else {
            return Ok(false);
        };
        remove_source(&path)?;
        self.0.characters.remove(name);
        self.0.database.write(|db| characters::remove(db, name))?;
        Ok(true)
    }

    fn change(&self) -> MutexGuard<'_, ()> {
        self.0.change.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn add(&self, name: String, path: PathBuf) -> Result<CharacterState, ServeError> {
        let of = Found::new(path, None, self.options())?;
        let state = self.state_of(&of.job)?;
        let row = of.row(&name);
        self.0.database.write(|db| {
            match &state.served {
                Some(served) => jobs::finish(db, &row.job, &served.row())?,
                None => jobs::wait(db, &row.job)?,
            }
            characters::put(db, &row)
        })?;
        self.show(name, of, state.clone());
        Ok(state)
    }

    /// The next job; blocks until there is one, or `is_over`.
    pub(crate) fn take(&self, is_over: impl Fn() -> bool) -> Option<Taken> {
        loop {
            let job = self.0.queue.take(&is_over)?;
            match self.0.characters.path_of_job(&job) {
                Some(path) => return Some(Taken { job, path }),
                // Its character is gone.
                None => self.0.queue.done(&job),
            }
        }
    }

    /// Wakes who waits for a job.
    pub(crate) fn wake(&self) {
        self.0.queue.wake();
    }

    /// A job is given back.
    pub(crate) fn done(&self, of: &Taken) {
        self.0.queue.done(&of.job);
    }

    /// Begins a job; returns whether it is to be done. It may be done already, for another file with the same bytes.
    pub(crate) fn begin(&self, of: &Taken) -> Result<bool, ServeError> {
        let known = self.state_of(&of.job)?;
        if known.served.is_some() {
            let served = known.served.as_ref();
            self.0.characters.set(&of.job, &known.progress, served);
            return Ok(false);
        }
        self.0.database.write(|db| jobs::begin(db, &of.job))?;
        self.0.characters.set(&of.job, &Progress::Packaging, None);
        Ok(true)
    }

    /// A stage of a job is made.
    pub(crate) fn stage(&self, of: &Taken, served: &Served) -> Result<(), ServeError> {
        let row = served.row();
        match self.0.database.write(|db| jobs::stage(db, &of.job, &row)) {
            // It is served; only the row is late.
            Ok(()) | Err(ServeError::Locked { .. }) => {}
            Err(error) => return Err(error),
        }
        self.0
            .characters
            .set(&of.job, &Progress::Packaging, Some(served));
        Ok(())
    }

    /// A job is done.
    pub(crate) fn finish(&self, of: &Taken, served: &Served) -> Result<(), ServeError> {
        let row = served.row();
        let finish = |db: &_| jobs::finish(db, &of.job, &row);
        self.0.database.write(finish)?;
        Metrics::add(&self.0.metrics.packaged, 1);
        self.0
            .characters
            .set(&of.job, &Progress::Ready, Some(served));
        Ok(())
    }

    /// A job cannot be done. A catalogue that does not take this either is told of by the reason.
    pub(crate) fn fail(&self, of: &Taken, error: &ServeError) {
        let why = error.to_string();
        let _ = self.0.database.write(|db| jobs::fail(db, &of.job, &why));
        self.0.characters.set(&of.job, &Progress::Failed(why), None);
    }

    /// The file of a job is another one by now: its characters are found anew.
    pub(crate) fn renew(&self, of: &Taken) -> Result<(), ServeError> {
        let _change = self.change();
        for name in self.0.characters.names_of_job(&of.job, &of.path) {
            self.add(name, of.path.clone())?;
        }
        // Another file may have the bytes that this one had.
        if self.0.characters.path_of_job(&of.job).is_some() {
            self.0.queue.push(of.job.clone());
        }
        Ok(())
    }

    pub(crate) fn characters(&self) -> &Characters {
        &self.0.characters
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

    pub(crate) fn database(&self) -> &Database {
        &self.0.database
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

    /// Checks that the folder and the catalogue can be read.
    pub(crate) fn check(&self) -> Result<(), ServeError> {
        sources(&self.0.root)?;
        self.0.database.check()
    }
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
