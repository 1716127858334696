//! Where the real files lie, for the tests that read them.

use std::path::{Path, PathBuf};

/// The folder of real files; `None`, and one line that says so, if it is not there and
/// `ARTICULA_REQUIRE_DATA` does not ask for it.
pub(crate) fn real_data() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = std::env::var_os("ARTICULA_DATA").map_or(beside, PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    let required = std::env::var_os("ARTICULA_REQUIRE_DATA").is_some_and(|v| v == "1");
    assert!(!required, "{} is required", folder.display());
    println!("skipped: no data");
    None
}
