//! The check that the core's lanes for AArch64 give the same bits as plain arrays, and that a
//! playback shows there what it shows here, by emulation of that processor.
//!
//! The target's standard library comes from rustup, the linker, the C library and the emulator from
//! Debian: `gcc-aarch64-linux-gnu`, `libc6-dev-arm64-cross`, `qemu-user-static`.

use crate::outcome::{Outcome, lacking};
use crate::platform;
use crate::processes::{answer, output, run};
use crate::workspace::cargo;
use anyhow::Result;
use std::path::{Path, PathBuf};
use std::process::Command;

const TARGET: &str = "aarch64-unknown-linux-gnu";
const LINKER: &str = "aarch64-linux-gnu-gcc";

/// Names of the emulator, the usual one first.
const EMULATORS: [&str; 2] = ["qemu-aarch64-static", "qemu-aarch64"];

/// Everything is built without optimisation: the emulated programs are short, and compiling them
/// takes twice as long as running them. Rounding does not depend on it.
const QUICK: [&str; 2] = ["--profile", "dev"];

/// A test that must be among those that run.
const COMPARISON: &str = "simd::tests::every_backend_gives_the_same_bits ... ok";

/// Runs the tests of the lanes and the playback on an emulated AArch64 processor.
pub(crate) fn check() -> Result<Outcome> {
    if cfg!(target_arch = "aarch64") {
        let why = "neon under emulation (the unit tests run on this machine's own)";
        return Ok(Outcome::Skipped(why.to_owned()));
    }
    let missing = |what: &str| lacking(format!("neon under emulation ({what})"));
    let mut names = EMULATORS.into_iter();
    let Some(emulator) = names.find(|name| answer(name, &["--version"]).is_some()) else {
        return missing("qemu-aarch64 not found; Debian has it in qemu-user-static");
    };
    let Some(libraries) = libraries() else {
        let what = "not found; Debian has them in gcc-aarch64-linux-gnu and libc6-dev-arm64-cross";
        return missing(&format!("{LINKER} or its C library {what}"));
    };
    if !platform::add(TARGET) {
        let what = "not installed, and rustup could not add it: `rustup target add";
        return missing(&format!("{TARGET} {what} {TARGET}`"));
    }
    let runner = format!("{emulator} -L {}", libraries.display());
    let call = |word: &str| {
        let mut call = cargo();
        call.args([word, "--target", TARGET])
            .args(QUICK)
            .env("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER", LINKER)
            .env("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER", &runner);
        call
    };
    let lanes = ["-p", "articula-core", "--lib", "--", "simd", "math"];
    let said = output(call("test").args(lanes))?;
    anyhow::ensure!(said.contains(COMPARISON), "no such test ran: {COMPARISON}");
    run(call("build").args(["--quiet", "-p", platform::PLAYBACK, "--no-default-features"]))?;
    let program = platform::built(TARGET).join(platform::PLAYBACK);
    let mut emulated = Command::new(emulator);
    let found = output(emulated.arg("-L").arg(libraries).arg(program))?;
    platform::compare_playback("on an emulated AArch64 processor", &found)?;
    Ok(Outcome::Done)
}

/// Returns the folder in which the emulator finds the loader and the C library that the linker
/// uses.
fn libraries() -> Option<PathBuf> {
    // Only the name, without a folder, if there is none.
    let file = answer(LINKER, &["-print-file-name=libc.so"])?;
    let file = Path::new(&file).canonicalize().ok()?;
    Some(file.parent()?.parent()?.to_path_buf())
}
