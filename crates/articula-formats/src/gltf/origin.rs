//! Mapping from the parts of a mesh as read to the primitives of the document.

use super::append::index;
use super::document::Document;
use super::place::Place;
use super::primitive;
use super::primitive::sharing;
use super::reader::{Notes, Reader};
use crate::error::ReadError;
use crate::limits::Limits;
use foldhash::{HashMap, HashMapExt};
use std::hash::Hash;

/// Origin of a part of a mesh in the document.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Origin {
    /// Index among the primitives of the mesh.
    pub(super) primitive: usize,
    /// Index of each vertex in the primitive's arrays.
    pub(super) vertices: Vec<u32>,
}

/// Returns the origins of the parts that [`read`](super::read) makes of a mesh, in their order.
pub(super) fn origins(reader: &mut Reader<'_>, mesh: &Place<'_>) -> Result<Vec<Origin>, ReadError> {
    let places = mesh.entries("primitives")?;
    let mut out = Vec::new();
    for (p, (place, shares)) in places.iter().zip(sharing(&places)).enumerate() {
        let Some((count, triangles)) = primitive::outline(reader, place)? else {
            continue;
        };
        reader.charge(place, count as u64)?;
        let mut is_used = vec![!shares; count];
        for v in triangles.as_flattened() {
            is_used[*v as usize] = true;
        }
        let used = |v: &u32| is_used[*v as usize];
        out.push(Origin {
            primitive: p,
            vertices: (0..count as u32).filter(used).collect(),
        });
    }
    Ok(out)
}

/// Returns the mesh of a node.
pub(super) fn mesh_of<'a>(reader: &Reader<'a>, node: usize) -> Result<Place<'a>, ReadError> {
    let missing = || {
        ReadError::malformed(
            format!("nodes[{node}]"),
            "there is no such node with a mesh",
        )
    };
    let node = reader.root.entry("nodes", node);
    let node = node.filter(|n| n.has("mesh")).ok_or_else(missing)?;
    reader.root.entry_of("meshes", &node, "mesh")
}

impl Document {
    /// Number of meshes.
    pub fn mesh_count(&self) -> usize {
        self.count("meshes")
    }

    /// The mesh that a node shows, by its index.
    pub fn mesh_of_node(&self, node: usize) -> Option<usize> {
        index(self.json.get("nodes")?.get(node)?, "mesh")
    }

    /// Finds the vertices of a part that are equal in every byte of the document: in all
    /// attributes, including those that a character does not hold (tangents, further texture
    /// coordinates and colours, custom ones), and in all morph targets. Returns for each vertex the
    /// lowest index of an equal vertex. Parts and vertices are those of [`read`](super::read).
    ///
    /// # Errors
    /// [`ReadError`] if the node or part does not exist, or the document is malformed.
    pub fn vertex_classes(&self, node: usize, part: usize) -> Result<Vec<u32>, ReadError> {
        let limits = Limits::default();
        let mut reader = Reader::new(self, &limits, Notes::default());
        let mesh = mesh_of(&reader, node)?;
        let parts = origins(&mut reader, &mesh)?;
        let none = || {
            mesh.malformed(format!(
                "primitive {part} is out of range: there are {}",
                parts.len()
            ))
        };
        let origin = parts.get(part).ok_or_else(none)?;
        let primitive = mesh.entry("primitives", origin.primitive);
        let primitive = primitive.ok_or_else(none)?;
        classes(&reader, &primitive, &origin.vertices)
    }
}

/// Returns for each of some vertices of a primitive, given by their places in its arrays, the lowest
/// index among them of one that is equal in every byte.
pub(super) fn classes(
    reader: &Reader<'_>,
    primitive: &Place<'_>,
    vertices: &[u32],
) -> Result<Vec<u32>, ReadError> {
    let mut classes = vec![0; vertices.len()];
    for index in vertex_arrays(primitive)? {
        split_by_bytes(reader, &index, vertices, &mut classes)?;
    }
    Ok(classes)
}

/// Splits classes of vertices by the bytes of an array.
pub(super) fn split_by_bytes(
    reader: &Reader<'_>,
    index: &Place<'_>,
    vertices: &[u32],
    classes: &mut [u32],
) -> Result<(), ReadError> {
    let accessor = reader.accessor(index)?;
    let overlay = accessor.overlay()?;
    if vertices.iter().any(|raw| *raw as usize >= accessor.count) {
        return Err(index.malformed("fewer elements than vertices"));
    }
    split(classes, |v| {
        let raw = vertices[v] as usize;
        let bytes = overlay.get(&raw).copied().or_else(|| accessor.stored(raw));
        // Stored zeros equal implicit zeros.
        bytes.filter(|b| b.iter().any(|byte| *byte != 0))
    });
    Ok(())
}

/// Splits classes of vertices by a key of each: those of a class with equal keys become the class of the first of
/// them.
pub(super) fn split<K: Hash + Eq>(classes: &mut [u32], key: impl Fn(usize) -> K) {
    let mut members = vec![0u32; classes.len()];
    for class in classes.iter() {
        members[*class as usize] += 1;
    }
    let mut first = HashMap::new();
    for (v, class) in classes.iter_mut().enumerate() {
        // Most vertices are alone after the first arrays, and stay so.
        if members[*class as usize] > 1 {
            *class = *first.entry((*class, key(v))).or_insert(v as u32);
        }
    }
}

/// Returns the members of a primitive that refer to an array with one element per vertex.
pub(super) fn vertex_arrays<'a>(primitive: &Place<'a>) -> Result<Vec<Place<'a>>, ReadError> {
    let mut owners = vec![primitive.require("attributes")?];
    owners.extend(primitive.entries("targets")?);
    let arrays = owners.iter().flat_map(Place::members);
    Ok(arrays.map(|(_, index)| index).collect())
}
