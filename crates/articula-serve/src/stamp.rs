//! By what an unchanged file is known without reading it, and a file from one that takes its place.
#![allow(
    clippy::disallowed_methods,
    reason = "the store is a folder, and files have ages"
)]

use std::fs::Metadata;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// A file that was changed so recently may be changed again without another time; clocks of file systems go in steps of up
/// to two seconds (FAT).
const UNSURE: Duration = Duration::from_secs(3);

/// What another file in the place of this one has not.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Identity {
    number: String,
    created: Option<SystemTime>,
}

/// The identity of a file, if it is there.
pub(crate) fn identity(path: &Path) -> Option<Identity> {
    let of = path.metadata().ok()?;
    Some(Identity {
        number: number(&of),
        created: of.created().ok(),
    })
}

/// The device and the number of a file.
#[cfg(unix)]
fn number(of: &Metadata) -> String {
    use std::os::unix::fs::MetadataExt;
    format!("{}.{}", of.dev(), of.ino())
}

/// There is none.
#[cfg(not(unix))]
fn number(_: &Metadata) -> String {
    String::new()
}

/// The time of the last change of a file or of what is known of it, which no program sets, in nanoseconds.
#[cfg(unix)]
fn changed(of: &Metadata) -> String {
    use std::os::unix::fs::MetadataExt;
    format!("{}.{:09}", of.ctime(), of.ctime_nsec())
}

/// There is none.
#[cfg(not(unix))]
fn changed(_: &Metadata) -> String {
    String::new()
}

/// The stamp of files that are read after it is made; `None` if one of them was changed just now, or cannot be looked at.
/// Files that are not there have a stamp too.
pub(crate) fn stamp(paths: &[PathBuf]) -> Option<String> {
    let mut stamp = String::new();
    for path in paths {
        if let Ok(of) = path.metadata() {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let modified = of.modified().ok()?;
            let age = SystemTime::now().duration_since(modified).ok()?;
            if age < UNSURE {
                return None;
            }
            let modified = modified.duration_since(SystemTime::UNIX_EPOCH).ok()?;
            let nanoseconds = modified.as_nanos();
            stamp += &format!(
                "{name} {} {nanoseconds} {} {}\n",
                of.len(),
                changed(&of),
                number(&of)
            );
        }
    }
    Some(stamp)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(path: &Path, bytes: &[u8], age_secs: u64) {
        std::fs::write(path, bytes).unwrap();
        let file = std::fs::File::options().write(true).open(path).unwrap();
        let past = SystemTime::now() - Duration::from_secs(age_secs);
        file.set_modified(past).unwrap();
    }

    #[test]
    fn an_unchanged_file_has_the_same_stamp_and_a_changed_one_another() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.glb");
        let other = folder.path().join("a.vtt");
        let both = [path.clone(), other.clone()];
        write(&path, b"one", 100);
        let before = stamp(&both).unwrap();
        assert_eq!(stamp(&both).unwrap(), before);
        write(&other, b"said", 100);
        assert_ne!(stamp(&both).unwrap(), before);
        std::fs::remove_file(&other).unwrap();
        assert_eq!(stamp(&both).unwrap(), before);
        write(&path, b"four", 100);
        assert_ne!(stamp(&both).unwrap(), before);
        write(&path, b"now", 0);
        assert_eq!(stamp(&both), None, "it may change within the same tick");
    }

    #[test]
    fn a_file_in_the_place_of_another_has_another_identity() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        assert_eq!(identity(&path), None);
        std::fs::write(&path, b"1").unwrap();
        let first = identity(&path);
        std::fs::write(&path, b"2").unwrap();
        assert_eq!(identity(&path), first);
        let other = folder.path().join("b");
        std::fs::write(&other, b"3").unwrap();
        std::fs::rename(&other, &path).unwrap();
        assert_ne!(identity(&path), first);
    }
}
