//! Paths of the command line, and small files that it names.

use articula::{DataFormat, Format};
use std::path::Path;

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
