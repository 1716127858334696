//! Paths of the command line, and small files that it names.

use anyhow::Context;
use articula::flat::Picture;
use articula::{DataFormat, Format};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

pub(crate) use articula::fs::{Files, in_folder, is_item, shown};

/// The character format that a file name implies.
pub(crate) fn format(path: &Path) -> Option<Format> {
    Format::from_name(&path.to_string_lossy())
}

/// The format without a character (FAP, FDP, EPF) that a file name implies.
pub(crate) fn data_format(path: &Path) -> Option<DataFormat> {
    DataFormat::from_name(&path.to_string_lossy())
}

/// Reads a whole file of at most `limit` bytes; pipes and devices are cut off there too.
pub(crate) fn read(path: &Path, limit: u64) -> anyhow::Result<Vec<u8>> {
    Ok(articula::fs::read(path, limit)?)
}

/// The extension of a file name in lower case.
pub(crate) fn extension(path: &Path) -> String {
    let extension = path.extension().unwrap_or_default();
    extension.to_string_lossy().to_lowercase()
}

/// Writes a picture; returns its path for a report.
pub(crate) fn write_png(files: &Files, path: &Path, picture: &Picture) -> anyhow::Result<String> {
    let bytes = picture.to_png().with_context(|| shown(path))?;
    files.write(path, &bytes)?;
    Ok(shown(path))
}

/// Writes files into a folder, by their names there, and makes the folders that they need; returns
/// path and size of each.
pub(crate) fn write_folder(
    files: &Files,
    folder: &Path,
    named: impl IntoIterator<Item = (String, Vec<u8>)>,
) -> anyhow::Result<Vec<(PathBuf, usize)>> {
    let path = |(name, bytes)| (folder.join::<String>(name), bytes);
    let all: Vec<(PathBuf, Vec<u8>)> = named.into_iter().map(path).collect();
    make_folders(files, folder, &all)?;
    files.write_all(&all)?;
    Ok(all
        .into_iter()
        .map(|(path, bytes)| (path, bytes.len()))
        .collect())
}

/// Writes files into a folder that grows, and makes the folders that they need: later forms replace those
/// that were written before.
pub(crate) fn write_again(
    files: &Files,
    folder: &Path,
    named: impl IntoIterator<Item = (String, Vec<u8>)>,
) -> articula::Result<()> {
    let all: Vec<(PathBuf, Vec<u8>)> = (named.into_iter())
        .map(|(name, bytes)| (folder.join(name), bytes))
        .collect();
    make_folders(files, folder, &all)?;
    files.write_again(&all)
}

fn make_folders(files: &Files, folder: &Path, all: &[(PathBuf, Vec<u8>)]) -> articula::Result<()> {
    let folders: BTreeSet<&Path> = all.iter().filter_map(|(path, _)| path.parent()).collect();
    for folder in [folder].into_iter().chain(folders) {
        files.make_folder(folder)?;
    }
    Ok(())
}

/// Whether two paths name the same existing file.
pub(crate) fn same(a: &Path, b: &Path) -> bool {
    let (a, b) = (a.canonicalize(), b.canonicalize());
    matches!((a, b), (Ok(a), Ok(b)) if a == b)
}

/// Whether something other than a folder has this name.
pub(crate) fn is_no_folder(path: &Path) -> bool {
    // A file with a separator after its name does not exist as such.
    path.components().as_path().exists() && !path.is_dir()
}

/// Whether a path ends with a separator and thus can only name a folder.
pub(crate) fn ends_with_separator(path: &Path) -> bool {
    let bytes = path.as_os_str().as_encoded_bytes();
    bytes.ends_with(b"/") || bytes.ends_with(std::path::MAIN_SEPARATOR_STR.as_bytes())
}
