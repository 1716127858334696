//! What is known of a source that was packaged, so that it never is again.

use crate::error::ServeError;
use crate::objects::{Coding, ObjectName, Objects, read, write};
use crate::options::ServeOptions;
use crate::source::Source;
use articula::formats::Limits;
use articula::item::{FileEntry, Item, MANIFEST, Manifest, compressed};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// An item, whole or a stage of it, whose files are objects.
#[derive(Debug, Clone)]
pub(crate) struct Served {
    /// Name of the object that is its manifest.
    pub(crate) name: ObjectName,
    pub(crate) manifest: Arc<Manifest>,
    /// The objects of its files.
    pub(crate) files: BTreeMap<String, ObjectName>,
    /// Bytes of all files, as they are and as they are sent.
    pub(crate) bytes: u64,
    pub(crate) sent_bytes: u64,
}

impl Served {
    /// Stores the files of an item and its manifest.
    pub(crate) fn store(item: &Item, objects: &Objects) -> Result<Self, ServeError> {
        for (file, entry) in &item.manifest.files {
            let (Some(bytes), Some(name)) = (item.file(file), ObjectName::parse(&entry.hash))
            else {
                continue;
            };
            objects.put(&name, Coding::Identity, bytes)?;
            // Stages share most files, and compressing one takes long.
            if entry.compressed_bytes.is_some()
                && objects.get(&name, Coding::Brotli)?.is_none()
                && let Some(short) = compressed(file, bytes)
            {
                objects.put(&name, Coding::Brotli, &short)?;
            }
        }
        // The manifest comes last.
        let manifest = item
            .files()
            .pop()
            .map(|(_, bytes)| bytes)
            .unwrap_or_default();
        let name = ObjectName::of(&manifest);
        objects.put(&name, Coding::Identity, &manifest)?;
        if objects.get(&name, Coding::Brotli)?.is_none()
            && let Some(short) = compressed(MANIFEST, &manifest)
        {
            objects.put(&name, Coding::Brotli, &short)?;
        }
        Ok(Self::new(name, &item.manifest))
    }

    /// The item with all of its files, from the store.
    pub(crate) fn item(&self, objects: &Objects) -> Result<Item, ServeError> {
        let of = |name: &ObjectName| match objects.get(name, Coding::Identity) {
            Ok(Some(bytes)) => Ok(bytes),
            Ok(None) => Err("the store has lost this object".to_owned()),
            Err(error) => Err(error.to_string()),
        };
        let lost = |error| ServeError::Character(articula::Error::Io(error));
        let manifest = of(&self.name).map_err(lost)?;
        let mut file = |file: &str| match self.files.get(file) {
            Some(name) => of(name).map(Vec::from),
            None => Err("the item has no such file".to_owned()),
        };
        Ok(Item::open(&manifest, &Limits::default(), &mut file)?)
    }

    fn new(name: ObjectName, of: &Manifest) -> Self {
        let files = of.files.iter();
        let name_of = |(file, entry): (&String, &FileEntry)| {
            Some((file.clone(), ObjectName::parse(&entry.hash)?))
        };
        Self {
            name,
            manifest: Arc::new(of.clone()),
            files: files.clone().filter_map(name_of).collect(),
            bytes: files.clone().map(|(_, entry)| entry.bytes).sum(),
            sent_bytes: files.map(|(_, entry)| entry.sent_bytes()).sum(),
        }
    }
}

/// The record of a packaged source.
#[derive(Debug, Serialize, Deserialize)]
struct Record {
    /// Name of the object that is the manifest.
    manifest: String,
}

/// Records by the hash of a source and of how it is packaged.
#[derive(Debug)]
pub(crate) struct Records {
    folder: PathBuf,
    /// What other options or another program make of a source is another item.
    how: String,
}

impl Records {
    pub(crate) fn new(folder: PathBuf, options: &ServeOptions) -> Self {
        let how = format!("{} {:?}", env!("CARGO_PKG_VERSION"), options.package);
        Self { folder, how }
    }

    /// Returns the item of a source, if it was packaged and all of its manifest is there.
    pub(crate) fn get(
        &self,
        record: &Path,
        objects: &Objects,
    ) -> Result<Option<Served>, ServeError> {
        let Some(record) = read(record)? else {
            return Ok(None);
        };
        let record: Option<Record> = serde_json::from_slice(&record).ok();
        let Some(name) = record.and_then(|record| ObjectName::parse(&record.manifest)) else {
            return Ok(None);
        };
        // What was lost or changed is made anew.
        let Ok(Some(manifest)) = objects.get(&name, Coding::Identity) else {
            return Ok(None);
        };
        let of: Option<Manifest> = serde_json::from_slice(&manifest).ok();
        let served = of.map(|of| Served::new(name, &of));
        Ok(served.filter(|served| served.files.values().all(|name| objects.has(name))))
    }

    /// Records that a source was packaged.
    pub(crate) fn put(&self, source: &Source, served: &Served) -> Result<(), ServeError> {
        let record = Record {
            manifest: served.name.as_str().to_owned(),
        };
        // A text and a name cannot fail.
        let text = serde_json::to_vec(&record).unwrap_or_default();
        write(&self.path(source), &text)
    }

    /// The file of the record of a source.
    pub(crate) fn path(&self, source: &Source) -> PathBuf {
        let mut hasher = blake3::Hasher::new();
        hasher.update(source.hash().as_bytes());
        hasher.update(self.how.as_bytes());
        self.folder
            .join(format!("{}.json", hasher.finalize().to_hex()))
    }
}
