//! The check that the libraries build for WebAssembly.
//!
//! The target's standard library comes from rustup or is already part of the toolchain. Debian's
//! wasm packages are too old for the language edition in use.

use crate::chores::{answer, cargo, run};
use crate::outcome::{Outcome, lacking};
use anyhow::Result;
use std::path::Path;
use std::process::Command;

const TARGET: &str = "wasm32-unknown-unknown";

/// Libraries that a web page may use.
const LIBRARIES: &[&str] = &[
    "articula-core",
    "articula-formats",
    "articula-build",
    "articula-flat",
    "articula-stream",
    "articula-human",
    "articula",
];

/// Builds the libraries for WebAssembly, after installing the target.
pub(crate) fn check() -> Result<Outcome> {
    if !installed() && run(Command::new("rustup").args(["target", "add", TARGET])).is_err() {
        return lacking(format!(
            "wasm32 target (not installed, and rustup could not add it: `rustup target add {TARGET}`)"
        ));
    }
    let words = ["check", "--quiet", "--target", TARGET];
    let packages = LIBRARIES.iter().flat_map(|name| ["-p", name]);
    run(cargo().args(words).args(packages))?;
    // Streams without their codecs, for programs that only cut them.
    run(cargo()
        .args(words)
        .args(["-p", "articula-stream", "--no-default-features"]))?;
    // The core has SIMD code for modules compiled with it.
    run(cargo()
        .args(words)
        .args(["-p", "articula-core"])
        .env("RUSTFLAGS", "-C target-feature=+simd128"))?;
    Ok(Outcome::Done)
}

/// Returns whether the compiler in use has the target's standard library.
fn installed() -> bool {
    let words = ["--print", "target-libdir", "--target", TARGET];
    answer("rustc", &words).is_some_and(|folder| Path::new(&folder).is_dir())
}
