//! Items as they are served: whole, or a stage, with their files as objects.

use crate::database::jobs::ItemRow;
use crate::error::ServeError;
use crate::objects::{Coding, ObjectName, Objects};
use articula::formats::Limits;
use articula::item::{FileEntry, Item, MANIFEST, Manifest, compressed};
use std::collections::BTreeMap;
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

    /// The item of a manifest, if it and all of its files are there: what was lost or changed is made anew.
    pub(crate) fn find(manifest: &str, objects: &Objects) -> Option<Self> {
        let name = ObjectName::parse(manifest)?;
        let bytes = objects.get(&name, Coding::Identity).ok()??;
        let of: Manifest = serde_json::from_slice(&bytes).ok()?;
        let served = Self::new(name, &of);
        let is_whole = served.files.values().all(|name| objects.has(name));
        is_whole.then_some(served)
    }

    /// Its row in the catalogue.
    pub(crate) fn row(&self) -> ItemRow<'_> {
        ItemRow {
            manifest: self.name.as_str(),
            bytes: self.bytes,
            sent_bytes: self.sent_bytes,
        }
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
