//! The client's side of a stream: chunks in, vertices that only grow at the end out.

use super::head::MeshStream;
use super::write::hash_of;
use crate::mesh_codec::{QuantisedMesh, decode_level, decode_refinement, restore};
use crate::{Limits, ReadError};
use articula_core::source::Primitive;
use articula_core::{Cluster, ClusteredTriangles, Clusters};

/// What of one object is there.
#[derive(Debug, Clone, Default)]
struct Held {
    /// The finest level that is there.
    mesh: QuantisedMesh,
    /// Of each level that is there: its points, its wedges, its faces.
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
    limits: Limits,
    held: Vec<Held>,
}

impl Receiver {
    /// Waits for the chunks of a stream.
    pub fn new(stream: MeshStream, limits: Limits) -> Self {
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
    pub fn read(bytes: &[u8], limits: &Limits) -> Result<Self, ReadError> {
        let mut receiver = Self::new(MeshStream::open(bytes, limits)?, *limits);
        for level in 0..receiver.stream.levels.levels.len() {
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
                let is_cut = chunk.is_empty() && !receiver.names(level, object, &[]);
                // What was cut out of an object ends it there.
                if receiver.levels(object) == level && !is_cut {
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

    /// Levels of an object that are there; the next chunk to ask for is that of this level of the
    /// stream.
    pub fn levels(&self, object: usize) -> usize {
        self.held.get(object).map_or(0, |h| h.levels.len())
    }

    /// Takes the next chunk of an object.
    ///
    /// # Errors
    /// [`ReadError::Malformed`] if there is no such object or no further level, the bytes are not
    /// those that the head names, or what they hold breaks the rules of the codec;
    /// [`ReadError::LimitExceeded`]. Nothing has changed then.
    pub fn refine(&mut self, object: usize, chunk: &[u8]) -> Result<(), ReadError> {
        let level = self.levels(object);
        let place = format!("chunk of level {level}, object {object}");
        let bad = |what: &str| ReadError::malformed(place.clone(), what);
        if object >= self.held.len() || level >= self.stream.levels.levels.len() {
            return Err(bad("there is no such chunk"));
        }
        if !self.names(level, object, chunk) {
            return Err(bad(
                "the bytes are not those that the head names; fetch the chunk again",
            ));
        }
        let held = &mut self.held[object];
        let layout = &self.stream.objects[object].layout;
        let mesh = if level == 0 {
            decode_level(chunk, layout, &self.limits)?
        } else {
            decode_refinement(&held.mesh, chunk, layout, &self.limits)?
        };
        held.levels
            .push((mesh.points(), mesh.wedges(), mesh.faces.clone()));
        held.mesh = mesh;
        Ok(())
    }

    /// Whether the head names just these bytes for a chunk.
    fn names(&self, level: usize, object: usize, chunk: &[u8]) -> bool {
        let number = self.stream.first_level + level;
        let record = &self.stream.records[object];
        let entry = &self.stream.entries[level * self.stream.objects.len() + object];
        hash_of(number, level == 0, record, chunk) == entry.1
    }

    /// Frees what levels above the first `levels` of an object take. Drawing a coarser level needs
    /// no call: its ranges are in [`Self::triangles`].
    pub fn coarsen(&mut self, object: usize, levels: usize) {
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

    /// An object at the finest level that is there, in whole numbers.
    pub fn mesh(&self, object: usize) -> Option<&QuantisedMesh> {
        self.held.get(object).map(|h| &h.mesh)
    }

    /// An object at the finest level that is there.
    pub fn primitive(&self, object: usize) -> Option<Primitive> {
        let held = self.held.get(object)?;
        let object = &self.stream.objects[object];
        Some(restore(&held.mesh, &object.layout, &object.scale))
    }

    /// The triangles of all levels of an object that are there, over the vertices of
    /// [`Self::primitive`]: for the frame, that only switches ranges. `None` if none is there.
    pub fn triangles(&self, object: usize) -> Option<ClusteredTriangles> {
        let held = self.held.get(object)?;
        let vertices = held.levels.iter().map(|l| l.1 as u32).collect();
        let mut triangles = Vec::new();
        let mut clusters = Vec::new();
        for (level, (_, _, faces)) in held.levels.iter().enumerate() {
            let start = triangles.len() as u32;
            triangles.extend_from_slice(faces);
            let level = level as u16;
            clusters.push(Cluster {
                first_level: level,
                last_level: level,
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
