//! Where the real files lie, for the tests that read them. Tests of other crates include it too.
#![allow(
    dead_code,
    clippy::disallowed_methods,
    clippy::print_stdout,
    reason = "each crate's tests use a part of it; it reads files and says what is skipped"
)]

use std::path::{Path, PathBuf};

/// The folder of real files, whether or not it is there.
pub(crate) fn data_folder() -> PathBuf {
    std::env::var_os("ARTICULA_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    )
}

/// The folder of real files; `None`, and one line that says so, if it is not there and
/// `ARTICULA_REQUIRE_DATA` does not ask for it.
pub(crate) fn real_data() -> Option<PathBuf> {
    let folder = data_folder();
    if folder.join("MANIFEST.md").is_file() {
        return Some(folder);
    }
    assert!(!is_required(), "{} is required", folder.display());
    println!("skipped: no data");
    None
}

/// Whether the real files are there; says so, or fails, as [`real_data`] does.
pub(crate) fn data_is_here() -> bool {
    real_data().is_some()
}

/// A file of the folder. `None` if it is not there and `ARTICULA_REQUIRE_DATA` does not ask for
/// it.
pub(crate) fn bytes(name: &str) -> Option<Vec<u8>> {
    let found = std::fs::read(data_folder().join(name)).ok();
    assert!(found.is_some() || !is_required(), "{name} is missing");
    found
}

fn is_required() -> bool {
    std::env::var_os("ARTICULA_REQUIRE_DATA").is_some_and(|v| v == "1")
}
