//! Bytes by their hash, in a folder: what is there never changes.
#![allow(clippy::disallowed_methods, reason = "the store is a folder")]

use crate::error::ServeError;
use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Name of an object: 64 hexadecimal digits.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct ObjectName(String);

impl ObjectName {
    /// The name that a client gives, if it is one.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let is_digit = |c: char| c.is_ascii_digit() || ('a'..='f').contains(&c);
        (text.len() == 64 && text.chars().all(is_digit)).then(|| Self(text.to_owned()))
    }

    /// The name of these bytes.
    pub(crate) fn of(bytes: &[u8]) -> Self {
        Self(blake3::hash(bytes).to_hex().to_string())
    }

    pub(crate) fn as_str(&self) -> &str {
        &self.0
    }
}

/// In which form an object is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Coding {
    /// Its bytes.
    Identity,
    /// Compressed, as `Content-Encoding: br` (RFC 7932).
    Brotli,
}

/// A folder of objects.
#[derive(Debug)]
pub(crate) struct Objects {
    folder: PathBuf,
}

impl Objects {
    pub(crate) fn new(folder: PathBuf) -> Self {
        Self { folder }
    }

    /// Stores an object, unless it is there.
    pub(crate) fn put(
        &self,
        name: &ObjectName,
        coding: Coding,
        bytes: &[u8],
    ) -> Result<(), ServeError> {
        let path = self.path(name, coding);
        match path.exists() {
            true => Ok(()),
            false => write(&path, bytes),
        }
    }

    /// Returns an object; `None` if there is no such one.
    pub(crate) fn get(
        &self,
        name: &ObjectName,
        coding: Coding,
    ) -> Result<Option<Vec<u8>>, ServeError> {
        let path = self.path(name, coding);
        match fs::read(&path) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(ServeError::store(&path, &error)),
        }
    }

    fn path(&self, name: &ObjectName, coding: Coding) -> PathBuf {
        let file = match coding {
            Coding::Identity => name.0.clone(),
            Coding::Brotli => format!("{}.br", name.0),
        };
        self.folder.join(&name.0[..2]).join(file)
    }
}

/// Writes a file, which appears under its name when it is complete and safe.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), ServeError> {
    let of = |place: &Path| {
        let place = place.to_path_buf();
        move |error: std::io::Error| ServeError::store(&place, &error)
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    fs::create_dir_all(folder).map_err(of(folder))?;
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.part", std::process::id()));
    let part = path.with_file_name(name);
    let mut written = fs::File::create(&part).and_then(|mut file| {
        file.write_all(bytes)?;
        file.sync_all()
    });
    written = written.and_then(|()| fs::rename(&part, path));
    written.map_err(|error| {
        let _ = fs::remove_file(&part);
        ServeError::store(path, &error)
    })
}

/// Removes a file.
pub(crate) fn remove(path: &Path) -> Result<(), ServeError> {
    fs::remove_file(path).map_err(|error| ServeError::store(path, &error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_hashes_and_nothing_else() {
        // The published test vector of no input.
        let none = "af1349b9f5f9a1a6a0404dea36dcc9499bcb25c9adc112b7cc9a93cae41f3262";
        assert_eq!(ObjectName::of(b"").as_str(), none);
        assert_eq!(ObjectName::parse(none), Some(ObjectName::of(b"")));
        for other in [
            "",
            "..",
            &none[1..],
            &none.to_uppercase(),
            &none.replace('a', "/"),
        ] {
            assert_eq!(ObjectName::parse(other), None, "{other}");
        }
    }

    #[test]
    fn an_object_is_found_again_and_stays_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let objects = Objects::new(folder.path().join("objects"));
        let name = ObjectName::of(b"walk");
        assert_eq!(objects.get(&name, Coding::Identity).unwrap(), None);
        objects.put(&name, Coding::Identity, b"walk").unwrap();
        objects.put(&name, Coding::Identity, b"other").unwrap();
        objects.put(&name, Coding::Brotli, b"short").unwrap();
        let found = |coding| objects.get(&name, coding).unwrap().unwrap();
        assert_eq!(found(Coding::Identity), b"walk");
        assert_eq!(found(Coding::Brotli), b"short");
    }
}
