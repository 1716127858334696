//! The client: a receiver of the item, and the pieces that came.

use super::content::Content;
use super::stage::Stage;
use crate::error::{Context, Error, Result};
use crate::item::delivery::PieceOf;
use crate::item::receiver::ItemReceiver;
use crate::open::OpenOptions;
use articula_core::Clip;
use articula_stream::mesh::Receiver;
use std::collections::BTreeMap;

/// What a client has of an item.
pub(super) struct Client<'a> {
    content: &'a Content,
    stage: &'a Stage,
    /// For each piece whether it is there.
    pub(super) has: Vec<bool>,
    /// Bytes of all pieces that came.
    pub(super) bytes: u64,
    receiver: ItemReceiver,
    /// Decoded motions of the moment.
    clips: BTreeMap<usize, Clip>,
}

impl<'a> Client<'a> {
    pub(super) fn new(content: &'a Content, stage: &'a Stage) -> Self {
        let manifest = content.item.manifest.clone();
        let mut receiver = ItemReceiver::of(manifest, &OpenOptions::default());
        // The figure is read once for all clients.
        receiver.rig = Some(stage.rig().clone());
        Self {
            content,
            stage,
            has: vec![false; content.delivery.catalogue.pieces.len()],
            bytes: 0,
            receiver,
            clips: BTreeMap::new(),
        }
    }

    /// Takes a piece that came.
    pub(super) fn take(&mut self, piece: usize) -> Result<()> {
        let content = self.content;
        let of = &content.delivery.catalogue.pieces[piece];
        if let PieceOf::Part { part, .. } = of.of {
            let file = content.item.manifest.parts[part].file.as_deref();
            let file = file.unwrap_or_default();
            let stream = content.item.file(file).unwrap_or_default();
            for range in &of.ranges {
                let bytes = stream.get(range.start as usize..range.end as usize);
                let missing = || Error::unsuited("the item has no such bytes");
                let bytes = bytes.ok_or_else(missing).context(file)?;
                self.receiver.receive(file, range.start, bytes)?;
                self.clips.remove(&part);
            }
        }
        self.has[piece] = true;
        self.bytes += of.bytes;
        Ok(())
    }

    /// The receivers of meshes.
    pub(super) fn meshes(&self) -> impl Iterator<Item = &Receiver> {
        self.receiver.meshes()
    }

    /// What is shown of a motion.
    pub(super) fn clip(&mut self, part: usize) -> Result<&Clip> {
        if !self.clips.contains_key(&part) {
            let nothing = || Error::unsuited("nothing of the motion is there");
            let clip = match self.receiver.face(part) {
                Some(face) => self.stage.face(&face)?,
                None => self.receiver.clip(part).ok_or_else(nothing)?,
            };
            self.clips.insert(part, clip);
        }
        Ok(&self.clips[&part])
    }
}
