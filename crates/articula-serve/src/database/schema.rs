//! The tables of a catalogue, and how those of an earlier version become them.

use rusqlite::{Connection, Transaction, TransactionBehavior};

/// Marks the file as ours: "Arti" in ASCII, at byte 68 of it.
pub(super) const APPLICATION_ID: i32 = 0x4172_7469;

/// What each version adds to the one before; `user_version` counts those that were done.
const MIGRATIONS: [&str; 1] = [include_str!("version_1.sql")];

/// The version of this program.
pub(super) const VERSION: i32 = MIGRATIONS.len() as i32;

/// The version of a file; 0 for one that is empty.
pub(super) fn version(db: &Connection) -> rusqlite::Result<i32> {
    db.query_row("PRAGMA user_version", [], |row| row.get(0))
}

/// Whether a file is ours, or empty.
pub(super) fn is_ours(db: &Connection) -> rusqlite::Result<bool> {
    let id: i32 = db.query_row("PRAGMA application_id", [], |row| row.get(0))?;
    let tables: i64 = db.query_row("SELECT count(*) FROM sqlite_schema", [], |row| row.get(0))?;
    Ok(id == APPLICATION_ID || id == 0 && tables == 0)
}

/// Brings the tables of a file, which is not of a later version, to this one: all of it or nothing.
pub(super) fn migrate(db: &mut Connection) -> rusqlite::Result<()> {
    if version(db)? >= VERSION {
        return Ok(());
    }
    let all = Transaction::new(db, TransactionBehavior::Immediate)?;
    let done = usize::try_from(version(&all)?).unwrap_or_default();
    for migration in MIGRATIONS.iter().skip(done) {
        all.execute_batch(migration)?;
    }
    all.pragma_update(None, "application_id", APPLICATION_ID)?;
    all.pragma_update(None, "user_version", VERSION)?;
    all.commit()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_made_once_and_keep_to_their_types() {
        let mut db = Connection::open_in_memory().unwrap();
        assert!(is_ours(&db).unwrap());
        for _ in 0..2 {
            migrate(&mut db).unwrap();
            assert_eq!(version(&db).unwrap(), VERSION);
            assert!(is_ours(&db).unwrap());
        }
        for wrong in [
            "INSERT INTO items VALUES ('short', 1, 1)",
            "INSERT INTO items VALUES (hex(zeroblob(32)), 'many', 1)",
            "INSERT INTO jobs (job, state) VALUES (hex(zeroblob(32)), 'ready')",
            "INSERT INTO jobs (job, state) VALUES (hex(zeroblob(32)), 'failed')",
            "INSERT INTO jobs (job, state) VALUES (hex(zeroblob(32)), 'other')",
        ] {
            assert!(db.execute(wrong, []).is_err(), "{wrong}");
        }
    }

    #[test]
    fn tables_of_another_program_are_not_ours() {
        let db = Connection::open_in_memory().unwrap();
        db.execute_batch("CREATE TABLE addresses (name TEXT)")
            .unwrap();
        assert!(!is_ours(&db).unwrap());
    }
}
