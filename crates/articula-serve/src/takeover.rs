//! What earlier versions kept as files, taken over into the catalogue: which manifest a source became
//! (`items/KEY.json`), which object a query made (`queries/KEY.json`), and runs of devices (`devices/HASH.jsonl`).
#![allow(clippy::disallowed_methods, reason = "the store is a folder")]

use crate::database::variants::{CUT, GLB, Variant};
use crate::database::{Database, devices, jobs, variants};
use crate::device_store::{name_of, put_row};
use crate::error::ServeError;
use crate::objects::{ObjectName, Objects, read, remove_folder};
use crate::served::Served;
use articula::device::DeviceReport;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// Folders of the files, and the extensions of these.
const ITEMS: (&str, &str) = ("items", "json");
const QUERIES: (&str, &str) = ("queries", "json");
const DEVICES: (&str, &str) = ("devices", "jsonl");

/// `items/KEY.json`.
#[derive(Debug, Deserialize)]
struct ItemRecord {
    manifest: String,
}

/// `queries/KEY.json`.
#[derive(Debug, Deserialize)]
struct QueryRecord {
    object: String,
    /// The manifest of the item.
    item: String,
    form: String,
}

/// Takes the files of a folder over, if there are any, and then removes them, unless nothing may be written: then they
/// are read into memory. Returns a line that tells of it. A server that is killed meanwhile leaves them to the next
/// one, and what the catalogue knows already is not changed.
///
/// # Errors
/// [`ServeError`] of the catalogue, or of a file that cannot be read or removed.
pub(crate) fn take_over(
    made: &Path,
    objects: &Objects,
    database: &Database,
    read_only: bool,
) -> Result<Option<String>, ServeError> {
    let folders = [ITEMS, QUERIES, DEVICES].map(|(name, _)| made.join(name));
    // A catalogue that is only read has all that its writer took over.
    if !database.takes_rows() || !folders.iter().any(|folder| folder.is_dir()) {
        return Ok(None);
    }
    let items = items(&records(made, ITEMS)?, objects);
    let queries = records(made, QUERIES)?;
    let runs = records(made, DEVICES)?;
    let count = database.write(|db| {
        let mut count = 0;
        for (job, served) in &items {
            if jobs::get(db, job)?.is_none() {
                jobs::finish(db, job, &served.row())?;
                count += 1;
            }
        }
        for (variant, served) in variants_of(&queries, &items) {
            if variants::object(db, &variant.variant)?.is_none() {
                variants::put(db, &variant, &served.row())?;
                count += 1;
            }
        }
        for text in runs.values() {
            count += take_runs(db, text)?;
        }
        Ok(count)
    })?;
    if read_only {
        return Ok(None);
    }
    for folder in folders.iter().filter(|folder| folder.is_dir()) {
        remove_folder(folder)?;
    }
    let made = made.display();
    Ok(Some(format!(
        "{made}: {count} records of an earlier version are in the catalogue now"
    )))
}

/// The texts of the files of a folder whose names are hashes, by these.
fn records(
    made: &Path,
    (folder, extension): (&str, &str),
) -> Result<BTreeMap<String, Vec<u8>>, ServeError> {
    let folder = made.join(folder);
    let fault = |error: std::io::Error| ServeError::store(&folder, &error);
    let mut records = BTreeMap::new();
    if !folder.is_dir() {
        return Ok(records);
    }
    for entry in std::fs::read_dir(&folder).map_err(fault)? {
        let path = entry.map_err(fault)?.path();
        let is_record = path.extension().is_some_and(|other| other == extension);
        let stem = path.file_stem().and_then(|stem| stem.to_str());
        let name = stem.filter(|_| is_record).and_then(ObjectName::parse);
        if let (Some(name), Some(text)) = (name, read(&path)?) {
            records.insert(name.as_str().to_owned(), text);
        }
    }
    Ok(records)
}

/// The jobs of which all is there; the others would be done again in any case.
fn items(records: &BTreeMap<String, Vec<u8>>, objects: &Objects) -> BTreeMap<String, Served> {
    let item = |(job, text): (&String, &Vec<u8>)| {
        let record: ItemRecord = serde_json::from_slice(text).ok()?;
        let served = Served::find(&record.manifest, objects)?;
        Some((job.clone(), served))
    };
    records.iter().filter_map(item).collect()
}

/// What queries made of these items.
fn variants_of<'a>(
    records: &BTreeMap<String, Vec<u8>>,
    items: &'a BTreeMap<String, Served>,
) -> Vec<(Variant, &'a Served)> {
    let by_manifest: BTreeMap<&str, &Served> = items
        .values()
        .map(|served| (served.name.as_str(), served))
        .collect();
    let variant = |(key, text): (&String, &Vec<u8>)| {
        let record: QueryRecord = serde_json::from_slice(text).ok()?;
        let served = *by_manifest.get(&*record.item)?;
        let is_known = [CUT, GLB].contains(&&*record.form);
        let variant = Variant {
            variant: key.clone(),
            item: record.item,
            form: record.form,
            // It was hashed alone.
            query: None,
            object: ObjectName::parse(&record.object)?.as_str().to_owned(),
        };
        is_known.then_some((variant, served))
    };
    records.iter().filter_map(variant).collect()
}

/// Takes the runs of a device over, one a line, if it is not known yet.
fn take_runs(db: &rusqlite::Connection, text: &[u8]) -> rusqlite::Result<usize> {
    let lines = text.split(|byte| *byte == b'\n');
    let runs: Vec<DeviceReport> = lines
        .filter_map(|line| DeviceReport::read(line).ok())
        .collect();
    let Some(first) = runs.first() else {
        return Ok(0);
    };
    if !devices::reports(db, name_of(&first.device).as_str())?.is_empty() {
        return Ok(0);
    }
    for run in &runs {
        put_row(db, run)?;
    }
    Ok(runs.len())
}
