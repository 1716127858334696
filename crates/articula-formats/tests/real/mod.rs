//! Where the real files lie, for the tests that read them.

use std::path::PathBuf;

/// A file of the data folder. `None` if it is not there and `ARTICULA_REQUIRE_DATA` does not
/// ask for it.
pub(crate) fn bytes(name: &str) -> Option<Vec<u8>> {
    let root = std::env::var_os("ARTICULA_DATA").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")),
        PathBuf::from,
    );
    let found = std::fs::read(root.join(name)).ok();
    let required = std::env::var_os("ARTICULA_REQUIRE_DATA").is_some_and(|v| v == "1");
    assert!(found.is_some() || !required, "{name} is missing");
    found
}
