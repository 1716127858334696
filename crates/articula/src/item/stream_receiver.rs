//! The receiver of the stream of a part, whatever its kind.

use super::part::{ItemPart, PartKind};
use super::pieces::Pieces;
use articula_core::Rig;
use articula_stream::abp2::MotionReceiver;
use articula_stream::afp2::FaceReceiver;
use articula_stream::mesh::Receiver;
use articula_stream::{ByteRanges, FaceReadOptions, StreamError, StreamLimits};
use std::ops::Range;

/// The receiver of a part's stream.
#[derive(Debug, Clone)]
pub(super) enum StreamReceiver {
    Motion(Box<MotionReceiver>),
    Face(Box<FaceReceiver>),
    Mesh(Box<Receiver>),
}

/// What bytes changed of a stream.
pub(super) enum StreamChange {
    /// Whether objects are finer.
    Mesh(bool),
    /// Frames of a motion.
    Frames(Range<usize>),
}

impl StreamReceiver {
    /// The receiver of a stream whose first bytes, with its head, are `start`; `None` of a motion without
    /// the rig that it needs.
    pub(super) fn open(
        kind: PartKind,
        rig: Option<&Rig>,
        start: &[u8],
        limits: &StreamLimits,
    ) -> Result<Option<Self>, StreamError> {
        Ok(match kind {
            PartKind::BodyMotion => {
                rig.map(|rig| Self::Motion(Box::new(MotionReceiver::new(rig, limits))))
            }
            PartKind::FaceMotion => {
                let receiver = FaceReceiver::new(&FaceReadOptions::default(), limits)?;
                Some(Self::Face(Box::new(receiver)))
            }
            PartKind::Mesh => Some(Self::Mesh(Box::new(Receiver::read(start, limits)?))),
            PartKind::Texture => None,
        })
    }

    /// Takes bytes that are new among those that are there.
    pub(super) fn receive(
        &mut self,
        pieces: &Pieces,
        new: &ByteRanges,
    ) -> Result<StreamChange, StreamError> {
        let runs = new.ranges().iter();
        let mut runs = runs.map(|range| (range.start, pieces.get(range).unwrap_or_default()));
        let mut frames = 0..0;
        match self {
            Self::Mesh(receiver) => {
                return Ok(StreamChange::Mesh(take_chunks(receiver, pieces, new)?));
            }
            Self::Motion(receiver) => runs.try_for_each(|(start, bytes)| {
                frames = joined(&frames, receiver.receive_at(start, bytes)?);
                Ok::<_, StreamError>(())
            })?,
            Self::Face(receiver) => runs.try_for_each(|(start, bytes)| {
                frames = joined(&frames, receiver.receive_at(start, bytes)?);
                Ok::<_, StreamError>(())
            })?,
        }
        Ok(StreamChange::Frames(frames))
    }
}

impl ItemPart {
    /// The first bytes of the stream of this part, once those are there with which it can be opened: its
    /// head, or all of it where the manifest does not tell where that ends.
    pub(super) fn opening<'a>(&self, pieces: &'a Pieces) -> Option<&'a [u8]> {
        match self.base_ranges.first() {
            Some([start, count]) => {
                pieces.get(&(*start..start + count))?;
                Some(pieces.start())
            }
            None => pieces.whole(),
        }
    }
}

/// Passes the chunks that new bytes complete to a mesh; returns whether an object is finer now.
fn take_chunks(
    receiver: &mut Receiver,
    pieces: &Pieces,
    new: &ByteRanges,
) -> Result<bool, StreamError> {
    let stream = receiver.stream();
    let (levels, objects) = (stream.levels.levels.len(), stream.objects.len());
    let places = (0..levels).flat_map(|level| (0..objects).map(move |o| (level, o)));
    let chunks = places.filter_map(|(level, object)| stream.chunk(level, object));
    let mut ready = Vec::new();
    for chunk in chunks.map(|chunk| chunk.start as u64..chunk.end as u64) {
        let touches = |range: &Range<u64>| range.start < chunk.end && chunk.start < range.end;
        if new.ranges().iter().any(touches)
            && let Some(bytes) = pieces.get(&chunk)
        {
            ready.push((chunk.start, bytes));
        }
    }
    let mut is_finer = false;
    for (start, bytes) in ready {
        is_finer |= !receiver.receive_at(start, bytes)?.is_empty();
    }
    Ok(is_finer)
}

/// The least range that has two.
fn joined(a: &Range<usize>, b: Range<usize>) -> Range<usize> {
    match (a.is_empty(), b.is_empty()) {
        (true, _) => b,
        (_, true) => a.clone(),
        _ => a.start.min(b.start)..a.end.max(b.end),
    }
}
