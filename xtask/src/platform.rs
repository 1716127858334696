//! What the checks on other platforms share: the targets, and the hash of a playback, which must be
//! that of this machine.

use crate::processes::{answer, output, run};
use crate::workspace::target;
use anyhow::{Result, ensure};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Package of the program that hashes what a playback shows.
pub(crate) const PLAYBACK: &str = "articula-playback-hash";

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
