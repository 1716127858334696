//! Access to the data folder of real characters.

use anyhow::{Result, bail};
use articula::Figure;
use articula_build::Asset;
use std::path::{Path, PathBuf};

/// Returns the data folder: the given one, `ARTICULA_DATA`, `../shared/data` next to the
/// repository or, for what needs a few files only, the repository's own `assets`.
/// `None` if there is none and `ARTICULA_REQUIRE_DATA` does not require it.
pub(crate) fn folder(given: Option<&Path>, small: bool) -> Result<Option<PathBuf>> {
    let named = given
        .map(Path::to_owned)
        .or_else(|| std::env::var_os("ARTICULA_DATA").map(PathBuf::from));
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = named.unwrap_or(root);
    if folder.is_dir() {
        return Ok(Some(folder));
    }
    if given.is_some() || std::env::var_os("ARTICULA_REQUIRE_DATA").is_some_and(|v| v == "1") {
        bail!("{}: no such folder", folder.display());
    }
    Ok(small.then(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets")))
}

/// Opens a character of the data folder, maps its joints by name and builds the asset.
pub(crate) fn asset(data: &Path, name: &str) -> Result<Asset> {
    Ok(Figure::new(articula::fs::open(data.join(name))?)?.asset)
}

/// As [`asset`], with travelling clips kept in place.
pub(crate) fn asset_on_the_spot(data: &Path, name: &str) -> Result<Asset> {
    let mut opened = articula::fs::open(data.join(name))?;
    opened.put_in_place();
    Ok(Figure::new(opened)?.asset)
}
