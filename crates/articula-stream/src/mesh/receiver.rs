//! Client side of a stream: decodes chunks into meshes whose vertex lists only grow at the end.

use super::codec::{QuantisedMesh, decode_level};
use super::head::MeshStream;
use crate::{StreamError, StreamLimits};
use articula_core::{Cluster, ClusteredTriangles, Clusters, Mismatch};

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
/// An object is refined level by level with [`Self::refine`]. Drawing a coarser level needs no
/// data; [`Self::coarsen`] frees memory. A chunk that does not match the head changes nothing.
///
/// The vertices of a level are a prefix of those of every finer level and keep their indices.
/// Triangles are coded anew for every level.
#[derive(Debug, Clone)]
pub struct Receiver {
    stream: MeshStream,
    limits: StreamLimits,
    held: Vec<Held>,
}

impl Receiver {
    /// Creates a receiver without chunks.
    fn new(stream: MeshStream, limits: StreamLimits) -> Self {
        let held = vec![Held::default(); stream.objects.len()];
        Self {
            stream,
            limits,
            held,
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

    /// Decodes the next chunk of an object, for the level [`Self::next_level`].
    ///
    /// # Errors
    /// [`StreamError::Mismatch`] if there is no such object or no further level,
    /// [`StreamError::Malformed`] if the bytes do not match the hash in the head or are not valid
    /// code, [`StreamError::LimitExceeded`]. On an error the receiver is unchanged.
    pub fn refine(&mut self, object: usize, chunk: &[u8]) -> Result<(), StreamError> {
        let Some(level) = self.next_level(object) else {
            let what = "all chunks of the object are already received";
            return Err(Mismatch::new(format!("object {object}"), what).into());
        };
        let number = self.stream.finest_level + level;
        if !self.stream.names(level, object, chunk) {
            let place = format!("chunk of level {number}, object {object}");
            let what = "the bytes do not match the hash in the head; fetch the chunk again";
            return Err(StreamError::malformed(place, what));
        }
        let held = &mut self.held[object];
        let layout = &self.stream.objects[object].layout;
        let mesh = if held.levels.is_empty() {
            decode_level(None, chunk, layout, &self.limits)?
        } else {
            decode_level(Some(&held.mesh), chunk, layout, &self.limits)?
        };
        held.levels
            .push((mesh.points(), mesh.wedges(), mesh.faces.clone()));
        held.mesh = mesh;
        Ok(())
    }

    /// Frees the data of an object finer than level `finest` of the stream; a level beyond the
    /// coarsest frees the whole object. Drawing a coarser level needs no call: its ranges are in
    /// [`Self::triangles`].
    pub fn coarsen(&mut self, object: usize, finest: usize) {
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
