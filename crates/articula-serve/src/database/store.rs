//! A catalogue: one connection that writes, and others that read meanwhile.
#![allow(clippy::disallowed_methods, reason = "the store is a folder")]

use super::connection::reading;
use super::fault::fault;
use super::opening::{to_read, to_write};
use super::schema::migrate;
use super::turn::Turn;
use crate::error::ServeError;
use crate::stamp::{Identity, identity};
use rusqlite::{Connection, Transaction, TransactionBehavior};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Connections for reading that are kept.
const MOST_READERS: usize = 8;

/// The catalogue of a store. Calls wait for files: not for threads of the runtime.
#[derive(Debug)]
pub(crate) struct Database {
    place: PathBuf,
    kind: Kind,
    /// Closed before the writer, which as the last one moves the log into the file and removes it.
    readers: Mutex<Vec<Connection>>,
    writer: Mutex<Writer>,
}

/// How a catalogue is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// It is written, by this server alone.
    Written,
    /// It is only read.
    Read,
    /// There is no file, and none may be made.
    InMemory,
}

/// The connection that writes.
#[derive(Debug)]
struct Writer {
    db: Connection,
    /// The file that it writes; another one may take its place.
    identity: Option<Identity>,
    turn: Option<Turn>,
}

/// A catalogue that was opened, and what whoever runs the server should know of it.
#[derive(Debug)]
pub(crate) struct Opened {
    pub(crate) database: Database,
    pub(crate) note: Option<String>,
}

impl Database {
    /// Opens a catalogue for writing; without a file one is made. A damaged one is moved away and made anew, if it is
    /// one for sure: by its head, or since nothing else can be there (`is_ours`).
    ///
    /// # Errors
    /// [`ServeError::Store`] for a file of another program or of a later version, and for one that another server writes.
    pub(crate) fn open(place: &Path, is_ours: bool) -> Result<Opened, ServeError> {
        let (writer, note) = Writer::open(place, is_ours)?;
        let database = Self::new(place, Kind::Written, writer);
        Ok(Opened { database, note })
    }

    /// Opens a catalogue for reading; without a file it is in memory, empty, and can be filled.
    ///
    /// # Errors
    /// [`ServeError::Store`] for a file that is damaged, of another program or of another version.
    pub(crate) fn open_read_only(place: &Path) -> Result<Self, ServeError> {
        let (kind, db) = match to_read(place)? {
            Some(db) => (Kind::Read, db),
            None => (
                Kind::InMemory,
                in_memory().map_err(|error| fault(place, &error))?,
            ),
        };
        let writer = Writer {
            db,
            identity: None,
            turn: None,
        };
        Ok(Self::new(place, kind, writer))
    }

    fn new(place: &Path, kind: Kind, writer: Writer) -> Self {
        Self {
            place: place.to_path_buf(),
            kind,
            writer: Mutex::new(writer),
            readers: Mutex::default(),
        }
    }

    /// Whether rows can be written: to a file, or in memory.
    pub(crate) fn takes_rows(&self) -> bool {
        self.kind != Kind::Read
    }

    /// Writes rows, all or none.
    ///
    /// # Errors
    /// [`ServeError::Full`], [`ServeError::Locked`] while another program writes for long, and [`ServeError::Store`].
    pub(crate) fn write<T>(
        &self,
        work: impl FnOnce(&Connection) -> rusqlite::Result<T>,
    ) -> Result<T, ServeError> {
        let mut writer = self.current()?;
        let written = Transaction::new(&mut writer.db, TransactionBehavior::Immediate);
        let written = written.and_then(|all| {
            let made = work(&all)?;
            all.commit()?;
            Ok(made)
        });
        written.map_err(|error| fault(&self.place, &error))
    }

    /// Reads rows as they were at one time, also while others are written.
    ///
    /// # Errors
    /// [`ServeError::Store`].
    pub(crate) fn read<T>(
        &self,
        work: impl FnOnce(&Connection) -> rusqlite::Result<T>,
    ) -> Result<T, ServeError> {
        let of = |error| fault(&self.place, &error);
        if self.kind != Kind::Written {
            return snapshot(&lock(&self.writer).db, work).map_err(of);
        }
        let kept = lock(&self.readers).pop();
        let db = kept.map_or_else(|| reading(&self.place), Ok).map_err(of)?;
        let found = snapshot(&db, work).map_err(of)?;
        let mut readers = lock(&self.readers);
        if readers.len() < MOST_READERS {
            readers.push(db);
        }
        Ok(found)
    }

    /// Checks that the file is there and can be read.
    ///
    /// # Errors
    /// [`ServeError::Store`].
    pub(crate) fn check(&self) -> Result<(), ServeError> {
        if self.kind != Kind::InMemory {
            let there = self.place.metadata();
            there.map_err(|error| ServeError::store(&self.place, &error))?;
        }
        self.read(|db| db.query_row("SELECT count(*) FROM jobs WHERE 0", [], |_| Ok(())))
    }

    /// The connection that writes: of a new file, where that of the old one was removed or replaced.
    fn current(&self) -> Result<MutexGuard<'_, Writer>, ServeError> {
        let mut writer = lock(&self.writer);
        if self.kind == Kind::Written && identity(&self.place) != writer.identity {
            // Its own lock would keep it from the new one.
            writer.turn = None;
            (*writer, _) = Writer::open(&self.place, false)?;
            lock(&self.readers).clear();
        }
        Ok(writer)
    }
}

impl Writer {
    fn open(place: &Path, is_ours: bool) -> Result<(Self, Option<String>), ServeError> {
        let folder = place.parent().unwrap_or(Path::new(""));
        std::fs::create_dir_all(folder).map_err(|error| ServeError::store(folder, &error))?;
        let turn = Turn::take(place)?;
        let (db, note) = to_write(place, is_ours)?;
        let writer = Self {
            db,
            identity: identity(place),
            turn: Some(turn),
        };
        Ok((writer, note))
    }
}

fn in_memory() -> rusqlite::Result<Connection> {
    let mut db = Connection::open_in_memory()?;
    db.pragma_update(None, "foreign_keys", true)?;
    migrate(&mut db)?;
    Ok(db)
}

/// Several statements see the same rows.
fn snapshot<T>(
    db: &Connection,
    work: impl FnOnce(&Connection) -> rusqlite::Result<T>,
) -> rusqlite::Result<T> {
    let all = Transaction::new_unchecked(db, TransactionBehavior::Deferred)?;
    let found = work(&all)?;
    all.commit()?;
    Ok(found)
}

fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}
