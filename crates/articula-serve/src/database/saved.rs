//! Files that are no catalogue, no longer one, or not for this server.
#![allow(clippy::disallowed_methods, reason = "the store is a folder")]

use super::characters::{self, CharacterRow};
use super::jobs::{self, ItemRow};
use super::{Database, Opened};
use std::fs::OpenOptions;
use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

fn hash(number: usize) -> String {
    format!("{number:0>64}")
}

fn open(place: &Path) -> Opened {
    Database::open(place, false).unwrap()
}

fn refused(place: &Path) -> String {
    Database::open(place, false).unwrap_err().to_string()
}

/// A catalogue of so many characters.
fn filled(place: &Path, characters: usize) {
    let database = open(place).database;
    let written = database.write(|db| {
        for number in 0..characters {
            let item = ItemRow {
                manifest: &hash(number),
                bytes: 1,
                sent_bytes: 1,
            };
            jobs::finish(db, &hash(number), &item)?;
            let row = CharacterRow {
                name: format!("n{number:0>4}"),
                file: "a.glb".to_owned(),
                stamp: None,
                source: hash(number),
                job: hash(number),
            };
            characters::put(db, &row)?;
        }
        Ok(())
    });
    written.unwrap();
}

fn overwrite(place: &Path, at: u64, bytes: &[u8]) {
    let mut file = OpenOptions::new().write(true).open(place).unwrap();
    file.seek(SeekFrom::Start(at)).unwrap();
    file.write_all(bytes).unwrap();
}

#[test]
fn what_can_be_read_of_a_damaged_catalogue_is_saved() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("catalogue.sqlite3");
    filled(&place, 500);
    // Pages in the middle of it.
    let length = place.metadata().unwrap().len();
    overwrite(&place, length / 2 / 4096 * 4096, &[0xff; 4096]);
    let error = Database::open_read_only(&place).unwrap_err().to_string();
    assert!(error.contains("without --read-only"), "{error}");
    let Opened { database, note } = open(&place);
    let note = note.unwrap();
    assert!(
        note.contains("damaged-1") && !note.contains(" 0 rows"),
        "{note}"
    );
    assert!(folder.path().join("catalogue.sqlite3.damaged-1").is_file());
    let left = database.read(characters::all).unwrap();
    assert!(left.len() > 100, "{} of 500", left.len());
    for row in left {
        let job = database
            .read(|db| jobs::get(db, &row.job))
            .unwrap()
            .unwrap();
        assert_eq!(job.item, Some(row.source));
    }
    drop(database);
    assert_eq!(open(&place).note, None, "once");
}

#[test]
fn a_file_without_its_head_is_moved_away_only_where_nothing_else_can_be() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("notes.txt");
    let text = b"no catalogue, but a text that somebody wrote and wants to keep ".repeat(100);
    std::fs::write(&place, &text).unwrap();
    let error = refused(&place);
    assert!(error.contains("notes.txt: this is no catalogue"), "{error}");
    assert_eq!(std::fs::read(&place).unwrap(), text);
    assert!(Database::open(&place, true).unwrap().note.is_some());
    assert_eq!(
        std::fs::read(folder.path().join("notes.txt.damaged-1")).unwrap(),
        text
    );
}

#[test]
fn the_database_of_another_program_is_left_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("addresses.db");
    let db = rusqlite::Connection::open(&place).unwrap();
    db.execute_batch("CREATE TABLE addresses (name TEXT)")
        .unwrap();
    drop(db);
    let before = std::fs::read(&place).unwrap();
    for error in [
        refused(&place),
        Database::open(&place, true).unwrap_err().to_string(),
        Database::open_read_only(&place).unwrap_err().to_string(),
    ] {
        assert!(error.contains("another program"), "{error}");
    }
    assert!(std::fs::read(&place).unwrap() == before);
}

#[test]
fn a_catalogue_of_a_later_program_is_refused_and_left_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("catalogue.sqlite3");
    filled(&place, 3);
    let db = rusqlite::Connection::open(&place).unwrap();
    db.pragma_update(None, "user_version", 99).unwrap();
    drop(db);
    for error in [
        refused(&place),
        Database::open_read_only(&place).unwrap_err().to_string(),
    ] {
        assert!(
            error.contains("version 99") && error.contains("later program"),
            "{error}"
        );
    }
    let db = rusqlite::Connection::open(&place).unwrap();
    db.pragma_update(None, "user_version", 1).unwrap();
    drop(db);
    assert_eq!(
        open(&place).database.read(characters::all).unwrap().len(),
        3
    );
}

#[test]
fn one_server_writes_others_read_and_a_lock_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("catalogue.sqlite3");
    filled(&place, 3);
    let server = open(&place).database;
    let second = refused(&place);
    assert!(second.contains("another server"), "{second}");
    let reader = Database::open_read_only(&place).unwrap();
    let count = |of: &Database| of.read(characters::all).unwrap().len();
    assert_eq!((count(&server), count(&reader)), (3, 3));
    // While one writes, others read what was before, and do not wait.
    let written = server.write(|db| {
        characters::remove(db, "n0000")?;
        assert_eq!((count(&server), count(&reader)), (3, 3));
        Ok(())
    });
    written.unwrap();
    assert_eq!((count(&server), count(&reader)), (2, 2));
    let other = rusqlite::Connection::open(&place).unwrap();
    other.execute_batch("BEGIN IMMEDIATE").unwrap();
    let error = server
        .write(|db| characters::remove(db, "n0001"))
        .unwrap_err()
        .to_string();
    assert!(error.contains("another program writes"), "{error}");
    other.execute_batch("ROLLBACK").unwrap();
    server.write(|db| characters::remove(db, "n0001")).unwrap();
    assert_eq!(count(&server), 1);
}

#[test]
fn a_catalogue_that_is_removed_or_replaced_meanwhile_is_made_anew() {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("store");
    let place = store.join("catalogue.sqlite3");
    filled(&place, 3);
    let server = open(&place).database;
    std::fs::remove_dir_all(&store).unwrap();
    let error = server.check().unwrap_err().to_string();
    assert!(error.contains("catalogue.sqlite3"), "{error}");
    server.write(|db| jobs::wait(db, &hash(9))).unwrap();
    server.check().unwrap();
    assert!(place.is_file());
    let found = server.read(|db| Ok((jobs::get(db, &hash(9))?, characters::all(db)?)));
    let (job, characters) = found.unwrap();
    assert!(job.is_some() && characters.is_empty());
}
