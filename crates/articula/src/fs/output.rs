//! Writing of single files: complete or not at all.

use super::shown;
use crate::error::{Context, Error, Result};
use std::fs::OpenOptions;
use std::io::{self, ErrorKind, Write};
use std::path::Path;

/// Checks that a path can name a file of an existing folder.
pub(super) fn check_place(path: &Path) -> Result<()> {
    let refused = |what: &str| Err(Error::Io(what.to_owned())).with_context(|| shown(path));
    if path.file_name().is_none() {
        return refused("the path has no file name; name a file");
    }
    if path.is_dir() {
        return refused("this is a folder; name a file in it");
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    if folder.as_os_str().is_empty() || folder.is_dir() {
        return Ok(());
    }
    let what = match folder.exists() {
        true => "is a file; name another folder",
        false => "does not exist; make it, or name another folder",
    };
    refused(&format!("the folder {} {what}", shown(folder)))
}

/// Whether two paths name one existing file.
pub(super) fn is_same(a: &Path, b: &Path) -> bool {
    same_file::is_same_file(a, b).unwrap_or(false)
}

/// Whether there is a plain file, or a link whose target is missing; not a pipe or device.
pub(super) fn is_file(path: &Path) -> bool {
    path.is_file() || path.is_symlink() && !path.exists()
}

/// Writes a file. A plain file appears only when it is complete; a pipe or device is written
/// directly.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    if path.exists() && !path.is_file() {
        return std::fs::write(path, bytes).map_err(unwritten);
    }
    let mut part = path.file_name().unwrap_or_default().to_owned();
    part.push(format!(".{}.part", std::process::id()));
    let part = path.with_file_name(part);
    let written = OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(&part)
        .and_then(|mut file| {
            let mut written = file.write_all(bytes);
            if path.exists() {
                // What is replaced must not be lost before the new bytes are safe.
                written = written.and_then(|()| file.sync_all());
            }
            let written = written.and_then(|()| std::fs::rename(&part, path));
            if written.is_err() {
                let _ = std::fs::remove_file(&part);
            }
            written
        });
    written.map_err(unwritten)
}

pub(super) fn make_folder(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(unwritten)
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
