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

/// Its feature that asks for the library which both modules share in tests.
pub(crate) const WHOLE: &str = "articula-wasm/whole";

/// Crates whose calculations take most of the time of the steps: optimised a little, the module is built and
/// has run in less time.
const HEAVY: &[&str] = &[
    "articula-build",
    "articula-core",
    "articula-flat",
    "articula-stream",
    "glam",
];

/// Builds what runs in node, with a feature of one of its packages. All packages are named in every call, so that
/// cargo compiles the library once.
pub(crate) fn build_dev(feature: &str) -> Result<()> {
    let optimised = HEAVY.iter().flat_map(|name| {
        let setting = format!("profile.dev.package.{name}.opt-level=1");
        ["--config".to_owned(), setting]
    });
    let words = ["build", "--quiet", "--target", TARGET];
    run(cargo()
        .args(words)
        .args(["-p", PLAYBACK, "-p", PACKAGE, "--features", feature])
        .args(optimised)
        .env("RUSTFLAGS", SIMD))
}
