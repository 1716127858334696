//! The files of a character as they lie in the folder: one that holds the figure, and what it carries.
#![allow(clippy::disallowed_methods, reason = "the store is a folder")]

use crate::error::ServeError;
use crate::objects::read;
use articula::item::CarriedFile;
use std::path::Path;

/// Extensions of what is carried: captions and sound.
const CARRIED: [&str; 9] = [
    "vtt", "mp3", "ogg", "oga", "opus", "m4a", "aac", "flac", "wav",
];

/// A character as it is packaged.
#[derive(Debug)]
pub(crate) struct Source {
    pub(crate) figure: Vec<u8>,
    /// Files that the item carries whole, by name.
    pub(crate) with: Vec<CarriedFile>,
}

impl Source {
    /// Reads the file of a figure, and files beside it with the same name and an extension of what is carried.
    pub(crate) fn read(file: &Path) -> Result<Self, ServeError> {
        let mut with = Vec::new();
        for path in CARRIED.map(|extension| file.with_extension(extension)) {
            if let Some(bytes) = read_file(&path)? {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                with.push(CarriedFile {
                    name: name.into_owned(),
                    bytes,
                });
            }
        }
        Ok(Self {
            figure: read(file)?.unwrap_or_default(),
            with,
        })
    }

    /// A hash of all of it.
    pub(crate) fn hash(&self) -> blake3::Hash {
        let figure = blake3::hash(&self.figure);
        if self.with.is_empty() {
            return figure;
        }
        let mut all = blake3::Hasher::new();
        all.update(figure.as_bytes());
        for file in &self.with {
            all.update(blake3::hash(file.name.as_bytes()).as_bytes());
            all.update(blake3::hash(&file.bytes).as_bytes());
        }
        all.finalize()
    }
}

fn read_file(path: &Path) -> Result<Option<Vec<u8>>, ServeError> {
    match path.is_file() {
        true => read(path),
        false => Ok(None),
    }
}
