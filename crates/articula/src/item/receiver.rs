//! Client side of an item: bytes of its files as they arrive, a character that refines.

use super::adapt::{AdaptOptions, ItemCut, ItemDecision, decide};
use super::assemble::faps;
use super::check;
use super::decoded_mesh::decoded;
use super::files::Item;
use super::manifest::Manifest;
use super::part::{ItemPart, PartKind};
use super::pieces::Pieces;
use super::shown::{Shown, ShownFigure};
use super::stream_receiver::{StreamChange, StreamReceiver};
use super::wanted::ItemBytes;
use crate::clip_streams::abp2::suits;
use crate::clip_streams::{afp2, stream_limits};
use crate::error::{Context as _, Error, Result};
use crate::open::{CharacterFile, OpenOptions};
use articula_core::{Clip, Rig};
use articula_formats::mpeg4::fap::FapClip;
use articula_stream::description::Context;
use articula_stream::mesh::Receiver;
use articula_stream::{ByteRanges, StreamLimits};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::ops::Range;

/// Receives bytes of the files of an item in any order, and shows at every moment what is there.
///
/// A client gets the manifest, decides, and fetches [`Self::missing`]: what a cut needs and is not held
/// yet, file by file. Bytes are those of the whole files, so what was fetched for one cut stays of use for
/// any other, whether it has more or fewer layers. What is shown depends on what is there, not on the
/// order in which it came: of a texture the largest size that is whole, of a motion and a mesh what the
/// stream's own receiver shows.
///
/// A file that is whole is checked against its hash; streams check their units and chunks as they come.
#[derive(Debug)]
pub struct ItemReceiver {
    pub(super) manifest: Manifest,
    pub(super) options: OpenOptions,
    limits: StreamLimits,
    pub(super) files: BTreeMap<String, Pieces>,
    /// Rig of the figure, once its file is whole.
    pub(super) rig: Option<Rig>,
    /// The receivers of streams, by the part.
    pub(super) streams: BTreeMap<usize, StreamReceiver>,
    /// Bytes of files that only earlier states of the item have, by their hashes.
    pub(super) earlier: BTreeMap<String, Pieces>,
}

/// What bytes changed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ItemChange {
    /// Nothing that is shown.
    Nothing,
    /// The figure is there: everything is shown anew.
    Figure,
    /// Objects of the mesh stream of the part of this index are finer.
    Mesh {
        /// Index of the part.
        part: usize,
    },
    /// Frames of the motion of a part.
    Motion {
        /// Index of the part.
        part: usize,
        /// The frames.
        frames: Range<usize>,
    },
    /// A size of a texture is whole.
    Texture {
        /// Index of the part.
        part: usize,
    },
    /// A form in 2D or a file that is carried is whole.
    File,
}

impl ItemReceiver {
    /// Creates a receiver of the item of a manifest.
    ///
    /// # Errors
    /// An [`Error`] that names the member of the manifest, as [`Item::open`](super::Item::open).
    pub fn new(manifest: &[u8], options: &OpenOptions) -> Result<Self> {
        let manifest = check::read(manifest, &options.limits).context(super::MANIFEST)?;
        Ok(Self::of(manifest, options))
    }

    /// A receiver of the item of a manifest that is checked.
    pub(super) fn of(manifest: Manifest, options: &OpenOptions) -> Self {
        let sizes = manifest.sizes().into_iter();
        let files = sizes.map(|(name, bytes)| (name.to_owned(), Pieces::of_length(bytes)));
        Self {
            files: files.collect(),
            limits: stream_limits(&options.limits),
            options: options.clone(),
            manifest,
            rig: None,
            streams: BTreeMap::new(),
            earlier: BTreeMap::new(),
        }
    }

    /// Returns the manifest.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// Decides what of the item to fetch in a context, by the manifest alone: as [`decide`] does.
    ///
    /// # Errors
    /// As there. Regions that the context leaves out are an error too: which bytes they are, only the unit
    /// index of a stream tells.
    pub fn decide(&self, context: &Context, options: &AdaptOptions) -> Result<ItemDecision> {
        decide(&Item::elsewhere(self.manifest.clone()), context, options)
    }

    /// Returns the bytes that are held.
    pub fn held(&self) -> ItemBytes {
        let mut held = ItemBytes::default();
        for (name, pieces) in &self.files {
            held.add(name, pieces.there().ranges().iter().cloned());
        }
        held
    }

    /// Returns the bytes that are needed for a cut and not held. A size of a texture is not needed where
    /// a larger one is held.
    ///
    /// # Errors
    /// As [`Manifest::wanted`].
    pub fn missing(&self, cut: &ItemCut) -> Result<ItemBytes> {
        let mut held = self.held();
        let textures = self.manifest.parts.iter();
        for part in textures.filter(|part| part.kind == PartKind::Texture) {
            let Some((largest, _)) = self.largest(part) else {
                continue;
            };
            // Sizes rise.
            let smaller = part
                .layers
                .iter()
                .filter_map(|l| Some((l.file.as_deref()?, l.bytes)));
            for (file, bytes) in smaller.take_while(|(file, _)| *file != largest) {
                held.add(file, std::iter::once(0..bytes));
            }
        }
        Ok(self.manifest.wanted(cut)?.without(&held))
    }

    /// Takes bytes of a file from byte `offset` on, in any order and also again, and returns what changed.
    /// Bytes of a stream begin where a range of [`Self::missing`] does, or where bytes that it took ended.
    ///
    /// # Errors
    /// An [`Error`] that names the file: one that the item does not have, bytes beyond its end, a whole
    /// file with another hash, a unit or chunk that was damaged, a motion of another character. Of a file at
    /// fault nothing is held then, since it cannot be told which of its bytes are.
    pub fn receive(&mut self, file: &str, offset: u64, bytes: &[u8]) -> Result<ItemChange> {
        self.take(file, offset, bytes).context(file)
    }

    fn take(&mut self, file: &str, offset: u64, bytes: &[u8]) -> Result<ItemChange> {
        let Some(pieces) = self.files.get_mut(file) else {
            return Err(Error::argument("the item has no such file"));
        };
        let new = pieces.put(offset, bytes)?;
        if new.bytes() == 0 {
            return Ok(ItemChange::Nothing);
        }
        if let (Some(whole), Some(entry)) = (pieces.whole(), self.manifest.files.get(file))
            && !entry.is_of(whole)
        {
            self.forget(file);
            let what = "its hash is not that of the manifest; fetch it again";
            return Err(Error::unsuited(what));
        }
        if file == self.manifest.figure.file {
            return self.take_figure();
        }
        let of_stream = |part: &ItemPart| part.file.as_deref() == Some(file);
        if let Some(part) = self.manifest.parts.iter().position(of_stream) {
            return self.show(part, &new).inspect_err(|_| self.forget(file));
        }
        if self.file(file).is_none() {
            return Ok(ItemChange::Nothing);
        }
        let is_size = |part: &ItemPart| part.layers.iter().any(|l| l.file.as_deref() == Some(file));
        let texture = self.manifest.parts.iter().position(is_size);
        Ok(texture.map_or(ItemChange::File, |part| ItemChange::Texture { part }))
    }

    /// Gives up all bytes of a file.
    pub(super) fn forget(&mut self, file: &str) {
        if let Some(pieces) = self.files.get_mut(file) {
            pieces.clear();
        }
        let parts = &self.manifest.parts;
        self.streams
            .retain(|part, _| parts[*part].file.as_deref() != Some(file));
    }

    /// Reads the figure if it is whole, and shows the motions that waited for it, also if one of them is at
    /// fault.
    fn take_figure(&mut self) -> Result<ItemChange> {
        let Some(glb) = self.file(&self.manifest.figure.file) else {
            return Ok(ItemChange::Nothing);
        };
        let figure = ShownFigure::read(glb, &self.manifest, &self.options)?;
        self.rig = Some(figure.rig);
        let mut taken = Ok(ItemChange::Figure);
        for part in 0..self.manifest.parts.len() {
            let Some(file) = self.manifest.parts[part].file.clone() else {
                continue;
            };
            if self.manifest.parts[part].kind != PartKind::BodyMotion {
                continue;
            }
            let waited = self.files.get(&file).map(|pieces| pieces.there().clone());
            if let Err(error) = self.show(part, &waited.unwrap_or_default()) {
                self.forget(&file);
                taken = taken.and(Err(error).context(file));
            }
        }
        taken
    }

    /// Passes bytes of the stream of a part that came to its receiver, if it has what that needs.
    pub(super) fn show(&mut self, part: usize, new: &ByteRanges) -> Result<ItemChange> {
        let of_part = &self.manifest.parts[part];
        let Some(pieces) = of_part.file.as_ref().and_then(|file| self.files.get(file)) else {
            return Ok(ItemChange::Nothing);
        };
        if of_part.kind == PartKind::FaceMotion && of_part.comes_whole() {
            return Ok(match pieces.whole() {
                Some(_) => ItemChange::Motion {
                    part,
                    frames: 0..usize::MAX,
                },
                None => ItemChange::Nothing,
            });
        }
        let is_new = !self.streams.contains_key(&part);
        let known = match self.streams.entry(part) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(place) => {
                let Some(start) = of_part.opening(pieces) else {
                    return Ok(ItemChange::Nothing);
                };
                let rig = self.rig.as_ref();
                match StreamReceiver::open(of_part.kind, rig, start, &self.limits)? {
                    Some(made) => place.insert(made),
                    None => return Ok(ItemChange::Nothing),
                }
            }
        };
        // When a stream is opened, all that waited is new.
        let new = if is_new { pieces.there() } else { new };
        let changed = known.receive(pieces, new)?;
        if let (Some(rig), StreamReceiver::Motion(receiver)) = (&self.rig, known)
            && receiver.head().is_some_and(|head| !suits(head, rig))
        {
            let what =
                "the stream was made for another character: joint names or rest poses differ";
            return Err(Error::unsuited(what));
        }
        Ok(match changed {
            StreamChange::Mesh(is_finer) if is_finer || is_new => ItemChange::Mesh { part },
            StreamChange::Frames(frames) if !frames.is_empty() => {
                ItemChange::Motion { part, frames }
            }
            StreamChange::Mesh(_) | StreamChange::Frames(_) => ItemChange::Nothing,
        })
    }

    /// Returns a file that is whole.
    pub fn file(&self, name: &str) -> Option<&[u8]> {
        self.files.get(name)?.whole()
    }

    /// Returns the bytes of a file that are held, by the first byte of each run: what
    /// [`Self::receive`] takes to go on later.
    pub fn pieces(&self, file: &str) -> impl Iterator<Item = (u64, &[u8])> {
        self.files.get(file).into_iter().flat_map(Pieces::all)
    }

    /// The meshes as received so far.
    pub(super) fn meshes(&self) -> impl Iterator<Item = &Receiver> {
        self.streams.values().filter_map(|stream| match stream {
            StreamReceiver::Mesh(receiver) => Some(&**receiver),
            StreamReceiver::Motion(_) | StreamReceiver::Face(_) => None,
        })
    }

    /// Returns the motion of the body of a part as received so far; `None` before the figure and the head
    /// of the stream are there, and for other parts.
    pub fn clip(&self, part: usize) -> Option<Clip> {
        match self.streams.get(&part)? {
            StreamReceiver::Motion(receiver) => receiver.clip().ok(),
            StreamReceiver::Face(_) | StreamReceiver::Mesh(_) => None,
        }
    }

    /// Returns the motion of the face of a part as received so far; `None` before the head of the stream
    /// is there, and for other parts.
    pub fn face(&self, part: usize) -> Option<FapClip> {
        let of_part = self.manifest.parts.get(part)?;
        if of_part.kind == PartKind::FaceMotion && of_part.comes_whole() {
            return faps(self.file(of_part.file.as_deref()?)?, &self.limits).ok();
        }
        match self.streams.get(&part)? {
            StreamReceiver::Face(receiver) => afp2::received(receiver).ok(),
            StreamReceiver::Motion(_) | StreamReceiver::Mesh(_) => None,
        }
    }

    /// Returns the character as received so far: what [`assemble`](super::assemble()) makes of an item with
    /// the same bytes, without the motions of which there are none.
    ///
    /// # Errors
    /// An [`Error`] that names the file: before the figure is there, and as `assemble`.
    pub fn character(&self) -> Result<CharacterFile> {
        let file = &self.manifest.figure.file;
        let missing = || Error::unsuited("the figure has not arrived");
        let glb = self.file(file).ok_or_else(missing).context(file)?;
        let figure = ShownFigure::read(glb, &self.manifest, &self.options)?;
        let mut shown = Shown::default();
        for (p, part) in self.manifest.parts.iter().enumerate() {
            if let Some(StreamReceiver::Mesh(receiver)) = self.streams.get(&p) {
                let made = decoded(receiver, &figure.character.meshes, &self.limits);
                let made = made.context(part.file.as_deref().unwrap_or_default())?;
                shown.primitives.extend(made.primitives);
            }
            if let (Some(image), Some((file, _))) = (part.image, self.largest(part)) {
                let picture = self.file(file).unwrap_or_default();
                shown.pictures.push((image, picture));
            }
            shown.clips.extend(self.clip(p));
            if let (Some(face), Some(file)) = (self.face(p), &part.file) {
                shown.faces.push((file, face));
            }
        }
        figure.with(&shown, &self.options)
    }

    /// The largest size of a texture that is whole.
    fn largest<'a>(&self, part: &'a ItemPart) -> Option<(&'a str, u64)> {
        part.largest(|layer| {
            let file = part.layers[layer].file.as_deref();
            file.is_some_and(|file| self.file(file).is_some())
        })
    }
}
