//! An item: its manifest and files, whole or cut.

use super::check;
use super::governed::{Governed, numbers_of_regions};
use super::manifest::{Manifest, VERSION};
use super::name::check_name;
use super::part::{ItemLayer, ItemPart};
use super::sent::FileEntry;
use crate::clip_streams::unit_tree;
use crate::error::{Context, Error, Result};
use crate::open::choose;
use articula_formats::{Limits, Resolver};
use articula_stream::{IndexedCut, StreamLimits, Unit, cut_by_index, read_index, write_index};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Name of the manifest's file.
pub const MANIFEST: &str = "manifest.json";
/// Extension of unit indices.
pub const INDEX_EXTENSION: &str = "auix";

/// Cuts a stream: part, kept layers, stream, its unit index.
type Cutter<'a> = dyn FnMut(&ItemPart, &[bool], &[u8], &[u8]) -> Result<IndexedCut> + 'a;

/// A digital item: a manifest, and files by their names in the item.
#[derive(Debug, Clone, PartialEq)]
pub struct Item {
    /// What the files are.
    pub manifest: Manifest,
    files: BTreeMap<String, Vec<u8>>,
}

impl Item {
    /// Creates an item of files that the caller vouches for.
    pub(super) fn new(manifest: Manifest, files: BTreeMap<String, Vec<u8>>) -> Self {
        Self { manifest, files }.described()
    }

    /// The item of a manifest, none of whose files is here: what can be decided about it can be.
    pub(crate) fn elsewhere(manifest: Manifest) -> Self {
        Self {
            manifest,
            files: BTreeMap::new(),
        }
    }

    /// The item with a manifest that describes how its files travel: those that changed anew.
    fn described(mut self) -> Self {
        let mut entries = BTreeMap::new();
        for (name, _) in self.manifest.sizes() {
            let bytes = self.file(name).unwrap_or_default();
            let known = self.manifest.files.get(name).filter(|e| e.is_of(bytes));
            let entry = known.cloned().unwrap_or_else(|| FileEntry::of(name, bytes));
            entries.insert(name.to_owned(), entry);
        }
        self.manifest.files = entries;
        self.manifest.version = VERSION;
        self
    }

    /// Opens an item. `manifest` is the file [`MANIFEST`]; `resolver` returns the other files by the
    /// names that the manifest has, of which only those inside the item are asked for. A unit index
    /// that is missing is made anew from the stream.
    ///
    /// # Errors
    /// An [`Error`] that names the file, and in a manifest the member: malformed JSON, another
    /// version, a name that leaves the item, numbers that contradict each other, a missing file, one
    /// of another size than stated, more bytes than the limit.
    pub fn open(manifest: &[u8], limits: &Limits, resolver: &mut Resolver<'_>) -> Result<Self> {
        let manifest = check::read(manifest, limits).context(MANIFEST)?;
        let mut files = BTreeMap::new();
        for (name, bytes) in manifest.sizes() {
            let file = resolver(name).map_err(Error::Io).context(name)?;
            if file.len() as u64 != bytes {
                let what = format!(
                    "{} bytes, the manifest has {bytes}; package the character again",
                    file.len()
                );
                return Err(Error::unsuited(what)).context(name);
            }
            if manifest.files.get(name).is_some_and(|e| !e.is_of(&file)) {
                let what = "the file was changed: its hash is not that of the manifest; package the \
                            character again";
                return Err(Error::unsuited(what)).context(name);
            }
            files.insert(name.to_owned(), file);
        }
        for index in manifest.parts.iter().filter_map(|p| p.index.as_deref()) {
            let Ok(file) = resolver(index) else { continue };
            if file.len() as u64 > limits.bytes {
                return Err(Error::unsuited("the index exceeds the limit of bytes")).context(index);
            }
            files.insert(index.to_owned(), file);
        }
        Ok(Self { manifest, files })
    }

    /// Returns all files with their names, the manifest last.
    pub fn files(&self) -> Vec<(String, Vec<u8>)> {
        let files = self.files.iter().map(|(n, b)| (n.clone(), b.clone()));
        let manifest = (MANIFEST.to_owned(), self.manifest.to_json());
        files.chain([manifest]).collect()
    }

    /// Returns a file by its name in the item.
    pub fn file(&self, name: &str) -> Option<&[u8]> {
        self.files.get(name).map(Vec::as_slice)
    }

    /// Bytes of all files that the manifest lists, without itself and the unit indices.
    pub fn bytes(&self) -> u64 {
        let files = self.manifest.sizes().into_iter();
        files.map(|(_, bytes)| bytes).fold(0, u64::saturating_add)
    }

    /// Bytes of all these files as they are sent.
    pub fn sent_bytes(&self) -> u64 {
        let files = self.manifest.sizes().into_iter();
        let sent = files.map(|(name, _)| self.manifest.sent_bytes(name));
        sent.fold(0, u64::saturating_add)
    }

    /// Bytes of all these files but the forms in 2D, as they are sent.
    pub fn sent_bytes_of_layers(&self) -> u64 {
        let forms = self.manifest.flat.iter();
        let forms: u64 = forms.map(|form| self.manifest.sent_bytes(&form.file)).sum();
        self.sent_bytes().saturating_sub(forms)
    }

    /// Bytes of the unit indices.
    pub fn index_bytes(&self) -> u64 {
        let indices = self.manifest.parts.iter().filter_map(|p| p.index.as_ref());
        let bytes = indices.filter_map(|name| self.files.get(name));
        bytes.map(|bytes| bytes.len() as u64).sum()
    }

    /// Returns the item with some layers of its parts: streams are cut by their unit trees, without a
    /// codec, and of textures the files of kept sizes stay. `keeps` is asked for each part and layer.
    /// A part of which no layer is kept stays with what all layers have in common; a texture without
    /// a size leaves the item.
    ///
    /// # Errors
    /// [`Error::Argument`] if a kept layer needs one that is not kept ([`ItemPart::closure`] tells
    /// them); an [`Error`] that names the file if an index does not belong to its stream.
    pub fn kept(&self, keeps: impl Fn(&ItemPart, usize) -> bool) -> Result<Self> {
        self.kept_by(&keeps, &mut |part, kept, stream, index| {
            let governed = Governed::of(part, kept);
            cut_by_index(stream, index, |unit| governed.keeps(unit)).context("unit index")
        })
    }

    /// The same with streams cut by `cutter`, which gets part, kept layers, stream and unit index.
    pub(super) fn kept_by(
        &self,
        keeps: &dyn Fn(&ItemPart, usize) -> bool,
        cutter: &mut Cutter<'_>,
    ) -> Result<Self> {
        let mut made = Self {
            manifest: Manifest {
                parts: Vec::new(),
                ..self.manifest.clone()
            },
            files: self.files.clone(),
        };
        for part in &self.manifest.parts {
            let kept: Vec<bool> = (0..part.layers.len()).map(|l| keeps(part, l)).collect();
            if let Some(layer) = part.unmet(&kept) {
                let what = format!(
                    "layer \"{}\" needs layers that are not kept",
                    part.layers[layer].name
                );
                return Err(Error::argument(what)).context(&part.name);
            }
            let cut = match &part.file {
                Some(file) => {
                    let cut = self.cut(part, &kept, &mut made.files, cutter);
                    Some(cut.context(file)?)
                }
                None => sizes(part, &kept, &mut made.files),
            };
            made.manifest.parts.extend(cut);
        }
        Ok(made.described())
    }

    /// Returns the item without its forms in 2D.
    #[must_use]
    pub fn without_flat(&self) -> Self {
        let mut made = self.clone();
        for form in std::mem::take(&mut made.manifest.flat) {
            made.remove(&form.file);
        }
        made
    }

    /// Returns the item with the motions of these names alone, of the body and of the face; with all of
    /// them without names.
    ///
    /// # Errors
    /// [`Error::Argument`] with the names that there are, if one does not exist.
    pub fn with_clips(&self, names: &[String]) -> Result<Self> {
        if names.is_empty() {
            return Ok(self.clone());
        }
        let parts = || self.manifest.parts.iter();
        let motions = || parts().filter(|part| part.kind.is_motion());
        for name in names {
            choose("clip", name, motions().map(|part| part.name.as_str()))?;
        }
        let stays = |part: &ItemPart| !part.kind.is_motion() || names.contains(&part.name);
        let stay: Vec<bool> = parts().map(stays).collect();
        Ok(self.with_parts(&stay))
    }

    /// Returns the item with some of its parts alone.
    #[must_use]
    pub(super) fn with_parts(&self, stay: &[bool]) -> Self {
        let mut made = self.clone();
        let others = self.manifest.parts.iter().zip(stay);
        let others = others.filter(|(_, stays)| !**stays).map(|(part, _)| part);
        for file in others.flat_map(|part| part.file.iter().chain(&part.index)) {
            made.remove(file);
        }
        let mut stay = stay.iter();
        let mut stays = |_: &ItemPart| stay.next() != Some(&false);
        made.manifest.parts.retain(&mut stays);
        made
    }

    /// Removes a file and what is said of it.
    fn remove(&mut self, file: &str) {
        self.files.remove(file);
        self.manifest.files.remove(file);
    }

    /// Returns the item without some units of its streams, whatever layers they belong to, such as those
    /// of regions that nobody wants. The bytes of layers follow; their errors stay, and so do not count
    /// what is left out.
    ///
    /// # Errors
    /// As [`Self::kept`].
    pub fn without_units(&self, drops: impl Fn(&ItemPart, &Unit) -> bool) -> Result<Self> {
        let mut made = self.clone();
        for part in &mut made.manifest.parts {
            let (Some(file), Some(index)) = (part.file.clone(), part.index.clone()) else {
                continue;
            };
            let missing = || Error::unsuited("the item lacks this file");
            let stream = self.file(&file).ok_or_else(missing).context(&file)?;
            let whole = self.index(part, stream).context(&file)?;
            let cut = cut_by_index(stream, &whole, |unit| !drops(part, unit));
            let cut = cut.context("unit index").context(&file)?;
            if cut.bytes.len() == stream.len() {
                continue;
            }
            let unit = read_index(&cut.index).context(&file)?;
            let left = numbers_of_regions(part.kind, &unit);
            part.regions.retain(|region| left.contains(&region.number));
            part.charge(&unit, cut.bytes.len());
            made.files.insert(index, cut.index);
            made.files.insert(file, cut.bytes);
        }
        Ok(made.described())
    }

    /// Returns the unit tree of the stream of a part.
    ///
    /// # Errors
    /// An [`Error`] for a part without a stream, or an index that does not belong to it.
    pub fn unit_tree(&self, part: &ItemPart) -> Result<Unit> {
        let stream = part.file.as_deref().and_then(|file| self.file(file));
        let missing = || Error::unsuited("the item has no such stream");
        self.unit(part, stream.ok_or_else(missing)?)
    }

    /// The unit index of a stream, or made anew.
    fn index(&self, part: &ItemPart, stream: &[u8]) -> Result<Cow<'_, [u8]>> {
        let index = part.index.as_ref().and_then(|name| self.file(name));
        Ok(match index {
            Some(index) => Cow::Borrowed(index),
            None => Cow::Owned(write_index(&unit_tree(stream, &StreamLimits::default())?)),
        })
    }

    /// The unit tree of a stream: its index, or made anew.
    fn unit(&self, part: &ItemPart, stream: &[u8]) -> Result<Unit> {
        let index = part.index.as_ref().and_then(|name| self.file(name));
        let Some(index) = index else {
            return unit_tree(stream, &StreamLimits::default());
        };
        let unit = read_index(index).context("unit index")?;
        unit.check_values(stream).context("unit index")?;
        Ok(unit)
    }

    /// Cuts a stream.
    fn cut(
        &self,
        part: &ItemPart,
        kept: &[bool],
        files: &mut BTreeMap<String, Vec<u8>>,
        cutter: &mut Cutter<'_>,
    ) -> Result<ItemPart> {
        let (Some(file), Some(index)) = (&part.file, &part.index) else {
            return Ok(part.clone());
        };
        let missing = || Error::unsuited("the item lacks this file");
        let stream = self.file(file).ok_or_else(missing)?;
        let made = cutter(part, kept, stream, &self.index(part, stream)?)?;
        let unit = read_index(&made.index)?;
        let stated = with_layers(part, kept);
        let mut part = stated.clone();
        part.charge(&unit, made.bytes.len());
        let sizes = |part: &ItemPart| -> Vec<u64> {
            let layers = part.layers.iter().map(|layer| layer.bytes);
            layers.chain([part.base_bytes]).collect()
        };
        if sizes(&part) != sizes(&stated) {
            let what = "the layers of the manifest are not those of the stream";
            return Err(Error::unsuited(what));
        }
        files.insert(index.clone(), made.index);
        files.insert(file.clone(), made.bytes);
        Ok(part)
    }
}

/// The part with some layers, numbered anew.
fn with_layers(part: &ItemPart, kept: &[bool]) -> ItemPart {
    let mut numbers = Vec::with_capacity(kept.len());
    let mut next = 0;
    for kept in kept {
        numbers.push(next);
        next += usize::from(*kept);
    }
    let layers = part.layers.iter().zip(kept).filter(|(_, kept)| **kept);
    let layers = layers.map(|(layer, _)| ItemLayer {
        needs: layer.needs.iter().map(|need| numbers[*need]).collect(),
        ..layer.clone()
    });
    let mut made = ItemPart {
        layers: layers.collect(),
        ..part.clone()
    };
    // These describe other cuts than this one.
    let finest = made.layers.iter().filter_map(|l| l.keep.get("level")).min();
    let finest = finest.copied();
    made.levels
        .retain(|level| finest.is_some_and(|finest| level.level >= finest));
    made
}

/// A texture with some of its sizes; `None` without any.
fn sizes(
    part: &ItemPart,
    kept: &[bool],
    files: &mut BTreeMap<String, Vec<u8>>,
) -> Option<ItemPart> {
    for (layer, kept) in part.layers.iter().zip(kept) {
        if let (Some(file), false) = (&layer.file, kept) {
            files.remove(file);
        }
    }
    let mut made = with_layers(part, kept);
    made.bytes = made.bytes_of(&vec![true; made.layers.len()]);
    (!made.layers.is_empty()).then_some(made)
}

/// Files of an item that is being made.
#[derive(Debug, Clone, Default)]
pub(super) struct NewFiles(pub(super) BTreeMap<String, Vec<u8>>);

impl NewFiles {
    /// Adds a file and returns its size.
    pub(super) fn put(&mut self, name: &str, bytes: Vec<u8>) -> Result<u64> {
        check_name(name)?;
        let size = bytes.len() as u64;
        if self.0.insert(name.to_owned(), bytes).is_some() {
            let what = "two files of the item have this name; rename one";
            return Err(Error::argument(what)).context(name);
        }
        Ok(size)
    }
}

impl ItemPart {
    /// Adds the stream of the part with its index.
    pub(super) fn put_stream(
        &mut self,
        file: &str,
        bytes: Vec<u8>,
        unit: &Unit,
        files: &mut NewFiles,
    ) -> Result<()> {
        let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
        let index = format!("{stem}.{INDEX_EXTENSION}");
        self.charge(unit, bytes.len());
        files.put(file, bytes)?;
        files.put(&index, write_index(unit))?;
        (self.file, self.index) = (Some(file.to_owned()), Some(index));
        Ok(())
    }
}
