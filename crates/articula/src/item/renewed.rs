//! From one state of an item to another one, such as the next stage of its packaging: what a client has
//! stays of use.

use super::part::{ItemLayer, ItemPart};
use super::pieces::Pieces;
use super::receiver::ItemReceiver;
use super::stream_receiver::StreamReceiver;
use crate::error::Result;

impl ItemReceiver {
    /// Returns a receiver of another state of the item, such as the [next stage](super::package_in_stages())
    /// of its packaging, that holds what this one holds of it: files with the same hash, with what is decoded
    /// of them, and of a stream that has grown the layers that both have. Of such a stream only the base is
    /// fetched anew.
    ///
    /// Bytes of files that the other state does not have stay too, for a state after it that has them: a server
    /// that is stopped while it packages begins with the first stage again. [`Self::settle`] gives them up.
    ///
    /// # Errors
    /// As [`Self::new`]. What does not fit is left out.
    pub fn renewed(&self, manifest: &[u8]) -> Result<Self> {
        let mut made = Self::new(manifest, &self.options)?;
        let figure = &made.manifest.figure.file;
        let keeps_figure = self.same(&made, figure) == Some(&self.manifest.figure.file);
        let names = made.manifest.files.keys();
        for name in names.filter(|name| keeps_figure || *name != figure) {
            let known = self.same(&made, name).and_then(|name| self.files.get(name));
            if let Some(known) = known {
                made.files.insert(name.clone(), known.clone());
            }
        }
        if keeps_figure {
            made.rig.clone_from(&self.rig);
        }
        for (p, part) in made.manifest.parts.clone().iter().enumerate() {
            match self.stream_of(&made, part) {
                Some(StreamReceiver::Motion(_)) if !keeps_figure => {
                    made.show_what_is_there(p, part)
                }
                Some(stream) => {
                    made.streams.insert(p, stream.clone());
                }
                None => {
                    made.show_what_is_there(p, part);
                    self.move_layers(part, &mut made);
                }
            }
        }
        made.keep_earlier(self);
        Ok(made)
    }

    /// Takes what an earlier receiver holds, by its hash, of files that it or its state does not have.
    fn keep_earlier(&mut self, before: &Self) {
        self.earlier.clone_from(&before.earlier);
        for (name, entry) in &before.manifest.files {
            if let Some(pieces) = before.files.get(name) {
                self.earlier.insert(entry.hash.clone(), pieces.clone());
            }
        }
        for (name, entry) in self.manifest.files.clone() {
            let known = self.earlier.get(&entry.hash).cloned();
            for (offset, bytes) in known.iter().flat_map(Pieces::all) {
                // A fault is found again when the bytes are fetched.
                let _ = self.receive(&name, offset, bytes);
            }
        }
        let files = &self.manifest.files;
        self.earlier.retain(|hash, pieces| {
            pieces.there().bytes() > 0 && files.values().all(|entry| entry.hash != *hash)
        });
    }

    /// Gives up what it holds of earlier states of the item: once the item is whole, none of them comes again.
    pub fn settle(&mut self) {
        self.earlier.clear();
    }

    /// The file here that has the same bytes as one of another state of the item.
    fn same(&self, other: &Self, file: &str) -> Option<&String> {
        let entry = other.manifest.files.get(file)?;
        let files = &self.manifest.files;
        let named = files.get_key_value(file).filter(|(_, e)| *e == entry);
        let any = || files.iter().find(|(_, e)| *e == entry);
        named.or_else(any).map(|(name, _)| name)
    }

    /// What is decoded here of the stream of a part of another state, if its file is the same.
    fn stream_of(&self, other: &Self, part: &ItemPart) -> Option<&StreamReceiver> {
        let known = self.same(other, part.file.as_deref()?)?;
        let is_it = |of: &ItemPart| of.kind == part.kind && of.file.as_ref() == Some(known);
        let of_part = self.manifest.parts.iter().position(is_it)?;
        self.streams.get(&of_part)
    }

    /// Shows what is held of the stream of a part. A fault is found again when the bytes are fetched.
    fn show_what_is_there(&mut self, p: usize, part: &ItemPart) {
        let Some(file) = &part.file else { return };
        let there = self.files.get(file).map(|pieces| pieces.there().clone());
        if self.show(p, &there.unwrap_or_default()).is_err() {
            self.forget(file);
        }
    }

    /// Passes the layers that are held of a stream to another state of it.
    fn move_layers(&self, part: &ItemPart, made: &mut Self) {
        let same = |p: &&ItemPart| (p.kind, &p.name) == (part.kind, &part.name);
        let (Some(file), Some(before)) = (&part.file, self.manifest.parts.iter().find(same)) else {
            return;
        };
        for layer in &part.layers {
            for (offset, bytes) in self.moved(before, layer) {
                // A fault is found again when the bytes are fetched.
                let _ = made.receive(file, offset, &bytes);
            }
        }
    }

    /// The bytes of a layer as this receiver holds them in its stream, at their places in another one.
    fn moved(&self, part: &ItemPart, layer: &ItemLayer) -> Vec<(u64, Vec<u8>)> {
        let same = |l: &&ItemLayer| l.keep == layer.keep && l.bytes == layer.bytes;
        let pieces = part.file.as_ref().and_then(|file| self.files.get(file));
        let (Some(known), Some(pieces)) = (part.layers.iter().find(same), pieces) else {
            return Vec::new();
        };
        // Both have the same bytes one after the other, in ranges that may end elsewhere.
        let mut held = Pieces::of_length(layer.bytes);
        let mut end = 0;
        for [start, count] in &known.ranges {
            if let Some(bytes) = pieces.get(&(*start..start + count)) {
                // Ranges of a layer are checked to have its number of bytes.
                let _ = held.put(end, bytes);
            }
            end += count;
        }
        end = 0;
        let mut moved = Vec::with_capacity(layer.ranges.len());
        for [start, count] in &layer.ranges {
            let bytes = held.get(&(end..end + count));
            moved.extend(bytes.map(|bytes| (*start, bytes.to_vec())));
            end += count;
        }
        moved
    }
}
