//! Files on disk: bounded reading, what lies beside a file, and writing that never leaves half
//! a file behind.

use anyhow::{Context, anyhow, bail};
use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::{Component, Path, PathBuf};

/// Reads a whole file of at most `limit` bytes; a pipe or device is cut off there too.
pub(crate) fn read(path: &Path, limit: u64) -> anyhow::Result<Vec<u8>> {
    let place = || shown(path);
    if path.is_dir() {
        bail!("{}: this is a folder; name a file in it", place());
    }
    let mut bytes = Vec::new();
    File::open(path)
        .and_then(|file| file.take(limit + 1).read_to_end(&mut bytes))
        .map_err(unread)
        .with_context(place)?;
    if bytes.is_empty() {
        bail!("{}: the file is empty; save it again", place());
    }
    if bytes.len() as u64 > limit {
        bail!("{}: more than {limit} bytes, which is the limit", place());
    }
    Ok(bytes)
}

/// Writes a file whole or not at all, and makes the folders above it.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    let place = || shown(path);
    let Some(name) = path.file_name() else {
        bail!("{}: this names no file", place());
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    if !folder.as_os_str().is_empty() {
        std::fs::create_dir_all(folder)
            .map_err(unwritten)
            .with_context(|| shown(folder))?;
    }
    // A device or pipe is written as it is; a plain file appears only when it is complete.
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

/// The plain files of a folder, sorted by name; hidden ones and folders in it are left out.
pub(crate) fn in_folder(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
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

/// Whether two names lead to the same file that is there.
pub(crate) fn same(a: &Path, b: &Path) -> bool {
    let (a, b) = (a.canonicalize(), b.canonicalize());
    matches!((a, b), (Ok(a), Ok(b)) if a == b)
}

/// Whether a name can only be that of a folder.
pub(crate) fn ends_with_separator(path: &Path) -> bool {
    let bytes = path.as_os_str().as_encoded_bytes();
    bytes.ends_with(b"/") || bytes.ends_with(std::path::MAIN_SEPARATOR_STR.as_bytes())
}

/// Why a file could not be read, and the mend.
fn unread(error: io::Error) -> anyhow::Error {
    match error.kind() {
        ErrorKind::NotFound => anyhow!("there is no such file; check its name and folder"),
        ErrorKind::PermissionDenied => anyhow!("it may not be read; change its permissions"),
        _ => error.into(),
    }
}

/// Why a file or folder could not be written, and the mend.
fn unwritten(error: io::Error) -> anyhow::Error {
    match error.kind() {
        ErrorKind::IsADirectory => anyhow!("this is a folder; name a file in it"),
        ErrorKind::AlreadyExists | ErrorKind::NotADirectory => {
            anyhow!("a file stands where a folder is needed; name another folder")
        }
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem | ErrorKind::NotFound => {
            anyhow!("nothing may be written here; name a folder of your own")
        }
        ErrorKind::StorageFull => anyhow!("the disk is full; make room or name another"),
        _ => error.into(),
    }
}

/// Fetches what lies beside a file, and nothing else: no absolute path, no URL, no way out of
/// the file's folder.
pub(crate) fn beside(file: &Path, limit: u64) -> impl FnMut(&str) -> Result<Vec<u8>, String> {
    let folder = file.parent().unwrap_or(Path::new("")).to_path_buf();
    move |name: &str| {
        let path = inside(&folder, name)?;
        // Opening a pipe would wait for ever, so only plain files are opened.
        if !path.is_file() {
            return Err("there is no such file beside this one; put it there".into());
        }
        read(&path, limit).map_err(|e| format!("{:#}", e.root_cause()))
    }
}

fn inside(folder: &Path, name: &str) -> Result<PathBuf, String> {
    let mend = "only files beside this one are read; put it there and name it without a path";
    // Also catches a drive letter; a colon in a plain relative name is too rare to keep.
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
            _ => return Err(format!("the path leaves the file's folder; {mend}")),
        }
    }
    Ok(folder.join(name))
}

/// A path as errors and reports show it.
pub(crate) fn shown(path: &Path) -> String {
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
            assert!(why.contains("beside this one"), "{bad}: {why}");
        }
    }

    #[test]
    fn a_missing_neighbour_names_the_mend() {
        let mut fetch = beside(Path::new("nowhere/a.gltf"), 10);
        assert!(fetch("a.bin").unwrap_err().contains("put it there"));
    }
}
