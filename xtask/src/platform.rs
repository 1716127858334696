//! What the checks on other platforms share: the targets, and the hashes of a playback and of the steps
//! of the library, which must be those of this machine.

use crate::processes::{answer, output, run};
use crate::workspace::target;
use anyhow::{Result, ensure};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Package of the program that hashes what a playback shows.
pub(crate) const PLAYBACK: &str = "articula-playback-hash";

/// Program of the same package that takes a character through the library.
pub(crate) const LIBRARY: &str = "articula-library-hash";

/// Lines of [`LIBRARY`] when no step fails.
const LIBRARY_STEPS: usize = 11;

/// Returns whether the compiler in use has the standard library of a target.
pub(crate) fn installed(target: &str) -> bool {
    let words = ["--print", "target-libdir", "--target", target];
    answer("rustc", &words).is_some_and(|folder| Path::new(&folder).is_dir())
}

/// Adds a target by rustup unless it is installed; false if that is not possible.
pub(crate) fn add(target: &str) -> bool {
    let mut rustup = Command::new("rustup");
    installed(target) || run(rustup.args(["target", "add", target])).is_ok()
}

/// Returns the folder of the programs and modules that cargo builds for a target.
pub(crate) fn built(triple: &str) -> PathBuf {
    target().join(triple).join("debug")
}

/// Compares the hash of a playback on this machine with the one found at a `place`. The program is
/// that of the build of the tests.
pub(crate) fn compare_playback(place: &str, found: &str) -> Result<()> {
    let native = output(&mut Command::new(target().join("debug").join(PLAYBACK)))?;
    ensure!(
        native == found && native.len() == 16 && native != "0000000000000000",
        "the playback shows {native} on this machine and {found} {place}"
    );
    Ok(())
}

/// Compares the steps of the library on this machine with those found at a `place`: a line for each, its
/// name and its hash. Returns these lines, and writes the asset that was prepared to a file.
pub(crate) fn compare_library(place: &str, found: &str, prepared: &Path) -> Result<String> {
    let native = output(Command::new(target().join("debug").join(LIBRARY)).arg(prepared))?;
    let faults = differences(&native, found);
    ensure!(
        faults.is_empty() && native.lines().count() == LIBRARY_STEPS,
        "on this machine, and {place}:\n{}",
        if faults.is_empty() { &native } else { &faults }
    );
    Ok(native)
}

/// Lines that two runs do not share.
fn differences(native: &str, found: &str) -> String {
    let lines = native.lines().count().max(found.lines().count());
    let pairs =
        (0..lines).map(|i| [native, found].map(|said| said.lines().nth(i).unwrap_or("nothing")));
    pairs
        .filter(|[native, found]| native != found)
        .map(|[native, found]| format!("{native} / {found}\n"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_step_that_differs_is_told() {
        assert_eq!(
            differences("open: 1\nprepare: 2", "open: 1\nprepare: 2"),
            ""
        );
        let told = differences("open: 1\nprepare: 2", "open: 1\nprepare: 3");
        assert_eq!(told, "prepare: 2 / prepare: 3\n");
        let told = differences("open: 1\nprepare: 2", "failed: no");
        assert_eq!(told, "open: 1 / failed: no\nprepare: 2 / nothing\n");
    }
}
