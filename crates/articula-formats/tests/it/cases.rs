//! The small files of `tests/cases`.

use std::path::Path;

/// Returns the bytes of a file.
pub(crate) fn case(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../articula-formats/tests/cases");
    std::fs::read(folder.join(name)).unwrap()
}
