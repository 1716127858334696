//! Items that were packaged elsewhere: in a folder of their own, or in one file (ZIP, APPNOTE.TXT of PKWARE).
#![allow(clippy::disallowed_methods, reason = "the store is a folder")]

use articula::formats::Limits;
use articula::item::{Item, MANIFEST};
use articula::{Error, Result};
use std::fs::File;
use std::io::{Cursor, Read};
use std::path::Path;
use zip::ZipArchive;

/// First bytes of a ZIP file that is not empty.
const MAGIC: &[u8] = b"PK\x03\x04";

/// Whether bytes may be those of an item in one file.
pub(crate) fn is_packed(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Reads an item in one file: the manifest at the root, or in the only folder there, and the files that it names beside
/// it. Of all of them no more is unpacked than the limit of bytes; then each must have as many as the manifest says.
pub(crate) fn open_packed(bytes: &[u8], limits: &Limits) -> Result<Item> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(unsuited)?;
    let names = archive.file_names().filter_map(std::result::Result::ok);
    let manifests = names.filter(|name| {
        let folder = name.strip_suffix(MANIFEST);
        let is_folder = |folder: &str| folder.ends_with('/') && folder.matches('/').count() == 1;
        folder.is_some_and(|folder| folder.is_empty() || is_folder(folder))
    });
    let Some(path) = manifests.min_by_key(|name| name.len()) else {
        let what =
            format!("the ZIP file has no {MANIFEST}; pack the folder that articula package makes");
        return Err(Error::Unsupported(what));
    };
    let path = path.into_owned();
    let folder = path.strip_suffix(MANIFEST).unwrap_or_default();
    let mut left = limits.bytes;
    let mut unpack = |name: &str| {
        let file = archive.by_name(name).map_err(|error| error.to_string())?;
        let mut bytes = Vec::new();
        // What a file says of its size may be wrong.
        let read = file.take(left.saturating_add(1)).read_to_end(&mut bytes);
        read.map_err(|error| error.to_string())?;
        left = match left.checked_sub(bytes.len() as u64) {
            Some(left) => left,
            None => return Err(format!("the files have more than {} bytes", limits.bytes)),
        };
        Ok(bytes)
    };
    let manifest = unpack(&path).map_err(Error::Io)?;
    hashed(Item::open(&manifest, limits, &mut |file| {
        unpack(&format!("{folder}{file}"))
    })?)
}

/// Reads an item in a folder of its own.
pub(crate) fn open_folder(folder: &Path, manifest: &[u8], limits: &Limits) -> Result<Item> {
    let mut resolver = |name: &str| {
        let mut bytes = Vec::new();
        let file = File::open(folder.join(name)).map_err(|error| error.to_string())?;
        let read = file
            .take(limits.bytes.saturating_add(1))
            .read_to_end(&mut bytes);
        read.map(|_| bytes).map_err(|error| error.to_string())
    };
    hashed(Item::open(manifest, limits, &mut resolver)?)
}

/// The item, if its manifest has the hashes by which files are served.
fn hashed(item: Item) -> Result<Item> {
    match item
        .manifest
        .sizes()
        .iter()
        .all(|(name, _)| item.manifest.files.contains_key(*name))
    {
        true => Ok(item),
        false => {
            let what = "the manifest has no hashes of its files; package the character again";
            Err(Error::Unsupported(what.to_owned()))
        }
    }
}

fn unsuited(error: zip::result::ZipError) -> Error {
    Error::Unsupported(format!("the ZIP file: {error}"))
}
