//! The folders of the workspace, and its cargo.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Returns the root of the repository.
pub(crate) fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).to_path_buf()
}

/// Returns the folder of everything that is built.
pub(crate) fn target() -> PathBuf {
    let given = std::env::var_os("CARGO_TARGET_DIR").map(PathBuf::from);
    given.unwrap_or_else(|| root().join("target"))
}

/// Returns the folder of real characters, whether it is there or not.
pub(crate) fn data_folder() -> PathBuf {
    let given = std::env::var_os("ARTICULA_DATA").map(PathBuf::from);
    given.unwrap_or_else(|| root().join("../shared/data"))
}

/// Returns a call of the running cargo, in the root of the repository.
pub(crate) fn cargo() -> Command {
    let mut call = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    call.current_dir(root());
    call
}
