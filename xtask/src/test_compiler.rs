//! Compiles tests without optimisation, while the libraries that they call stay optimised.
//!
//! A profile of cargo holds for a whole package, and each library is compiled twice: for its users, and
//! with its unit tests. Only the first is called for long. The second, and the programs of integration
//! tests, take a third of the compilation, and most run as fast without optimisation. So this program is
//! cargo's `RUSTC_WRAPPER` while it builds the tests. Cargo names the results as it would without, so
//! `cargo test` finds and uses them.

use anyhow::{Context, Result};
use std::ffi::{OsStr, OsString};
use std::process::{Command, ExitCode};

/// Tells this program that cargo calls it as its compiler.
const CALLED: &str = "ARTICULA_TEST_COMPILER";

/// Libraries whose unit tests render pictures or code random surfaces, and take five times as long
/// without optimisation.
const OPTIMISED: &[&str] = &["articula_flat", "articula_stream"];

/// Makes a call of cargo compile tests without optimisation. A wrapper that is set already, such as a
/// cache of compilations, stays in its place.
pub(crate) fn wrap(call: &mut Command) -> Result<&mut Command> {
    if std::env::var_os("RUSTC_WRAPPER").is_some() {
        return Ok(call);
    }
    let this = std::env::current_exe().context("the path of this program is unknown")?;
    Ok(call.env("RUSTC_WRAPPER", this).env(CALLED, "1"))
}

/// Compiles, if cargo has called this program for it, and returns the exit code.
pub(crate) fn compile() -> Option<ExitCode> {
    std::env::var_os(CALLED)?;
    let mut words = std::env::args_os().skip(1);
    let compiler = words.next()?;
    let words: Vec<OsString> = words.collect();
    let mut call = Command::new(&compiler);
    Some(match call.args(&words).args(level(&words)).status() {
        Ok(status) if status.success() => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(fault) => {
            eprintln!("xtask: cannot start {}: {fault}", compiler.display());
            ExitCode::FAILURE
        }
    })
}

/// Returns the option that lowers the level of a test program; the last one counts.
fn level(words: &[OsString]) -> Option<&'static str> {
    let is = |word: &OsString, text: &str| word == OsStr::new(text);
    if !words.iter().any(|word| is(word, "--test")) {
        return None;
    }
    let name = words
        .iter()
        .skip_while(|word| !is(word, "--crate-name"))
        .nth(1)?;
    let is_optimised = OPTIMISED.iter().any(|of| is(name, of));
    Some(if is_optimised {
        "-Copt-level=1"
    } else {
        "-Copt-level=0"
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tests_alone_are_compiled_without_optimisation() {
        let level = |words: &str| level(&words.split(' ').map(OsString::from).collect::<Vec<_>>());
        let library = "--crate-name articula_core src/lib.rs --crate-type lib -C opt-level=2";
        assert_eq!(level(library), None);
        let tests = "--crate-name articula_core src/lib.rs -C opt-level=2 --test";
        assert_eq!(level(tests), Some("-Copt-level=0"));
        let pictures = "--crate-name articula_flat src/lib.rs -C opt-level=2 --test";
        assert_eq!(level(pictures), Some("-Copt-level=1"));
    }
}
