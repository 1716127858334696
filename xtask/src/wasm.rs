//! The checks that the libraries build for WebAssembly, and that they play there as they do here.
//!
//! The target's standard library comes from rustup or is already part of the toolchain. Debian's
//! wasm packages are too old for the language edition in use.

use crate::chores::{answer, cargo, root, run};
use crate::outcome::{Outcome, lacking};
use anyhow::Result;
use std::path::{Path, PathBuf};
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

/// Package of the program that hashes what a playback shows.
const PLAYBACK: &str = "articula-playback-hash";

/// Calls the exported function of a module, given as the first argument, in node.
const CALL: &str = "
const bytes = require('fs').readFileSync(process.argv[1]);
WebAssembly.instantiate(bytes).then(({ instance }) => {
  const hash = BigInt.asUintN(64, instance.exports.playback_hash());
  console.log(hash.toString(16).padStart(16, '0'));
});
";

/// Compares the hash of a playback on this machine with that of the same program in node. The
/// module has SIMD instructions: glam adds in another order without them.
pub(crate) fn playback() -> Result<Outcome> {
    if answer("node", &["--version"]).is_none() {
        return lacking("playback in node (node not found)".to_owned());
    }
    if !installed() {
        return lacking("playback in node (wasm32 target not installed)".to_owned());
    }
    let build = ["build", "--quiet", "-p", PLAYBACK];
    run(cargo().args(build))?;
    run(cargo()
        .args(build)
        .args(["--target", TARGET])
        .env("RUSTFLAGS", "-C target-feature=+simd128"))?;
    let target = std::env::var_os("CARGO_TARGET_DIR").map(PathBuf::from);
    let built = target.unwrap_or_else(|| root().join("target"));
    let native = output(&mut Command::new(built.join("debug").join(PLAYBACK)))?;
    let module = built
        .join(TARGET)
        .join("debug")
        .join(format!("{PLAYBACK}.wasm"));
    let node = output(Command::new("node").args(["-e", CALL]).arg(module))?;
    anyhow::ensure!(
        native == node && native.len() == 16 && native != "0000000000000000",
        "the playback shows {native} on this machine and {node} in node"
    );
    Ok(Outcome::Done)
}

/// Runs a program and returns what it prints.
fn output(program: &mut Command) -> Result<String> {
    let ran = program.output()?;
    let said = String::from_utf8_lossy(&ran.stderr);
    anyhow::ensure!(ran.status.success(), "{program:?}: {said}");
    Ok(String::from_utf8_lossy(&ran.stdout).trim().to_owned())
}

/// Returns whether the compiler in use has the target's standard library.
fn installed() -> bool {
    let words = ["--print", "target-libdir", "--target", TARGET];
    answer("rustc", &words).is_some_and(|folder| Path::new(&folder).is_dir())
}
