//! The folder of a digital item.

use super::{Files, shown};
use crate::error::{Context, Error, Result};
use crate::item::{Item, MANIFEST, assemble};
use crate::open::{CharacterFile, OpenOptions};
use articula_formats::Limits;
use std::path::Path;

impl Files {
    /// Opens the folder of a digital item as the character that it holds.
    pub(super) fn open_character_of_item(
        &self,
        folder: &Path,
        options: &OpenOptions,
    ) -> Result<CharacterFile> {
        let name = shown(folder);
        let item = self.open_item(folder, &options.limits)?;
        let opened = assemble(&item, options).with_context(|| &name)?;
        Ok(opened.renamed(name))
    }

    /// Opens the folder of a digital item; files are read inside it alone.
    ///
    /// # Errors
    /// As [`Item::open`], with the name of the folder.
    pub fn open_item(&self, folder: &Path, limits: &Limits) -> Result<Item> {
        let name = || shown(folder);
        let manifest = folder.join(MANIFEST);
        let bytes = self.read(&manifest, limits.bytes);
        let bytes = bytes.map_err(|e| e.cause().to_string());
        let bytes = bytes
            .map_err(Error::Io)
            .context(MANIFEST)
            .with_context(name)?;
        let mut fetch = self.beside(&manifest, limits.bytes);
        Item::open(&bytes, limits, &mut fetch).with_context(name)
    }
}
