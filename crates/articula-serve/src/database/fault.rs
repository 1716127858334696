//! What an error of SQLite means for who runs the server: the file, what is wrong with it, and what mends it.

use crate::error::ServeError;
use rusqlite::{Error, ErrorCode};
use std::path::Path;

/// An error of a catalogue.
pub(super) fn fault(place: &Path, error: &Error) -> ServeError {
    let place = place.display().to_string();
    let what = match error.sqlite_error_code() {
        Some(ErrorCode::DiskFull) => return ServeError::Full { place },
        Some(ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked) => {
            return ServeError::Locked { place };
        }
        Some(ErrorCode::ReadOnly | ErrorCode::PermissionDenied) => {
            "no permission to write here; serve it with --read-only".to_owned()
        }
        Some(ErrorCode::CannotOpen) => {
            "the catalogue cannot be opened; check the folder and its permissions".to_owned()
        }
        Some(ErrorCode::DatabaseCorrupt | ErrorCode::NotADatabase) => {
            "the catalogue is damaged; start the server again, which saves what can be read of it \
             and makes the rest anew"
                .to_owned()
        }
        Some(ErrorCode::SystemIoFailure) => {
            format!("the disk may be full, gone or failing ({error})")
        }
        _ => error.to_string(),
    };
    ServeError::Store { place, what }
}

/// The same for who may only read.
pub(super) fn fault_of_reading(place: &Path, error: &Error) -> ServeError {
    match is_damage(error) {
        true => damaged(place),
        false => fault(place, error),
    }
}

/// What a damaged file means for who may only read.
pub(super) fn damaged(place: &Path) -> ServeError {
    ServeError::Store {
        place: place.display().to_string(),
        what: "the catalogue is damaged; start the server once without --read-only, which saves what can be read of it"
            .to_owned(),
    }
}

/// Whether an error says that a file is damaged, or none of SQLite's.
pub(super) fn is_damage(error: &Error) -> bool {
    let code = error.sqlite_error_code();
    matches!(
        code,
        Some(ErrorCode::DatabaseCorrupt | ErrorCode::NotADatabase)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusqlite::ffi;

    #[test]
    fn each_fault_names_the_file_and_what_mends_it() {
        for (code, mend) in [
            (ffi::SQLITE_FULL, "free space"),
            (ffi::SQLITE_BUSY, "close it"),
            (ffi::SQLITE_READONLY_DBMOVED, "--read-only"),
            (ffi::SQLITE_CANTOPEN, "permissions"),
            (ffi::SQLITE_CORRUPT_INDEX, "start the server again"),
            (ffi::SQLITE_NOTADB, "start the server again"),
            (ffi::SQLITE_IOERR_WRITE, "full, gone or failing"),
        ] {
            let error = Error::SqliteFailure(ffi::Error::new(code), None);
            let line = fault("a/catalogue.sqlite3".as_ref(), &error).to_string();
            assert!(line.starts_with("a/catalogue.sqlite3: "), "{line}");
            assert!(line.contains(mend) && !line.contains('\n'), "{line}");
        }
    }
}
