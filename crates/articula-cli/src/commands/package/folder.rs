//! The folder of an item that is made in stages: from the first one on it holds a whole item.

use crate::files::{Files, write_again};
use articula::item::Item;
use std::path::Path;

/// A folder, and what it holds.
pub(crate) struct ItemFolder<'a> {
    files: &'a Files,
    folder: &'a Path,
    /// The item that was written last.
    written: Option<Item>,
}

impl<'a> ItemFolder<'a> {
    /// A folder without a file of the item.
    pub(crate) fn new(files: &'a Files, folder: &'a Path) -> Self {
        Self {
            files,
            folder,
            written: None,
        }
    }

    /// Writes what an item has more than the one before, its manifest last, after these documents.
    pub(crate) fn write(
        &mut self,
        item: &Item,
        documents: Vec<(String, Vec<u8>)>,
    ) -> articula::Result<()> {
        let before = self.written.as_ref();
        let is_new = |(name, bytes): &(String, Vec<u8>)| {
            before.and_then(|before| before.file(name)) != Some(bytes)
        };
        let changed: Vec<_> = item.files().into_iter().filter(is_new).collect();
        write_again(
            self.files,
            self.folder,
            documents.into_iter().chain(changed),
        )?;
        self.written = Some(item.clone());
        Ok(())
    }
}
