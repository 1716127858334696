//! Order of triangles and vertices that caches and compression like, and equal vertices once.
//!
//! Source: the vertex cache order of meshoptimizer for strips, by the crate `meshoptimizer-rs`, whose indices need a
//! tenth fewer bytes than those of the order for caches alone; vertices then
//! stand in the order of their first use.

use super::append::{Use, entries_mut, set};
use super::arrays::{Reordered, reordered};
use super::compressed::stored_classes;
use super::document::Document;
use super::extension::VARIANTS;
use super::origin::vertex_arrays;
use super::place::Place;
use super::primitive;
use super::reader::{Notes, Reader};
use crate::error::ReadError;
use crate::limits::Limits;
use meshoptimizer_rs::{Workspace, optimize_vertex_cache_strip};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};

/// A primitive by its mesh and its index there.
type PrimitiveIndex = (usize, usize);

/// Primitives that share all their vertex arrays.
struct Shared {
    primitives: Vec<PrimitiveIndex>,
    /// Triangles of each, in their new order, of old vertices.
    triangles: Vec<Vec<u32>>,
    /// New vertex of each old one that is used.
    new_of_old: Vec<u32>,
    /// Arrays of the attributes, and of those of each morph target, by name.
    attributes: Vec<(String, Reordered)>,
    targets: Vec<Vec<(String, Reordered)>>,
}

impl Document {
    /// Puts the triangles of each primitive into an order that caches like and its vertices into the
    /// order of their first use; vertices without a triangle are dropped. Vertices are stored once that
    /// [`write_compressed`](Self::write_compressed) would make equal: normals, tangents, colours and, at a
    /// step, texture coordinates when they are rounded, all else in every byte. Only lists of triangles
    /// without extensions are changed.
    ///
    /// # Errors
    /// A [`ReadError`] if the document is malformed; it is then unchanged.
    pub fn optimise_vertex_order(&mut self, texcoords: f32) -> Result<(), ReadError> {
        let before = self.mesh_accessors();
        for shared in self.new_orders(texcoords)? {
            self.put_order(shared);
        }
        self.drop_unnamed(before);
        Ok(())
    }

    fn new_orders(&self, texcoords: f32) -> Result<Vec<Shared>, ReadError> {
        let limits = Limits::default();
        let mut reader = Reader::new(self, &limits, Notes::default());
        let mut groups: BTreeMap<String, Vec<PrimitiveIndex>> = BTreeMap::new();
        // Arrays that primitives of several groups use stay as they are.
        let mut users: BTreeMap<usize, BTreeSet<String>> = BTreeMap::new();
        for (m, mesh) in reader.root.entries("meshes")?.iter().enumerate() {
            for (p, primitive) in mesh.entries("primitives")?.iter().enumerate() {
                let key = arrays_of(primitive.value());
                for place in vertex_arrays(primitive)? {
                    let accessor = place.whole()? as usize;
                    users.entry(accessor).or_default().insert(key.clone());
                }
                groups.entry(key).or_default().push((m, p));
            }
        }
        let mut out = Vec::new();
        for (key, primitives) in groups {
            let is_own = users
                .values()
                .filter(|keys| keys.contains(&key))
                .all(|keys| keys.len() == 1);
            if is_own {
                out.extend(shared(&mut reader, primitives, texcoords)?);
            }
        }
        Ok(out)
    }

    fn put_order(&mut self, shared: Shared) {
        let mut store = |arrays: Vec<(String, Reordered)>| -> Value {
            let named = arrays
                .into_iter()
                .map(|(name, array)| (name, json!(self.add_reordered(array))));
            Value::Object(named.collect())
        };
        let attributes = store(shared.attributes);
        let targets: Vec<Value> = shared.targets.into_iter().map(&mut store).collect();
        for ((m, p), triangles) in shared.primitives.into_iter().zip(shared.triangles) {
            let corners = triangles.iter().map(|v| shared.new_of_old[*v as usize]);
            let bytes: Vec<u8> = corners.flat_map(u32::to_le_bytes).collect();
            let view = self.add_view(&bytes, Use::Indices);
            let indices = self.add_accessor(json!({
                "bufferView": view,
                "componentType": 5125,
                "count": triangles.len(),
                "type": "SCALAR",
            }));
            let mesh = &mut entries_mut(&mut self.json, "meshes")[m];
            let primitive = &mut entries_mut(mesh, "primitives")[p];
            set(primitive, "attributes", attributes.clone());
            set(primitive, "indices", indices);
            if !targets.is_empty() {
                set(primitive, "targets", targets.clone());
            }
        }
    }
}

/// The vertex arrays of a primitive, as text.
fn arrays_of(primitive: &Value) -> String {
    json!([primitive.get("attributes"), primitive.get("targets")]).to_string()
}

/// Whether a primitive is a list of triangles without an extension that may depend on their vertices.
pub(super) fn is_plain_list(primitive: &Place<'_>) -> bool {
    let extensions = primitive.get("extensions").map(|e| e.members());
    let mut extensions = extensions.unwrap_or_default().into_iter();
    extensions.all(|(name, _)| name == VARIANTS) && primitive.whole_or("mode", 4).ok() == Some(4)
}

/// The new order of primitives that share their vertex arrays; `None` if one of them is not a list of
/// triangles or has an extension that may depend on it.
fn shared(
    reader: &mut Reader<'_>,
    primitives: Vec<PrimitiveIndex>,
    texcoords: f32,
) -> Result<Option<Shared>, ReadError> {
    let mut places = Vec::with_capacity(primitives.len());
    for (m, p) in &primitives {
        let mesh = reader.root.entry("meshes", *m);
        places.extend(mesh.and_then(|mesh| mesh.entry("primitives", *p)));
    }
    if places.len() != primitives.len() || !places.iter().all(is_plain_list) {
        return Ok(None);
    }
    let mut outlines = Vec::with_capacity(places.len());
    for place in &places {
        let Some((count, triangles)) = primitive::outline(reader, place)? else {
            return Ok(None);
        };
        outlines.push((count, triangles));
    }
    let Some(count) = outlines.first().map(|(count, _)| *count) else {
        return Ok(None);
    };
    let classes = stored_classes(reader, &places[0], count, texcoords)?;
    let mut workspace = Workspace::default();
    let mut triangles = Vec::with_capacity(outlines.len());
    for (_, of_primitive) in &outlines {
        let corners = of_primitive.as_flattened().iter();
        let corners: Vec<u32> = corners.map(|v| classes[*v as usize]).collect();
        match optimize_vertex_cache_strip(&corners, count, &mut workspace) {
            Ok(ordered) => triangles.push(ordered),
            Err(_) => return Ok(None),
        }
    }
    let mut old_of_new = Vec::new();
    let mut new_of_old = vec![u32::MAX; count];
    for corner in triangles.iter().flatten() {
        let new = &mut new_of_old[*corner as usize];
        if *new == u32::MAX {
            *new = old_of_new.len() as u32;
            old_of_new.push(*corner);
        }
    }
    let mut attributes = Vec::new();
    let mut targets = Vec::new();
    if let Some(list) = places[0].get("attributes") {
        attributes = named(reader, &list, &old_of_new)?;
    }
    for target in places[0].entries("targets")? {
        targets.push(named(reader, &target, &old_of_new)?);
    }
    Ok(Some(Shared {
        primitives,
        triangles,
        new_of_old,
        attributes,
        targets,
    }))
}

fn named<'a>(
    reader: &mut Reader<'a>,
    list: &Place<'a>,
    order: &[u32],
) -> Result<Vec<(String, Reordered)>, ReadError> {
    let mut out = Vec::new();
    for (name, index) in list.members() {
        out.push((name.to_owned(), reordered(reader, &index, order)?));
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::source::{Character, Joint, Primitive, RawMesh, Skeleton, Skin};
    use glam::{Affine3A, Vec3};

    /// A strip of quads, each with four vertices of its own, in a shuffled order.
    fn strip(quads: u32) -> Primitive {
        let mut strip = Primitive {
            influences: 1,
            ..Primitive::default()
        };
        for q in (0..quads).map(|q| (q * 7) % quads) {
            let first = strip.positions.len() as u32;
            for (x, y) in [(q, 0), (q + 1, 0), (q + 1, 1), (q, 1)] {
                strip.positions.push(Vec3::new(x as f32, y as f32, 0.0));
                // Less than what 8 bits tell apart.
                strip
                    .normals
                    .push((Vec3::Z + 1e-4 * x as f32 * Vec3::X / quads as f32).normalize());
                strip.joints.push(0);
                strip.weights.push(1.0);
            }
            strip.triangles.push([first, first + 1, first + 2]);
            strip.triangles.push([first + 2, first + 3, first]);
        }
        // No triangle uses it.
        strip.positions.push(Vec3::ONE);
        strip.normals.push(Vec3::Z);
        strip.joints.push(0);
        strip.weights.push(1.0);
        strip
    }

    fn corners(primitive: &Primitive) -> Vec<[[u32; 3]; 3]> {
        let at = |v: u32| primitive.positions[v as usize].to_array().map(f32::to_bits);
        let mut all: Vec<[[u32; 3]; 3]> = primitive
            .triangles
            .iter()
            .map(|t| {
                let least = (0..3).min_by_key(|i| at(t[*i])).unwrap();
                [0, 1, 2].map(|i| at(t[(least + i) % 3]))
            })
            .collect();
        all.sort_unstable();
        all
    }

    #[test]
    fn the_same_triangles_stand_on_fewer_vertices_in_the_order_of_their_use() {
        let mesh = RawMesh {
            name: "strip".into(),
            skin: Skin {
                joints: vec![0],
                inverse_bind: vec![Affine3A::IDENTITY],
            },
            primitives: vec![strip(31)],
            ..RawMesh::default()
        };
        let joint = Joint {
            name: "root".into(),
            parent: None,
            rest: articula_core::Transform::IDENTITY,
            in_skin: true,
        };
        let character = Character {
            skeleton: Skeleton {
                joints: vec![joint],
            },
            meshes: vec![mesh],
            ..Character::default()
        };
        let mut document = Document::from_character(&character).unwrap();
        document.optimise_vertex_order(1.0 / 4096.0).unwrap();
        let file = crate::gltf::read_document(document.clone(), &Limits::default()).unwrap();
        let after = &file.value.character.meshes[0].primitives[0];
        assert_eq!(after.positions.len(), 64);
        assert_eq!(corners(after), corners(&character.meshes[0].primitives[0]));
        let mut seen = 0;
        for corner in after.triangles.as_flattened() {
            assert!(*corner <= seen);
            seen = seen.max(corner + 1);
        }
        // One joint carries it whole, so there are positions, normals and indices.
        assert_eq!(document.count("accessors"), 3);
    }
}
