//! Paths of the command line: reading and writing are the library's, whose errors get their
//! context here.

use articula::{DataFormat, Format};
use std::path::Path;

pub(crate) use articula::fs::{in_folder, shown};

/// The format of a character that a file's name says.
pub(crate) fn format(path: &Path) -> Option<Format> {
    Format::of_name(&path.to_string_lossy())
}

/// The format without a character that a file's name says.
pub(crate) fn data_format(path: &Path) -> Option<DataFormat> {
    DataFormat::of_name(&path.to_string_lossy())
}

/// Reads a whole file of at most `limit` bytes; a pipe or device is cut off there too.
pub(crate) fn read(path: &Path, limit: u64) -> anyhow::Result<Vec<u8>> {
    Ok(articula::fs::read(path, limit)?)
}

/// Writes a file whole or not at all, and makes the folders above it.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    Ok(articula::fs::write(path, bytes)?)
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
