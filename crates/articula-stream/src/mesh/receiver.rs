//! Client side of a stream: decodes chunks into meshes whose vertex lists only grow at the end.

use super::codec::{QuantisedMesh, decode_level};
use super::head::MeshStream;
use crate::{StreamError, StreamLimits};
use articula_core::{Cluster, ClusteredTriangles, Clusters, Mismatch};
use std::collections::BTreeMap;
use std::ops::Range;

/// Received data of one object.
#[derive(Debug, Clone, Default)]
struct Held {
    /// Mesh of the finest received level.
    mesh: QuantisedMesh,
    /// Number of points, number of wedges and faces of each received level, coarsest first.
    levels: Vec<(usize, usize, Vec<[u32; 3]>)>,
}

/// Receives, checks and decodes the chunks of a stream, and assembles the objects.
///
/// An object is refined level by level with [`Self::refine`], or by [`Self::receive_at`] with chunks in
/// any order. Drawing a coarser level needs no
/// data; [`Self::coarsen`] frees memory. A chunk that does not match the head changes nothing.
///
/// The vertices of a level are a prefix of those of every finer level and keep their indices.
/// Triangles are coded anew for every level.
#[derive(Debug, Clone)]
pub struct Receiver {
    stream: MeshStream,
    limits: StreamLimits,
    held: Vec<Held>,
    /// Chunks that wait for a coarser one, by object and level.
    waiting: BTreeMap<(usize, usize), Vec<u8>>,
}

impl Receiver {
    /// Creates a receiver without chunks.
    fn new(stream: MeshStream, limits: StreamLimits) -> Self {
        let held = vec![Held::default(); stream.objects.len()];
        Self {
            stream,
            limits,
            held,
            waiting: BTreeMap::new(),
        }
    }

    /// Reads a whole stream or a prefix of it: all levels that are complete. An object with a
    /// removed chunk gets the levels before it.
    ///
    /// # Errors
    /// As [`MeshStream::open`] and [`Self::refine`]; a stream that ends early is not an error.
    pub fn read(bytes: &[u8], limits: &StreamLimits) -> Result<Self, StreamError> {
        let mut receiver = Self::new(MeshStream::open(bytes, limits)?, *limits);
        for level in (0..receiver.stream.levels.levels.len()).rev() {
            let objects = 0..receiver.stream.objects.len();
            let ends = objects
                .clone()
                .filter_map(|o| receiver.stream.chunk(level, o));
            if ends
                .map(|r| r.end)
                .max()
                .is_some_and(|end| end > bytes.len())
            {
                break;
            }
            for object in objects {
                let chunk = receiver.stream.chunk(level, object).unwrap_or_default();
                let is_cut = chunk.is_empty() && !receiver.stream.names(level, object, &[]);
                // A removed chunk ends the refinement of its object.
                if receiver.next_level(object) == Some(level) && !is_cut {
                    receiver.refine(object, &bytes[chunk])?;
                }
            }
        }
        Ok(receiver)
    }

    /// Returns the head of the stream.
    pub fn stream(&self) -> &MeshStream {
        &self.stream
    }

    /// Returns the level of the stream, 0 its finest, of the next chunk that an object needs;
    /// `None` if the object is complete or does not exist.
    pub fn next_level(&self, object: usize) -> Option<usize> {
        let there = self.held.get(object)?.levels.len();
        self.stream.levels.levels.len().checked_sub(1 + there)
    }

    /// Returns the finest received level of an object, as a level of the stream; `None` if there is
    /// none.
    pub fn finest_level(&self, object: usize) -> Option<usize> {
        let there = self.held.get(object)?.levels.len();
        (there > 0).then(|| self.stream.levels.levels.len() - there)
    }

    /// Decodes the next chunk of an object, for the level [`Self::next_level`], and those that waited for
    /// it.
    ///
    /// # Errors
    /// [`StreamError::Mismatch`] if there is no such object or no further level,
    /// [`StreamError::Malformed`] if the bytes do not match the hash in the head or are not valid
    /// code, [`StreamError::LimitExceeded`]. On an error the receiver is unchanged, unless the fault is in
    /// a chunk that waited, which is dropped.
    pub fn refine(&mut self, object: usize, chunk: &[u8]) -> Result<(), StreamError> {
        let Some(level) = self.next_level(object) else {
            let what = "all chunks of the object are already received";
            return Err(Mismatch::new(format!("object {object}"), what).into());
        };
        self.check(level, object, chunk)?;
        self.decode(object, chunk)?;
        self.waiting.remove(&(object, level));
        self.go_on(object)
    }

    /// Takes whole chunks of the stream from byte `offset` on, in any order and also again, and returns
    /// the objects that were refined, rising. A chunk waits until the next coarser level of its object is
    /// there: the result does not depend on the order.
    ///
    /// # Errors
    /// [`StreamError::Mismatch`] if the bytes are not whole chunks, [`StreamError::Malformed`] if they do
    /// not match the hash in the head, with which the receiver is unchanged. A chunk that is not valid
    /// code, or exceeds the limits, is an error once it is decoded; it is dropped, others are taken.
    pub fn receive_at(&mut self, offset: u64, bytes: &[u8]) -> Result<Vec<usize>, StreamError> {
        let mut chunks = self.chunks(offset, bytes)?;
        for (level, object, chunk) in &chunks {
            self.check(*level, *object, &bytes[chunk.clone()])?;
        }
        chunks.retain(|(level, object, _)| {
            let next = self.next_level(*object);
            next.is_some_and(|next| *level <= next)
        });
        let mut refined = Vec::new();
        for (level, object, chunk) in chunks {
            self.waiting.insert((object, level), bytes[chunk].to_vec());
            refined.push(object);
        }
        refined.sort_unstable();
        refined.dedup();
        let mut done = Ok(());
        refined.retain(|object| {
            let before = self.next_level(*object);
            let went_on = self.go_on(*object);
            if done.is_ok() {
                done = went_on;
            }
            self.next_level(*object) != before
        });
        done.map(|()| refined)
    }

    /// The chunks that bytes from `offset` on hold: level, object, place in the bytes.
    fn chunks(
        &self,
        offset: u64,
        bytes: &[u8],
    ) -> Result<Vec<(usize, usize, Range<usize>)>, StreamError> {
        let end = offset.saturating_add(bytes.len() as u64);
        let mut found = Vec::new();
        let mut at = offset;
        for (level, object, chunk) in self.stream.chunks() {
            if chunk.start == at && !chunk.is_empty() && chunk.end <= end {
                let within = |byte: u64| (byte - offset) as usize;
                found.push((level, object, within(chunk.start)..within(chunk.end)));
                at = chunk.end;
            }
        }
        if at < end {
            let what = format!("bytes {at} to {end} of the stream are not whole chunks");
            return Err(Mismatch::new("chunks", what).into());
        }
        Ok(found)
    }

    /// Decodes what waits for the levels that an object has. A chunk at fault is dropped.
    fn go_on(&mut self, object: usize) -> Result<(), StreamError> {
        while let Some(level) = self.next_level(object)
            && let Some(chunk) = self.waiting.remove(&(object, level))
        {
            self.decode(object, &chunk)?;
        }
        Ok(())
    }

    /// Checks the hash of a chunk.
    fn check(&self, level: usize, object: usize, chunk: &[u8]) -> Result<(), StreamError> {
        if self.stream.names(level, object, chunk) {
            return Ok(());
        }
        let number = self.stream.finest_level + level;
        let place = format!("chunk of level {number}, object {object}");
        let what = "the bytes do not match the hash in the head; fetch the chunk again";
        Err(StreamError::malformed(place, what))
    }

    /// Decodes the next chunk of an object.
    fn decode(&mut self, object: usize, chunk: &[u8]) -> Result<(), StreamError> {
        let held = &mut self.held[object];
        let layout = &self.stream.objects[object].layout;
        let coarser = (!held.levels.is_empty()).then_some(&held.mesh);
        let mesh = decode_level(coarser, chunk, layout, &self.limits)?;
        held.levels
            .push((mesh.points(), mesh.wedges(), mesh.faces.clone()));
        held.mesh = mesh;
        Ok(())
    }

    /// Frees the data of an object finer than level `finest` of the stream; a level beyond the
    /// coarsest frees the whole object. Drawing a coarser level needs no call: its ranges are in
    /// [`Self::triangles`].
    pub fn coarsen(&mut self, object: usize, finest: usize) {
        self.waiting
            .retain(|(of, level), _| *of != object || *level >= finest);
        let levels = self.stream.levels.levels.len().saturating_sub(finest);
        let Some(held) = self.held.get_mut(object) else {
            return;
        };
        if levels >= held.levels.len() {
            return;
        }
        held.levels.truncate(levels);
        let none = (0, 0, Vec::new());
        let (points, wedges, faces) = held.levels.last().unwrap_or(&none);
        let mesh = &mut held.mesh;
        cut(&mut mesh.positions, *points);
        cut(&mut mesh.skins, *points);
        mesh.morphs.iter_mut().for_each(|m| cut(m, *points));
        cut(&mut mesh.wedge_points, *wedges);
        cut(&mut mesh.normals, *wedges);
        cut(&mut mesh.texcoords, *wedges);
        cut(&mut mesh.colors, *wedges);
        mesh.morph_normals.iter_mut().for_each(|m| cut(m, *wedges));
        mesh.faces = faces.clone();
    }

    /// Returns the finest received mesh of an object in whole numbers; [`restore`](super::restore)
    /// converts it to metres.
    pub fn mesh(&self, object: usize) -> Option<&QuantisedMesh> {
        self.held.get(object).map(|h| &h.mesh)
    }

    /// Returns the triangles of all received levels of an object, as indices of [`Self::mesh`]'s
    /// wedges; a frame only switches between ranges. Level 0 is the finest received. `None` if
    /// there is none.
    pub fn triangles(&self, object: usize) -> Option<ClusteredTriangles> {
        let held = self.held.get(object)?;
        let vertices = held.levels.iter().rev().map(|l| l.1 as u32).collect();
        let mut triangles = Vec::new();
        let mut clusters = Vec::new();
        for (level, (_, _, faces)) in held.levels.iter().enumerate() {
            let start = triangles.len() as u32;
            triangles.extend_from_slice(faces);
            let level = (held.levels.len() - 1 - level) as u16;
            clusters.push(Cluster {
                finest_level: level,
                coarsest_level: level,
                region: 0,
                triangles: start..triangles.len() as u32,
            });
        }
        let clusters = Clusters::new(vertices, clusters).ok()?;
        Some(ClusteredTriangles {
            clusters,
            triangles,
        })
    }
}

/// Truncates a list and releases the memory.
fn cut<T>(values: &mut Vec<T>, count: usize) {
    values.truncate(count);
    values.shrink_to_fit();
}
