//! A character as it lies in the folder: a file that holds the figure, with what it carries, or an item that was
//! packaged elsewhere.
#![allow(clippy::disallowed_methods, reason = "the store is a folder")]

use crate::error::ServeError;
use crate::objects::{read, remove, remove_folder};
use articula::item::{CarriedFile, MANIFEST};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// Extensions of what is carried: captions and sound.
const CARRIED: [&str; 9] = [
    "vtt", "mp3", "ogg", "oga", "opus", "m4a", "aac", "flac", "wav",
];
/// Extensions of files that hold all of a character.
const EXTENSIONS: [&str; 4] = ["glb", "vrm", "fbx", PACKED];
/// Extension of an item in one file.
pub(crate) const PACKED: &str = "zip";

/// A character before the server has made anything of it.
#[derive(Debug)]
pub(crate) enum Source {
    /// A file that is packaged here.
    Figure {
        bytes: Vec<u8>,
        /// Files that the item carries whole, by name.
        with: Vec<CarriedFile>,
    },
    /// An item in one file.
    Packed(Vec<u8>),
    /// The manifest of an item in a folder of its own.
    Folder(Vec<u8>),
}

impl Source {
    /// Whether a path is that of an item in a folder of its own.
    fn is_folder(path: &Path) -> bool {
        path.join(MANIFEST).is_file()
    }

    /// Reads a character, and, for a file that is packaged here, files beside it with the same name and an extension of
    /// what is carried.
    pub(crate) fn read(path: &Path) -> Result<Self, ServeError> {
        if path.is_dir() {
            let manifest = read(&path.join(MANIFEST))?;
            return Ok(Self::Folder(manifest.unwrap_or_default()));
        }
        let bytes = read(path)?.unwrap_or_default();
        if is_packed(path) {
            return Ok(Self::Packed(bytes));
        }
        let mut with = Vec::new();
        for path in carried(path) {
            if let Some(bytes) = read_file(&path)? {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                with.push(CarriedFile {
                    name: name.into_owned(),
                    bytes,
                });
            }
        }
        Ok(Self::Figure { bytes, with })
    }

    /// The files that [`Self::read`] reads, there or not.
    pub(crate) fn files(path: &Path) -> Vec<PathBuf> {
        match path.is_dir() {
            true => vec![path.join(MANIFEST)],
            false if is_packed(path) => vec![path.to_path_buf()],
            false => [path.to_path_buf()]
                .into_iter()
                .chain(carried(path))
                .collect(),
        }
    }

    /// A hash of all of it; of an item in a folder that of its manifest, which has those of its files.
    pub(crate) fn hash(&self) -> blake3::Hash {
        let (figure, with) = match self {
            Self::Packed(bytes) | Self::Folder(bytes) => return blake3::hash(bytes),
            Self::Figure { bytes, with } => (blake3::hash(bytes), with),
        };
        if with.is_empty() {
            return figure;
        }
        let mut all = blake3::Hasher::new();
        all.update(figure.as_bytes());
        for file in with {
            all.update(blake3::hash(file.name.as_bytes()).as_bytes());
            all.update(blake3::hash(&file.bytes).as_bytes());
        }
        all.finalize()
    }
}

fn is_packed(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default();
    extension.eq_ignore_ascii_case(PACKED)
}

/// Where files lie that a character file carries.
fn carried(path: &Path) -> [PathBuf; CARRIED.len()] {
    CARRIED.map(|extension| path.with_extension(extension))
}

fn read_file(path: &Path) -> Result<Option<Vec<u8>>, ServeError> {
    match path.is_file() {
        true => read(path),
        false => Ok(None),
    }
}

/// Removes a character file, or an item with the folder that it has for itself.
pub(crate) fn remove_source(path: &Path) -> Result<(), ServeError> {
    match path.is_dir() {
        true => remove_folder(path),
        false => remove(path),
    }
}

/// The character files and items of a folder, by name.
pub(crate) fn sources(root: &Path) -> Result<Vec<PathBuf>, ServeError> {
    let fault = |error: std::io::Error| ServeError::store(root, &error);
    let mut found = Vec::new();
    for entry in std::fs::read_dir(root).map_err(fault)? {
        let path = entry.map_err(fault)?.path();
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        let is_file = path.is_file() && EXTENSIONS.iter().any(|known| extension == *known);
        // What the server makes is no character.
        let is_hidden = path
            .file_name()
            .is_some_and(|name| name.to_string_lossy().starts_with('.'));
        if is_file || !is_hidden && Source::is_folder(&path) {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

/// The name that a character has by its file, and the one that it has where another has that.
pub(crate) fn names(path: &Path) -> (String, String) {
    let text = |of: Option<&OsStr>| of.unwrap_or_default().to_string_lossy().into_owned();
    let name = text(path.file_name());
    match path.is_dir() {
        true => (name.clone(), name),
        false => (text(path.file_stem()), name),
    }
}
