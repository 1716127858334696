//! Node and the packages of the folder `oracle`, which peers and judges run in.

use anyhow::{Result, ensure};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The folder `oracle` of the repository.
pub(crate) fn oracle() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../oracle")
}

/// Whether node runs and the packages, as folders within `oracle`, are installed.
///
/// # Errors
/// If they are missing and `ARTICULA_REQUIRE_TOOLS` requires them.
pub(crate) fn has(packages: &[&str]) -> Result<bool> {
    let runs = Command::new("node").arg("--version").output().is_ok();
    let missing = packages.iter().find(|name| !oracle().join(name).is_dir());
    let fault = match missing {
        _ if !runs => "node does not start".to_owned(),
        Some(name) => format!("there is no oracle/{name} (`npm ci` in the folder of node_modules)"),
        None => return Ok(true),
    };
    ensure!(!required(), "ARTICULA_REQUIRE_TOOLS=1, but {fault}");
    Ok(false)
}

/// Whether `ARTICULA_REQUIRE_TOOLS` requires node, its packages and Chromium.
pub(crate) fn required() -> bool {
    std::env::var_os("ARTICULA_REQUIRE_TOOLS").is_some_and(|v| v == "1")
}
