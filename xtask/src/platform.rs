//! What the checks on other platforms share: the targets, and the hash of a playback, which must be
//! that of this machine.

use crate::chores::{answer, cargo, root, run};
use anyhow::Result;
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

/// Returns the folder of the programs and modules that cargo builds for a target, or for this
/// machine.
pub(crate) fn built(target: Option<&str>) -> PathBuf {
    let folder = std::env::var_os("CARGO_TARGET_DIR").map(PathBuf::from);
    let folder = folder.unwrap_or_else(|| root().join("target"));
    folder.join(target.unwrap_or_default()).join("debug")
}

/// Compares the hash of a playback on this machine with the one found at a `place`.
pub(crate) fn compare_playback(place: &str, found: &str) -> Result<()> {
    run(cargo().args(["build", "--quiet", "-p", PLAYBACK]))?;
    let native = output(&mut Command::new(built(None).join(PLAYBACK)))?;
    anyhow::ensure!(
        native == found && native.len() == 16 && native != "0000000000000000",
        "the playback shows {native} on this machine and {found} {place}"
    );
    Ok(())
}

/// Runs a program and returns what it prints.
pub(crate) fn output(program: &mut Command) -> Result<String> {
    let ran = program.output()?;
    let [said, faults] = [&ran.stdout, &ran.stderr].map(|text| String::from_utf8_lossy(text));
    anyhow::ensure!(ran.status.success(), "{program:?}: {said}{faults}");
    Ok(said.trim().to_owned())
}
