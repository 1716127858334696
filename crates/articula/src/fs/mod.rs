//! File access by path: opens files together with the files that they refer to, and writes files
//! so that nothing is lost. Not available on wasm.

#![allow(
    clippy::disallowed_methods,
    reason = "the one module of the library that opens files"
)]

mod files;
#[cfg(feature = "item")]
mod item;
mod output;
mod skeleton;

pub use files::{Existing, Files, read};

use crate::error::{Error, Result};
use crate::open::{CharacterFile, OpenOptions};
use std::io::{self, ErrorKind};
use std::path::{Component, Path, PathBuf};

/// Opens a character file; buffers, pictures and the skeleton of a motion are read from the same
/// folder.
///
/// # Errors
/// See [`Files::open`].
pub fn open(path: impl AsRef<Path>) -> Result<CharacterFile> {
    Files::new(Existing::Kept).open(path.as_ref(), &OpenOptions::default())
}

/// Lists the plain files of a folder, sorted by name, without hidden files and subfolders.
///
/// # Errors
/// An [`Error::Io`] if the folder cannot be read.
pub fn in_folder(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unread)? {
        let path = entry.map_err(unread)?.path();
        let name = path.file_name().unwrap_or_default();
        if path.is_file() && !name.to_string_lossy().starts_with('.') {
            all.push(path);
        }
    }
    all.sort();
    Ok(all)
}

/// Returns whether a path is the folder of a digital item: one with a manifest.
#[cfg(feature = "item")]
pub fn is_item(path: &Path) -> bool {
    path.is_dir() && path.join(crate::item::MANIFEST).is_file()
}

/// Explains why a file could not be read, with a remedy.
fn unread(error: io::Error) -> Error {
    match error.kind() {
        ErrorKind::NotFound => {
            Error::Io("the file does not exist; check its name and folder".into())
        }
        ErrorKind::PermissionDenied => {
            Error::Io("no permission to read the file; change its permissions".into())
        }
        _ => Error::Io(error.to_string()),
    }
}

fn inside(folder: &Path, name: &str) -> Result<PathBuf, String> {
    let mend = "only files in the same folder are read; put it there and name it without a path";
    // Also refuses drive letters; a colon in a relative name is rare.
    if name.contains(':') {
        return Err(format!("a URL is not fetched; {mend}"));
    }
    if name.starts_with(['/', '\\']) {
        return Err(format!("the path is absolute; {mend}"));
    }
    let name = name.replace('\\', "/");
    let mut depth = 0usize;
    for component in Path::new(&name).components() {
        match component {
            Component::Normal(_) => depth += 1,
            Component::CurDir => {}
            Component::ParentDir if depth > 0 => depth -= 1,
            _ => {
                return Err(format!(
                    "the path is outside the folder of the file; {mend}"
                ));
            }
        }
    }
    Ok(folder.join(name))
}

/// Formats a path for errors and reports.
pub fn shown(path: &Path) -> String {
    path.display().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_lies_beside_is_fetched() {
        let folder = Path::new("models");
        let good = |name: &str| inside(folder, name).unwrap();
        assert_eq!(good("a.bin"), Path::new("models/a.bin"));
        assert_eq!(good("tex/a b.png"), Path::new("models/tex/a b.png"));
        assert_eq!(good("tex/../a.bin"), Path::new("models/tex/../a.bin"));
        for bad in [
            "../a.bin",
            "tex/../../a.bin",
            "/etc/passwd",
            "\\\\host\\share",
            "..\\a.bin",
            "https://example.org/a.bin",
            "file:///etc/passwd",
            "C:\\a.bin",
        ] {
            let why = inside(folder, bad).unwrap_err();
            assert!(why.contains("in the same folder"), "{bad}: {why}");
        }
    }
}
