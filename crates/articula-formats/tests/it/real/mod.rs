//! Location of the real files, for the tests that read them. Tests of other crates include it too.
#![allow(
    dead_code,
    clippy::disallowed_methods,
    clippy::print_stdout,
    reason = "each crate's tests use a part of it; it reads files and says what is skipped"
)]

use std::path::{Path, PathBuf};

/// Returns the folder of real files, whether or not it exists.
pub(crate) fn data_folder() -> PathBuf {
    std::env::var_os("ARTICULA_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    )
}

/// Returns the folder of real files; `None`, with a printed line, if it does not exist and
/// `ARTICULA_REQUIRE_DATA` is not set.
pub(crate) fn real_data() -> Option<PathBuf> {
    let folder = data_folder();
    if folder.join("MANIFEST.md").is_file() {
        return Some(folder);
    }
    assert!(!is_required(), "{} is required", folder.display());
    println!("skipped: no data");
    None
}

/// Returns the folder of FBX files, which lies beside that of the other real files; `None`, with a printed
/// line, as [`real_data`].
pub(crate) fn fbx_folder() -> Option<PathBuf> {
    let folder = data_folder().join("../fbx");
    if folder.join("MANIFEST.md").is_file() {
        return Some(folder);
    }
    assert!(!is_required(), "{} is required", folder.display());
    println!("skipped: no FBX files");
    None
}

/// Returns whether the real files exist; prints a line or fails like [`real_data`].
pub(crate) fn data_is_here() -> bool {
    real_data().is_some()
}

/// Returns the path of a real file: of the folder, or of the repository's own `assets`. `None`,
/// with a printed line, if it is in neither and `ARTICULA_REQUIRE_DATA` is not set.
pub(crate) fn file(name: &str) -> Option<PathBuf> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
    let mut places = [data_folder(), own].into_iter().map(|f| f.join(name));
    let found = if is_required() {
        places.next()
    } else {
        places.find(|path| path.is_file())
    };
    if found.is_none() {
        println!("skipped: no {name}");
    }
    found
}

/// Returns the bytes of such a file.
pub(crate) fn bytes(name: &str) -> Option<Vec<u8>> {
    let path = file(name)?;
    let found = std::fs::read(&path);
    Some(found.unwrap_or_else(|fault| panic!("{}: {fault}", path.display())))
}

fn is_required() -> bool {
    std::env::var_os("ARTICULA_REQUIRE_DATA").is_some_and(|v| v == "1")
}
