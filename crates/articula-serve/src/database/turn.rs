//! One server at a time writes to a catalogue: what another one is packaging would else be taken for what a server left
//! that was killed.
#![allow(clippy::disallowed_methods, reason = "the store is a folder")]

use crate::error::ServeError;
use std::fs::{File, TryLockError};
use std::path::Path;

/// The turn of a server, which ends with it, also when it is killed.
#[derive(Debug)]
pub(super) struct Turn(#[expect(dead_code, reason = "its lock ends when it is closed")] File);

impl Turn {
    /// Takes the turn at a catalogue: a lock on an empty file beside it, since SQLite locks the file itself.
    ///
    /// # Errors
    /// [`ServeError::Store`] while another server has it.
    pub(super) fn take(place: &Path) -> Result<Self, ServeError> {
        let mut name = place.as_os_str().to_owned();
        name.push(".lock");
        let beside = Path::new(&name);
        let options = File::options().create(true).append(true).open(beside);
        let file = options.map_err(|error| ServeError::store(beside, &error))?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => Err(ServeError::Store {
                place: place.display().to_string(),
                what: "another server writes to this catalogue; stop that one, or serve with --read-only"
                    .to_owned(),
            }),
            // File systems without locks have one server at a time by agreement.
            Ok(()) | Err(TryLockError::Error(_)) => Ok(Self(file)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_server_is_refused_until_the_first_ends() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("catalogue.sqlite3");
        let first = Turn::take(&place).unwrap();
        let refused = Turn::take(&place).unwrap_err().to_string();
        assert!(refused.contains("another server"), "{refused}");
        drop(first);
        assert!(Turn::take(&place).is_ok());
    }
}
