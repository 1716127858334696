//! File access by path: opens files together with the files that they refer to, and writes files
//! atomically. Not available on wasm.

#![allow(
    clippy::disallowed_methods,
    reason = "the one module of the library that opens files"
)]

mod skeleton;

use crate::error::{Context, Error, Result};
use crate::open::{self, CharacterFile, Format, OpenOptions};
use articula_formats::{Assumption, Warning};
use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::{Component, Path, PathBuf};

/// Opens a character file; buffers, pictures and the skeleton of a motion are read from the same
/// folder.
///
/// # Errors
/// See [`open_with`].
pub fn open(path: impl AsRef<Path>) -> Result<CharacterFile> {
    open_with(path, &OpenOptions::default())
}

/// Opens a character file with options.
///
/// # Errors
/// An [`Error`] that names the file, if it cannot be read or for the reasons given at
/// [`open()`](crate::open()).
pub fn open_with(path: impl AsRef<Path>, options: &OpenOptions) -> Result<CharacterFile> {
    let path = path.as_ref();
    let name = shown(path);
    if let Some(data) = open::DataFormat::from_name(&name) {
        return Err(Error::unsuited(data.advice())).context(name);
    }
    let limit = options.limits.bytes;
    let bytes = read(path, limit)?;
    let mut fetch = beside(path, limit);
    if Format::from_bytes(&bytes, &name) == Some(Format::Amc) && options.skeleton.is_none() {
        let (skeleton, how) = skeleton_beside(path).with_context(|| &name)?;
        let options = OpenOptions {
            skeleton: Some(read(&skeleton, limit)?),
            ..options.clone()
        };
        let with = || format!("with the skeleton {}", shown(&skeleton));
        let opened = open::open(&bytes, &name, &options, &mut fetch);
        let mut opened = opened.map_err(|error| error.within(with()))?;
        if let Some(how) = how {
            let file = skeleton.file_name().unwrap_or_default().to_string_lossy();
            let what = format!("{file} is used: {how}");
            let warning = Warning {
                at: "skeleton".to_owned(),
                what,
                guess: Some(Assumption::Skeleton),
            };
            opened.warnings.insert(0, warning);
        }
        return Ok(opened);
    }
    open::open(&bytes, &name, options, &mut fetch)
}

/// Finds the skeleton of a motion; the reason is given if it is a guess.
fn skeleton_beside(path: &Path) -> Result<(PathBuf, Option<&'static str>)> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let here = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let names: Vec<String> = in_folder(here)?
        .iter()
        .filter_map(|p| Some(p.file_name()?.to_string_lossy().into_owned()))
        .collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let motion = path.file_name().unwrap_or_default().to_string_lossy();
    let (found, how) = skeleton::skeleton_of(&motion, &names)?;
    Ok((folder.join(found), how))
}

/// Reads a whole file, pipe or device of at most `limit` bytes.
///
/// # Errors
/// An [`Error`] that names the file, the cause and the remedy.
pub fn read(path: &Path, limit: u64) -> Result<Vec<u8>> {
    let place = || shown(path);
    if path.is_dir() {
        return Err(Error::Io("this is a folder; name a file in it".into())).with_context(place);
    }
    let mut bytes = Vec::new();
    File::open(path)
        .and_then(|file| file.take(limit + 1).read_to_end(&mut bytes))
        .map_err(unread)
        .with_context(place)?;
    if bytes.is_empty() {
        return Err(Error::unsuited("the file is empty; save it again")).with_context(place);
    }
    if bytes.len() as u64 > limit {
        let what = format!("the file exceeds the limit of {limit} bytes");
        return Err(Error::unsuited(what)).with_context(place);
    }
    Ok(bytes)
}

/// Writes a file atomically, and creates missing parent folders.
///
/// # Errors
/// An [`Error::Io`] that names the file, the cause and the remedy.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let place = || shown(path);
    let Some(name) = path.file_name() else {
        return Err(Error::Io("the path has no file name".into())).with_context(place);
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    if !folder.as_os_str().is_empty() {
        std::fs::create_dir_all(folder)
            .map_err(unwritten)
            .with_context(|| shown(folder))?;
    }
    // A device or pipe is written directly; a plain file appears only when it is complete.
    if path.exists() && !path.is_file() {
        return std::fs::write(path, bytes)
            .map_err(unwritten)
            .with_context(place);
    }
    let mut part = name.to_owned();
    part.push(format!(".{}.part", std::process::id()));
    let part = folder.join(part);
    let written = std::fs::write(&part, bytes).and_then(|()| std::fs::rename(&part, path));
    if written.is_err() {
        let _ = std::fs::remove_file(&part);
    }
    written.map_err(unwritten).with_context(place)
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

/// Explains why a file or folder could not be written, with a remedy.
fn unwritten(error: io::Error) -> Error {
    match error.kind() {
        ErrorKind::IsADirectory => Error::Io("this is a folder; name a file in it".into()),
        ErrorKind::AlreadyExists | ErrorKind::NotADirectory => {
            Error::Io("a folder of the path is a file; name another folder".into())
        }
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem | ErrorKind::NotFound => {
            Error::Io("no permission to write here; name another folder".into())
        }
        ErrorKind::StorageFull => {
            Error::Io("the disk is full; free space or name another disk".into())
        }
        _ => Error::Io(error.to_string()),
    }
}

/// Returns a resolver for files referenced by `file`; it refuses absolute paths, URLs and paths
/// that leave the file's folder.
pub fn beside(file: &Path, limit: u64) -> impl FnMut(&str) -> Result<Vec<u8>, String> {
    let folder = file.parent().unwrap_or(Path::new("")).to_path_buf();
    move |name: &str| {
        let path = inside(&folder, name)?;
        // Opening a pipe could block forever, so only plain files are opened.
        if !path.is_file() {
            return Err("there is no such file in the same folder; put it there".into());
        }
        read(&path, limit).map_err(|e| e.cause().to_string())
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

    #[test]
    fn a_missing_neighbour_names_the_mend() {
        let mut fetch = beside(Path::new("nowhere/a.gltf"), 10);
        assert!(fetch("a.bin").unwrap_err().contains("put it there"));
    }
}
