//! The check that streams can be cut and described by a library that has no codec.
//!
//! The tests are a package outside of the workspace (`articula-stream-alone`): features are united over all
//! packages that are built together, and everything else wants the codecs.

use crate::outcome::Outcome;
use crate::processes::run;
use crate::workspace::{cargo, root, target};
use anyhow::Result;
use std::process::Command;

/// Runs the tests of the package.
pub(crate) fn check() -> Result<Outcome> {
    run(&mut call())?;
    Ok(Outcome::Done)
}

/// Returns a call of its tests.
pub(crate) fn call() -> Command {
    let mut call = cargo();
    call.args(["test", "--quiet", "--locked"])
        .current_dir(root().join("crates/articula-stream-alone"))
        .env("CARGO_TARGET_DIR", target().join("cut-alone"));
    call
}
