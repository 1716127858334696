//! Whether a file can be a catalogue, and what is done where it cannot.
#![allow(clippy::disallowed_methods, reason = "the store is a folder")]

use super::connection::{reading_only, set_up, writing};
use super::damaged;
use super::fault::{self, fault, is_damage};
use super::schema::{VERSION, is_ours, migrate, version};
use crate::error::ServeError;
use rusqlite::Connection;
use std::path::Path;

/// Why a file cannot be used as it is.
#[derive(Debug)]
enum Unfit {
    Damaged,
    Refused(ServeError),
}

impl Unfit {
    fn new(place: &Path, error: &rusqlite::Error) -> Self {
        match is_damage(error) {
            true => Self::Damaged,
            false => Self::Refused(fault(place, error)),
        }
    }
}

/// Opens a file for writing; it is made if it is not there. One that is damaged is moved away, and what can be read of
/// it is saved, if its head says that it is a catalogue, or nothing else can be there: `is_ours`. The second result tells of
/// that.
pub(super) fn to_write(
    place: &Path,
    is_ours: bool,
) -> Result<(Connection, Option<String>), ServeError> {
    match fit(place) {
        Ok(db) => Ok((db, None)),
        Err(Unfit::Refused(error)) => Err(error),
        Err(Unfit::Damaged) if is_ours || damaged::is_catalogue(place) => {
            let (db, note) = mended(place)?;
            Ok((db, Some(note)))
        }
        Err(Unfit::Damaged) => {
            let what = "this is no catalogue; name another file, or move it away";
            Err(refusal(place, what))
        }
    }
}

/// Opens a file for reading; `None` if there is none, or an empty one.
pub(super) fn to_read(place: &Path) -> Result<Option<Connection>, ServeError> {
    if !place.exists() {
        return Ok(None);
    }
    let db = reading_only(place)?;
    match check_form(place, &db) {
        Ok(VERSION) => Ok(Some(db)),
        Ok(0) => Ok(None),
        Ok(_) => {
            let what = "an earlier version wrote this catalogue; start the server once without --read-only";
            Err(refusal(place, what))
        }
        Err(Unfit::Damaged) => Err(fault::damaged(place)),
        Err(Unfit::Refused(error)) => Err(error),
    }
}

/// Opens a file for writing, with tables of this version, if it can be one.
fn fit(place: &Path) -> Result<Connection, Unfit> {
    let of = |error: rusqlite::Error| Unfit::new(place, &error);
    let mut db = writing(place).map_err(of)?;
    check_form(place, &db)?;
    set_up(&db).map_err(of)?;
    migrate(&mut db).map_err(of)?;
    Ok(db)
}

/// Checks that a file is a catalogue of a known version, which is returned, and not damaged.
fn check_form(place: &Path, db: &Connection) -> Result<i32, Unfit> {
    let of = |error: rusqlite::Error| Unfit::new(place, &error);
    if !is_ours(db).map_err(of)? {
        let what = "this is the database of another program; name another file";
        return Err(Unfit::Refused(refusal(place, what)));
    }
    let version = version(db).map_err(of)?;
    if version > VERSION {
        let what = format!(
            "a later program wrote this catalogue (version {version}, this one knows {VERSION}); use that program, or \
             another file"
        );
        return Err(Unfit::Refused(refusal(place, &what)));
    }
    let whole: String = db
        .query_row("PRAGMA quick_check(1)", [], |row| row.get(0))
        .map_err(of)?;
    match whole == "ok" {
        true => Ok(version),
        false => Err(Unfit::Damaged),
    }
}

/// Makes a catalogue in the place of a damaged one.
fn mended(place: &Path) -> Result<(Connection, String), ServeError> {
    let away = damaged::move_away(place)?;
    let db = match fit(place) {
        Ok(db) => db,
        Err(Unfit::Refused(error)) => return Err(error),
        Err(Unfit::Damaged) => {
            return Err(refusal(
                place,
                "an empty file is damaged at once; check the disk",
            ));
        }
    };
    let saved = damaged::save(&away, &db);
    let note = format!(
        "{}: the catalogue was damaged and is now {}; {saved} rows of it were saved, all else is made anew",
        place.display(),
        away.display()
    );
    Ok((db, note))
}

fn refusal(place: &Path, what: &str) -> ServeError {
    ServeError::Store {
        place: place.display().to_string(),
        what: what.to_owned(),
    }
}
