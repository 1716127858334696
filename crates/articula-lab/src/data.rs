//! Where the real characters lie, and how one becomes an asset.

use anyhow::{Context, Result, bail};
use articula_build::ClipOptions;
use articula_build::scene::put_in_place;
use articula_build::{Asset, character};
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

/// Reads a character of the data folder, maps its joints by name, and builds it.
pub(crate) fn asset(data: &Path, name: &str) -> Result<Asset> {
    built(data, name, Place::AsAuthored)
}

/// The same with clips that travel played on the spot.
pub(crate) fn asset_on_the_spot(data: &Path, name: &str) -> Result<Asset> {
    built(data, name, Place::OnTheSpot)
}

fn built(data: &Path, name: &str, place: Place) -> Result<Asset> {
    let path = data.join(name);
    let opened = articula::fs::open(&path)?;
    let articulation = opened.mapping.articulation;
    let mut source = opened.character;
    if place == Place::OnTheSpot {
        put_in_place(&mut source, articulation.clone(), &[]);
    }
    character(&source, Some(articulation), &ClipOptions::default())
        .with_context(|| path.display().to_string())
}

/// What becomes of clips that travel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    /// They travel.
    AsAuthored,
    /// They are played on the spot.
    OnTheSpot,
}
