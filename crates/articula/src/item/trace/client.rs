//! The client: receivers of all streams, and the pieces that they took.

use super::content::Content;
use super::stage::Stage;
use crate::clip_streams::{StreamKind, afp2};
use crate::error::{Context, Error, Result};
use crate::item::delivery::PieceOf;
use crate::item::part::{ItemPart, PartKind};
use articula_core::Clip;
use articula_stream::abp2::MotionReceiver;
use articula_stream::afp2::FaceReceiver;
use articula_stream::mesh::Receiver;
use articula_stream::{FaceReadOptions, StreamLimits};
use std::collections::BTreeMap;
use std::ops::Range;

/// A motion as received so far.
#[derive(Debug, Clone)]
enum Motion {
    Body(Box<MotionReceiver>),
    Face(Box<FaceReceiver>),
}

/// What a client has of an item.
pub(super) struct Client<'a> {
    content: &'a Content,
    stage: &'a Stage,
    /// For each piece whether it is there.
    pub(super) has: Vec<bool>,
    /// Bytes of all pieces that came.
    pub(super) bytes: u64,
    meshes: BTreeMap<usize, Receiver>,
    motions: BTreeMap<usize, Motion>,
    /// Decoded motions of the moment.
    clips: BTreeMap<usize, Clip>,
}

impl<'a> Client<'a> {
    pub(super) fn new(content: &'a Content, stage: &'a Stage) -> Self {
        Self {
            content,
            stage,
            has: vec![false; content.delivery.catalogue.pieces.len()],
            bytes: 0,
            meshes: BTreeMap::new(),
            motions: BTreeMap::new(),
            clips: BTreeMap::new(),
        }
    }

    /// Takes a piece that came.
    pub(super) fn take(&mut self, piece: usize) -> Result<()> {
        let content = self.content;
        let of = &content.delivery.catalogue.pieces[piece];
        if let PieceOf::Part { part, .. } = of.of {
            let of_part = &content.item.manifest.parts[part];
            let name = || of_part.file.clone().unwrap_or_default();
            for range in &of.ranges {
                self.take_range(part, of_part, range).with_context(name)?;
            }
        }
        self.has[piece] = true;
        self.bytes += of.bytes;
        Ok(())
    }

    fn take_range(&mut self, part: usize, of: &ItemPart, range: &Range<u64>) -> Result<()> {
        let limits = StreamLimits::default();
        let stream = of
            .file
            .as_deref()
            .and_then(|file| self.content.item.file(file));
        let bytes = stream.and_then(|s| s.get(range.start as usize..range.end as usize));
        let missing = || Error::unsuited("the item has no such bytes");
        let bytes = bytes.ok_or_else(missing)?;
        if of.kind == PartKind::Mesh {
            match self.meshes.get_mut(&part) {
                Some(receiver) => {
                    receiver.receive_at(range.start, bytes)?;
                }
                None => {
                    self.meshes.insert(part, Receiver::read(bytes, &limits)?);
                }
            }
            return Ok(());
        }
        self.clips.remove(&part);
        let motion = match self.motions.remove(&part) {
            Some(motion) => motion,
            None => self.new_motion(of, &limits)?,
        };
        let motion = self.motions.entry(part).or_insert(motion);
        match motion {
            Motion::Body(receiver) => receiver.receive_at(range.start, bytes)?,
            Motion::Face(receiver) => receiver.receive_at(range.start, bytes)?,
        };
        Ok(())
    }

    fn new_motion(&self, of: &ItemPart, limits: &StreamLimits) -> Result<Motion> {
        let stream = of
            .file
            .as_deref()
            .and_then(|file| self.content.item.file(file));
        match stream.and_then(StreamKind::of) {
            Some(StreamKind::Abp2) => {
                let receiver = MotionReceiver::new(self.stage.rig(), limits);
                Ok(Motion::Body(Box::new(receiver)))
            }
            Some(StreamKind::Afp2) => {
                let receiver = FaceReceiver::new(&FaceReadOptions::default(), limits)?;
                Ok(Motion::Face(Box::new(receiver)))
            }
            _ => Err(Error::unsuited(
                "a stream of this kind is cut, not fetched in parts",
            )),
        }
    }

    /// The receivers of meshes.
    pub(super) fn meshes(&self) -> impl Iterator<Item = &Receiver> {
        self.meshes.values()
    }

    /// What is shown of a motion.
    pub(super) fn clip(&mut self, part: usize) -> Result<&Clip> {
        if !self.clips.contains_key(&part) {
            let clip = match self.motions.get(&part) {
                Some(Motion::Body(receiver)) => receiver.clip()?,
                Some(Motion::Face(receiver)) => self.stage.face(&afp2::received(receiver)?)?,
                None => return Err(Error::unsuited("nothing of the motion is there")),
            };
            self.clips.insert(part, clip);
        }
        Ok(&self.clips[&part])
    }
}
