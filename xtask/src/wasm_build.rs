//! How crates are compiled for WebAssembly.

use crate::platform::PLAYBACK;
use crate::processes::run;
use crate::workspace::cargo;
use anyhow::Result;

pub(crate) const TARGET: &str = "wasm32-unknown-unknown";

/// Flags of the compiler for modules with vector instructions.
pub(crate) const SIMD: &str = "-C target-feature=+simd128";

/// The crate of the modules for web pages.
pub(crate) const PACKAGE: &str = "articula-wasm";

/// Features of what is built in every call: of the program that hashes steps, its part that does, and all of the
/// library, which modules share in tests.
const SHARED: &str = "articula-playback-hash/library,articula-wasm/whole";

/// Crates whose calculations take most of the time of the steps: optimised a little, the module is built and
/// has run in less time.
const HEAVY: &[&str] = &[
    "articula-build",
    "articula-core",
    "articula-flat",
    "articula-stream",
    "glam",
];

/// Builds what runs in node, with a module for web pages if one is named. All packages are named in every call, so that
/// cargo compiles the library once.
pub(crate) fn build_dev(module: Option<&str>) -> Result<()> {
    let optimised = HEAVY.iter().flat_map(|name| {
        let setting = format!("profile.dev.package.{name}.opt-level=1");
        ["--config".to_owned(), setting]
    });
    let module = module.map(|name| format!(",{PACKAGE}/{name}"));
    let features = SHARED.to_owned() + &module.unwrap_or_default();
    let words = ["build", "--quiet", "--target", TARGET];
    run(cargo()
        .args(words)
        .args(["-p", PLAYBACK, "-p", PACKAGE, "--no-default-features"])
        .args(["--features", &features])
        .args(optimised)
        .env("RUSTFLAGS", SIMD))
}
