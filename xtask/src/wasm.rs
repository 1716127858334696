//! The check that the libraries build for the web.
//!
//! The target's standard library comes from rustup, or lies in the toolchain already. Debian's
//! own wasm packages are years older than our language edition, so there is no third way.

use crate::chores::{answer, cargo, run};
use crate::outcome::{Outcome, lacking};
use anyhow::Result;
use std::path::Path;
use std::process::Command;

const TARGET: &str = "wasm32-unknown-unknown";

/// Libraries that a page may use.
const LIBRARIES: &[&str] = &[
    "articula-core",
    "articula-formats",
    "articula-build",
    "articula-flat",
    "articula-stream",
    "articula-human",
    "articula",
];

/// Checks the libraries for the web, after fetching the target.
pub(crate) fn check() -> Result<Outcome> {
    if !installed() && run(Command::new("rustup").args(["target", "add", TARGET])).is_err() {
        return lacking(format!(
            "wasm32 target (not installed, and rustup could not add it: `rustup target add {TARGET}`)"
        ));
    }
    let words = ["check", "--quiet", "--target", TARGET];
    let packages = LIBRARIES.iter().flat_map(|name| ["-p", name]);
    run(cargo().args(words).args(packages))?;
    // Streams without their codecs: all that a program which only cuts them needs.
    run(cargo()
        .args(words)
        .args(["-p", "articula-stream", "--no-default-features"]))?;
    // The core has vector code of its own for modules that are compiled for it.
    run(cargo()
        .args(words)
        .args(["-p", "articula-core"])
        .env("RUSTFLAGS", "-C target-feature=+simd128"))?;
    Ok(Outcome::Done)
}

/// Whether the compiler in use has the target's standard library.
fn installed() -> bool {
    let words = ["--print", "target-libdir", "--target", TARGET];
    answer("rustc", &words).is_some_and(|folder| Path::new(&folder).is_dir())
}
