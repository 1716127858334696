//! Connections to the file of a catalogue: for writing, for reading, and where nothing may be written.
#![allow(clippy::disallowed_methods, reason = "the store is a folder")]

use super::fault::fault_of_reading;
use crate::error::ServeError;
use rusqlite::{Connection, OpenFlags};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Time that a transaction of another program has to end.
const PATIENCE: Duration = Duration::from_secs(5);

/// A file beside a catalogue, which SQLite names so.
pub(super) fn beside(place: &Path, suffix: &str) -> PathBuf {
    let mut name = place.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}

/// Opens a file for writing; it is made if it is not there. Nothing is written yet: it may be another program's.
pub(super) fn writing(place: &Path) -> rusqlite::Result<Connection> {
    let flags = OpenFlags::SQLITE_OPEN_READ_WRITE
        | OpenFlags::SQLITE_OPEN_CREATE
        | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let db = Connection::open_with_flags(place, flags)?;
    db.busy_timeout(PATIENCE)?;
    Ok(db)
}

/// Sets how a file is written.
pub(super) fn set_up(db: &Connection) -> rusqlite::Result<()> {
    // Readers go on beside a writer, and what was committed is on the disk.
    db.query_row("PRAGMA journal_mode = WAL", [], |_| Ok(()))?;
    db.pragma_update(None, "synchronous", "FULL")?;
    db.pragma_update(None, "foreign_keys", true)
}

/// Opens a file that is there for reading.
pub(super) fn reading(place: &Path) -> rusqlite::Result<Connection> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    opened(Connection::open_with_flags(place, flags)?)
}

/// Opens a file for reading also where SQLite can make no files beside it.
///
/// # Errors
/// [`ServeError::Store`] if changes lie in a log beside it that cannot be read without writing.
pub(super) fn reading_only(place: &Path) -> Result<Connection, ServeError> {
    let error = match reading(place) {
        Ok(db) => return Ok(db),
        Err(error) => error,
    };
    let log = beside(place, "-wal");
    if log.metadata().is_ok_and(|of| of.len() > 0) {
        let what = "the log of changes of the catalogue cannot be read without permission to write beside it; \
                    start the server once with that permission and stop it";
        return Err(ServeError::Store {
            place: log.display().to_string(),
            what: what.to_owned(),
        });
    }
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY
        | OpenFlags::SQLITE_OPEN_NO_MUTEX
        | OpenFlags::SQLITE_OPEN_URI;
    // Nobody changes a file without a log in a folder where nobody can make one.
    let unchanging = Connection::open_with_flags(uri(place), flags).and_then(opened);
    // If that fails too, the first error tells why.
    unchanging.map_err(|_| fault_of_reading(place, &error))
}

/// A connection that can read, which shows with its first statement only.
fn opened(db: Connection) -> rusqlite::Result<Connection> {
    db.busy_timeout(PATIENCE)?;
    db.query_row("SELECT count(*) FROM sqlite_schema", [], |_| Ok(()))?;
    Ok(db)
}

/// The URI of a file that does not change (SQLite, "Uniform Resource Identifiers").
fn uri(place: &Path) -> String {
    let mut uri = String::from("file:");
    for byte in place.to_string_lossy().replace('\\', "/").bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b'-' | b'_' | b'.' | b':' => {
                uri.push(byte.into());
            }
            _ => uri.push_str(&format!("%{byte:02X}")),
        }
    }
    uri + "?immutable=1"
}

#[cfg(unix)]
#[cfg(test)]
mod tests {
    use super::*;

    /// A catalogue of one table, as a server leaves it that was stopped, where SQLite can make no files beside it.
    fn closed(name: &str) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join(name);
        let db = writing(&place).unwrap();
        set_up(&db).unwrap();
        db.execute_batch("CREATE TABLE t (a)").unwrap();
        drop(db);
        assert!(!beside(&place, "-wal").exists());
        // Not even for who may write everywhere: SQLite follows no link there.
        let shared = beside(&place, "-shm");
        std::os::unix::fs::symlink(&shared, &shared).unwrap();
        (folder, place)
    }

    fn tables(db: &Connection) -> i64 {
        db.query_row("SELECT count(*) FROM sqlite_schema", [], |row| row.get(0))
            .unwrap()
    }

    #[test]
    fn a_file_is_read_where_nothing_can_be_written_beside_it() {
        for name in ["catalogue.sqlite3", "cat alogue?%#ä.sqlite3"] {
            let (_folder, place) = closed(name);
            assert!(reading(&place).is_err(), "SQLite alone cannot");
            assert_eq!(tables(&reading_only(&place).unwrap()), 1, "{name}");
        }
    }

    #[test]
    fn changes_in_a_log_that_cannot_be_read_are_not_left_out() {
        let (_folder, place) = closed("catalogue.sqlite3");
        std::fs::write(beside(&place, "-wal"), b"changes").unwrap();
        let error = reading_only(&place).unwrap_err().to_string();
        assert!(
            error.contains("-wal: ") && error.contains("permission"),
            "{error}"
        );
    }

    #[test]
    fn what_is_not_there_is_not_made_by_reading() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("catalogue.sqlite3");
        let error = reading_only(&place).unwrap_err().to_string();
        assert!(error.contains("cannot be opened"), "{error}");
        assert!(!place.exists());
    }
}
