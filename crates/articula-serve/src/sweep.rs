//! Removes what nothing names any more: jobs of sources that are gone, what queries made of their items, objects.
#![allow(
    clippy::disallowed_methods,
    reason = "the store is a folder, and files have ages"
)]

use crate::catalogue::Catalogue;
use crate::database::variants::{CUT, Variant};
use crate::database::{jobs, variants};
use crate::error::ServeError;
use crate::objects::{Coding, ObjectName, remove};
use articula::item::Manifest;
use std::collections::BTreeSet;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Age from which files and rows are removed: younger files may be those of another server on the folder, and what was
/// removed just now may come again.
const AGE: Duration = Duration::from_secs(3600);

/// Removes it, and returns the number of files and rows. Not while characters are packaged: what was left of one before
/// comes into use again.
pub(crate) fn sweep(catalogue: &Catalogue) -> Result<u64, ServeError> {
    if catalogue.options().read_only {
        return Ok(0);
    }
    let database = catalogue.database();
    let rows = database.write(|db| jobs::sweep(db, AGE.as_secs()))?;
    let objects = in_use(catalogue, &database.read(variants::all)?);
    let mut removed = rows as u64;
    for folder in entries(&catalogue.folder("objects"))? {
        for path in files(&folder)? {
            let name = path.file_stem().unwrap_or_default().to_string_lossy();
            if !objects.contains(&*name) {
                removed += u64::from(is_old(&path) && remove(&path).is_ok());
            }
        }
    }
    Ok(removed)
}

/// The objects of all that is served, and of what queries made.
fn in_use(catalogue: &Catalogue, variants: &[Variant]) -> BTreeSet<String> {
    let mut objects = BTreeSet::new();
    for (_, state) in catalogue.states() {
        if let Some(served) = state.served {
            objects.insert(served.name.as_str().to_owned());
            objects.extend(served.files.into_values().map(|of| of.as_str().to_owned()));
        }
    }
    for variant in variants {
        objects.extend(named(catalogue, variant));
        objects.insert(variant.object.clone());
    }
    objects
}

/// The objects of the manifest that a query made, if that is what it made.
fn named(catalogue: &Catalogue, of: &Variant) -> Vec<String> {
    let name = ObjectName::parse(&of.object).filter(|_| of.form == CUT);
    let manifest = name.and_then(|name| {
        let bytes = catalogue.objects().get(&name, Coding::Identity);
        serde_json::from_slice::<Manifest>(&bytes.ok()??).ok()
    });
    let files = manifest.into_iter().flat_map(|of| of.files.into_values());
    files.map(|entry| entry.hash).collect()
}

fn is_old(path: &Path) -> bool {
    let written = fs::metadata(path).and_then(|of| of.modified());
    let age = written.map(|written| SystemTime::now().duration_since(written));
    matches!(age, Ok(Ok(age)) if age >= AGE)
}

/// What is in a folder; nothing if there is none.
fn entries(folder: &Path) -> Result<Vec<PathBuf>, ServeError> {
    let fault = |error: std::io::Error| ServeError::store(folder, &error);
    let found = match fs::read_dir(folder) {
        Ok(found) => found,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(fault(error)),
    };
    found
        .map(|entry| entry.map(|entry| entry.path()).map_err(fault))
        .collect()
}

fn files(folder: &Path) -> Result<Vec<PathBuf>, ServeError> {
    match folder.is_file() {
        true => Ok(Vec::new()),
        false => {
            let mut found = entries(folder)?;
            found.retain(|path| path.is_file());
            Ok(found)
        }
    }
}
