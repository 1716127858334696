//! Where the real characters lie, and how one becomes an asset.

use anyhow::{Result, bail};
use articula::Figure;
use articula::crowd::put_in_place;
use articula_build::Asset;
use std::path::{Path, PathBuf};

/// The data folder: the one given, `ARTICULA_DATA`, or `../shared/data` beside the project.
/// `None` if there is none and `ARTICULA_REQUIRE_DATA` does not ask for it.
pub(crate) fn folder(given: Option<&Path>) -> Result<Option<PathBuf>> {
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
    Ok(None)
}

/// Opens a character of the data folder, maps its joints by name, and builds it.
pub(crate) fn asset(data: &Path, name: &str) -> Result<Asset> {
    Ok(Figure::new(articula::fs::open(data.join(name))?)?.asset)
}

/// The same with clips that travel played on the spot.
pub(crate) fn asset_on_the_spot(data: &Path, name: &str) -> Result<Asset> {
    let mut opened = articula::fs::open(data.join(name))?;
    let articulation = opened.articulation();
    put_in_place(&mut opened.character, articulation, &opened.end_sites);
    Ok(Figure::new(opened)?.asset)
}
