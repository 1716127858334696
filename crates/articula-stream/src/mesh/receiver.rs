//! The client's side of a stream: chunks in, vertices that only grow at the end out.

use super::codec::{QuantisedMesh, decode_level};
use super::head::MeshStream;
use crate::{StreamError, StreamLimits};
use articula_core::{Cluster, ClusteredTriangles, Clusters, Mismatch};

/// What of one object is there.
#[derive(Debug, Clone, Default)]
struct Held {
    /// The finest level that is there.
    mesh: QuantisedMesh,
    /// Of each level that is there, the coarsest first as they came: its points, its wedges, its
    /// faces.
    levels: Vec<(usize, usize, Vec<[u32; 3]>)>,
}

/// Takes chunks of a stream, checks and decodes them, and holds what is there of each object.
///
/// An object is refined level by level with [`Self::refine`], coarsened by drawing less of it
/// (no data), and freed with [`Self::coarsen`]. A chunk that is not what the head says leaves
/// everything as it was.
///
/// Vertices of a level are the first ones of every finer level and never change their numbers.
/// Triangles are described anew by every level.
#[derive(Debug, Clone)]
pub struct Receiver {
    stream: MeshStream,
    limits: StreamLimits,
    held: Vec<Held>,
}

impl Receiver {
    /// Waits for the chunks of a stream.
    fn new(stream: MeshStream, limits: StreamLimits) -> Self {
        let held = vec![Held::default(); stream.objects.len()];
        Self {
            stream,
            limits,
            held,
        }
    }

    /// Reads a whole stream, or its start: all levels that end before the bytes do. An object of
    /// which a chunk was cut out has the levels before it.
    ///
    /// # Errors
    /// As [`MeshStream::open`] and [`Self::refine`]; a stream that ends early is no error.
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
                // What was cut out of an object ends it there.
                if receiver.next_level(object) == Some(level) && !is_cut {
                    receiver.refine(object, &bytes[chunk])?;
                }
            }
        }
        Ok(receiver)
    }

    /// The head of the stream.
    pub fn stream(&self) -> &MeshStream {
        &self.stream
    }

    /// Level of the stream, 0 its finest, whose chunk an object needs next; `None` if it has all,
    /// or there is no such object.
    pub fn next_level(&self, object: usize) -> Option<usize> {
        let there = self.held.get(object)?.levels.len();
        self.stream.levels.levels.len().checked_sub(1 + there)
    }

    /// The finest level of the stream that an object has; `None` if it has none.
    pub fn finest_level(&self, object: usize) -> Option<usize> {
        let there = self.held.get(object)?.levels.len();
        (there > 0).then(|| self.stream.levels.levels.len() - there)
    }

    /// Takes the next chunk of an object, that of [`Self::next_level`].
    ///
    /// # Errors
    /// [`StreamError::Mismatch`] if there is no such object or no further level,
    /// [`StreamError::Malformed`] if the bytes are not those that the head names, or what they
    /// hold breaks the rules of the codec; [`StreamError::LimitExceeded`]. Nothing has changed
    /// then.
    pub fn refine(&mut self, object: usize, chunk: &[u8]) -> Result<(), StreamError> {
        let Some(level) = self.next_level(object) else {
            let what = "there is no further chunk";
            return Err(Mismatch::new(format!("object {object}"), what).into());
        };
        let number = self.stream.finest_level + level;
        if !self.stream.names(level, object, chunk) {
            let place = format!("chunk of level {number}, object {object}");
            let what = "the bytes are not those that the head names; fetch the chunk again";
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

    /// Frees what an object has that is finer than a level of the stream; a level beyond the
    /// coarsest frees the object. Drawing a coarser level needs no call: its ranges are in
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

    /// An object at the finest level that is there, in whole numbers; [`restore`](super::restore)
    /// gives it in metres.
    pub fn mesh(&self, object: usize) -> Option<&QuantisedMesh> {
        self.held.get(object).map(|h| &h.mesh)
    }

    /// The triangles of all levels of an object that are there, over the vertices of
    /// [`Self::mesh`]: for the frame, that only switches ranges. Level 0 is the finest that is
    /// there. `None` if none is.
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

/// Keeps the first values and gives the room of the others back.
fn cut<T>(values: &mut Vec<T>, count: usize) {
    values.truncate(count);
    values.shrink_to_fit();
}
