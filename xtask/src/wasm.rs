//! The checks that the libraries build for WebAssembly, and that they play there as they do here.
//!
//! The target's standard library comes from rustup or is already part of the toolchain. Debian's
//! wasm packages are too old for the language edition in use.

use crate::outcome::{Outcome, lacking};
use crate::platform::{self, LIBRARY, PLAYBACK};
use crate::processes::{answer, output, run};
use crate::wasm_build::TARGET;
use crate::web;
use crate::workspace::{cargo, target};
use anyhow::Result;
use std::process::Command;

/// Flags of the compiler for the checks, in which code that a set of features leaves unused is an error.
const CHECKED: &str = "-C target-feature=+simd128 -D warnings";

/// Libraries that a web page may use; with them `articula-stream` and its codecs, which the last one needs.
const LIBRARIES: &[&str] = &[
    "articula-core",
    "articula-formats",
    "articula-build",
    "articula-flat",
    "articula-human",
    "articula-speech",
    "articula",
];

/// Features with which the library is checked: none, for pages that only play, and each of its features alone, but for
/// `formats`, which opens files and is used nowhere else; `item` needs all others.
const FEATURES: &[&str] = &["", "prepare", "flat", "streams", "fbx", "speech"];

/// Checks the libraries for WebAssembly, after installing the target.
pub(crate) fn check() -> Result<Outcome> {
    if !platform::add(TARGET) {
        return lacking(format!(
            "wasm32 target (not installed, and rustup could not add it: `rustup target add {TARGET}`)"
        ));
    }
    let words = ["check", "--quiet", "--target", TARGET];
    let packages = LIBRARIES.iter().flat_map(|name| ["-p", name]);
    run(cargo().args(words).args(packages).env("RUSTFLAGS", CHECKED))?;
    for features in FEATURES {
        let alone = ["-p", "articula", "--no-default-features", "--features"];
        run(cargo()
            .args(words)
            .args(alone)
            .arg(features)
            .env("RUSTFLAGS", CHECKED))?;
    }
    // The core, which alone knows of instructions, without them; and streams without their codecs,
    // for programs that only cut them.
    run(cargo()
        .args(words)
        .args(["-p", "articula-stream", "--no-default-features"]))?;
    Ok(Outcome::Done)
}

/// Calls the exported function of a module, given as the first argument, in node.
const CALL: &str = "
const bytes = require('fs').readFileSync(process.argv[1]);
WebAssembly.instantiate(bytes).then(({ instance }) => {
  const hash = BigInt.asUintN(64, instance.exports.playback_hash());
  console.log(hash.toString(16).padStart(16, '0'));
});
";

/// Prints what the program of a module would print, from its exported functions.
const SAY: &str = "
const bytes = require('fs').readFileSync(process.argv[1]);
WebAssembly.instantiate(bytes).then(({ instance }) => {
  const { say, said } = instance.exports;
  const text = Uint8Array.from({ length: say() }, (_, at) => said(at));
  console.log(new TextDecoder().decode(text));
});
";

/// Compares the hash of a playback on this machine with that of the same program in node. The
/// module has SIMD instructions: glam adds in another order without them. So too each step of the
/// library: what it opens, prepares, plays, flattens, packages and adapts. Then tests the modules for web pages,
/// whose figures and crowds have the same hashes.
pub(crate) fn playback() -> Result<Outcome> {
    if answer("node", &["--version"]).is_none() {
        return lacking("playback in node (node not found)".to_owned());
    }
    if !platform::installed(TARGET) {
        return lacking("playback in node (wasm32 target not installed)".to_owned());
    }
    let modules = web::dev_modules()?;
    let said = |script: &str, name: &str| {
        let module = platform::built(TARGET).join(format!("{name}.wasm"));
        output(Command::new("node").args(["-e", script]).arg(module))
    };
    platform::compare_playback("in node", &said(CALL, PLAYBACK)?)?;
    let folder = target().join("xtask");
    std::fs::create_dir_all(&folder)?;
    let prepared = folder.join("prepared.glb");
    let steps = platform::compare_library("in node", &said(SAY, LIBRARY)?, &prepared)?;
    // The tests of the studio compare with the same steps.
    std::fs::write(folder.join("library-steps.txt"), &steps)?;
    web::test(&modules, &steps, &prepared)?;
    Ok(Outcome::Done)
}
