//! Which bytes of which files of an item a cut needs, by its manifest alone.

use super::adapt::ItemCut;
use super::manifest::Manifest;
use super::part::{ItemPart, PartKind};
use crate::error::{Error, Result};
use articula_stream::{ByteRanges, difference};
use std::collections::BTreeMap;
use std::ops::Range;

/// Bytes of files of an item, by the names of the files.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ItemBytes(BTreeMap<String, ByteRanges>);

impl ItemBytes {
    /// Returns the ranges of each file of which there are some.
    pub fn files(&self) -> impl Iterator<Item = (&str, &ByteRanges)> {
        let files = self.0.iter().map(|(name, ranges)| (name.as_str(), ranges));
        files.filter(|(_, ranges)| ranges.bytes() > 0)
    }

    /// Returns the ranges of a file.
    pub fn of(&self, file: &str) -> ByteRanges {
        self.0.get(file).cloned().unwrap_or_default()
    }

    /// Whether all bytes of a range of a file are among these.
    pub(crate) fn has(&self, file: &str, range: &Range<u64>) -> bool {
        let ranges = self.0.get(file).into_iter();
        let mut ranges = ranges.flat_map(|ranges| ranges.ranges());
        range.is_empty() || ranges.any(|r| r.start <= range.start && range.end <= r.end)
    }

    /// Returns the number of bytes.
    pub fn bytes(&self) -> u64 {
        self.0.values().map(ByteRanges::bytes).sum()
    }

    /// Returns the bytes that are among these and not among others: what a client that has the others
    /// must fetch.
    #[must_use]
    pub fn without(&self, others: &Self) -> Self {
        let files = self.0.iter();
        let files = files.map(|(name, want)| (name.clone(), difference(&others.of(name), want)));
        Self(files.filter(|(_, ranges)| ranges.bytes() > 0).collect())
    }

    /// Adds bytes of a file.
    pub(crate) fn add(&mut self, file: &str, more: impl IntoIterator<Item = Range<u64>>) {
        let more: ByteRanges = more.into_iter().collect();
        let known = self.0.entry(file.to_owned()).or_default();
        *known = known.union(&more);
    }

    /// Adds all bytes of a file.
    fn add_whole(&mut self, file: &str, bytes: u64) {
        self.add(file, std::iter::once(0..bytes));
    }
}

impl Manifest {
    /// Returns the bytes of all files that a cut needs: the figure, what all layers of a stream have in
    /// common and its kept layers, the largest kept size of each texture, and the files that are carried
    /// whole; of a form in 2D that form and these files.
    ///
    /// A motion of which no layer is kept is not needed, and may come later; of the first motion of the body
    /// what all layers have in common is needed always. Regions
    /// that the cut leaves out are among the bytes of the layers, which the manifest does not tell apart.
    ///
    /// # Errors
    /// [`Error::Argument`] if the cut is of another item.
    pub fn wanted(&self, cut: &ItemCut) -> Result<ItemBytes> {
        let other = || Error::argument("the cut is of another item");
        let mut wanted = ItemBytes::default();
        for file in &self.whole {
            wanted.add_whole(&file.file, file.bytes);
        }
        match cut {
            ItemCut::Flat(form) => {
                let form = self.flat.get(*form).ok_or_else(other)?;
                wanted.add_whole(&form.file, form.bytes);
            }
            ItemCut::Layers { kept, .. } => {
                wanted.add_whole(&self.figure.file, self.figure.bytes);
                let are_all =
                    |(part, kept): (&ItemPart, &Vec<bool>)| part.layers.len() == kept.len();
                if kept.len() != self.parts.len() || !self.parts.iter().zip(kept).all(are_all) {
                    return Err(other());
                }
                for (part, kept) in kept.iter().enumerate() {
                    if self.has_part(part, kept) {
                        self.parts[part].add_wanted(kept, &mut wanted);
                    }
                }
            }
        }
        Ok(wanted)
    }

    /// Returns the names of the motions that a cut does not have.
    pub fn absent(&self, cut: &ItemCut) -> Vec<String> {
        let ItemCut::Layers { kept, .. } = cut else {
            return Vec::new();
        };
        let parts = self.parts.iter().zip(kept).enumerate();
        let absent = parts.filter(|(index, (_, kept))| !self.has_part(*index, kept));
        absent.map(|(_, (part, _))| part.name.clone()).collect()
    }
}

impl ItemPart {
    fn add_wanted(&self, kept: &[bool], wanted: &mut ItemBytes) {
        if self.kind == PartKind::Texture {
            if let Some((file, bytes)) = self.largest(|layer| kept[layer]) {
                wanted.add_whole(file, bytes);
            }
            return;
        }
        let Some(file) = &self.file else { return };
        if self.comes_whole() {
            return wanted.add_whole(file, self.bytes);
        }
        let layers = self.layers.iter().zip(kept).filter(|(_, kept)| **kept);
        let layers = layers.flat_map(|(layer, _)| &layer.ranges);
        let ranges = self.base_ranges.iter().chain(layers);
        wanted.add(file, ranges.map(|[start, count]| *start..start + count));
    }

    /// Whether the stream can only be fetched as a whole: layers share bytes where units are bits.
    pub(super) fn comes_whole(&self) -> bool {
        self.base_ranges.is_empty()
    }

    /// The largest of some sizes of a texture: its file and bytes.
    pub(super) fn largest(&self, has: impl Fn(usize) -> bool) -> Option<(&str, u64)> {
        let sizes = (0..self.layers.len()).filter(|layer| has(*layer));
        let sizes = sizes.map(|layer| &self.layers[layer]);
        let pixels = sizes.filter_map(|l| Some((l.size_px?, l.file.as_deref()?, l.bytes)));
        let largest = pixels.max_by_key(|([w, h], ..)| u64::from(*w) * u64::from(*h));
        largest.map(|(_, file, bytes)| (file, bytes))
    }
}
