//! Writing of levels into a document: every array of a primitive in the order of the levels.

use super::version::{MAX_LEVELS, VERSION};
use crate::error::ReadError;
use crate::gltf::append::{Use, entries_mut, object, push, set};
use crate::gltf::arrays::{Reordered, reordered};
use crate::gltf::compression::take_extension;
use crate::gltf::document::Document;
use crate::gltf::extension::CLUSTERED_MESH;
use crate::gltf::origin::{mesh_of, origins};
use crate::gltf::place::{Place, whole};
use crate::gltf::prune::each_accessor_reference;
use crate::gltf::reader::{Notes, Reader};
use crate::limits::Limits;
use crate::written::WriteError;
use articula_core::source::RawMesh;
use articula_core::{Cluster, ClusteredTriangles, Clusters, LevelTable};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};

/// Maximum number of vertices for 16-bit indices; index 65535 would restart a strip.
const MAX_SHORT: usize = 65535;

/// Extensions of primitives that refer to single vertices only through attributes.
const HARMLESS: &[&str] = &[
    CLUSTERED_MESH,
    "EXT_mesh_features",
    "KHR_materials_variants",
];

/// Levels of one part of a mesh, as `articula_build::cluster` makes them with the order `Store`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartLevels<'a> {
    /// For each stored vertex, its index in the part as read.
    pub vertices: &'a [u32],
    /// Stored triangles, indexing `vertices`; the finest level first, in one range.
    pub triangles: &'a [[u32; 3]],
    /// The levels that show each of them.
    pub clusters: &'a Clusters,
}

/// Levels of all parts of the mesh that a node shows.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshParts<'a> {
    /// The node, as in `node_of_mesh` of [`GltfFile`](crate::gltf::GltfFile).
    pub node: usize,
    /// One entry for each primitive of the mesh as read.
    pub parts: Vec<PartLevels<'a>>,
}

/// Which lists of triangles a primitive gets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Lists {
    /// Its own, the finest level, and that of all levels with their clusters.
    Clustered,
    /// Its own alone.
    Single,
}

/// A primitive with its vertices in a new order, not yet in the document.
struct NewPrimitive {
    primitive: usize,
    /// Index of the morph target (`None` for an attribute), attribute name, and index of its array.
    slots: Vec<(Option<usize>, String, usize)>,
    arrays: Vec<Reordered>,
}

impl Document {
    /// Writes levels of meshes, and their table into the document.
    ///
    /// All vertex arrays are reordered by level (attributes of every kind and morph targets; the
    /// bytes of elements are unchanged, sparse ones stay sparse), and vertices that no level uses
    /// are dropped. Strips, fans and triangles without indices become indexed triangles; points and
    /// lines stay as they are. A mesh that several nodes use is stored once if they are given the
    /// same levels. Data that is no longer referenced is dropped.
    ///
    /// Previous levels, also those of `MSFT_lod` on these nodes, are replaced.
    ///
    /// # Errors
    /// [`WriteError::Mismatch`] if parts or vertices are not those that [`read`](crate::gltf::read)
    /// returns, levels differ in number, the finest is not the first range, or a primitive has an
    /// extension that may refer to single vertices. The document is then unchanged.
    pub fn set_mesh_levels(
        &mut self,
        levels: &LevelTable,
        meshes: &[MeshParts<'_>],
    ) -> Result<(), WriteError> {
        self.write_mesh_levels(levels, meshes)?;
        for mesh in meshes {
            self.clear_level_nodes(mesh.node);
        }
        Ok(())
    }

    /// Replaces meshes by a single level each, which becomes their ordinary triangles: no list of
    /// levels remains, neither of this extension nor of `MSFT_lod` on these nodes. Otherwise as
    /// [`Document::set_mesh_levels`].
    ///
    /// A primitive whose level has no triangle gets one of three equal corners, which shows
    /// nothing: its mesh, skin and morph targets remain in use.
    ///
    /// # Errors
    /// As [`Document::set_mesh_levels`], also if a part has several levels.
    pub fn set_single_level(&mut self, meshes: &[MeshParts<'_>]) -> Result<(), WriteError> {
        check_all(meshes, 1)?;
        let nothing = Clusters::new(
            vec![1],
            vec![Cluster {
                finest_level: 0,
                coarsest_level: 0,
                region: 0,
                triangles: 0..1,
            }],
        );
        let nothing = nothing.map_err(|e| WriteError::mismatch(e.at, e.what))?;
        let empty = PartLevels {
            vertices: &[0],
            triangles: &[[0; 3]],
            clusters: &nothing,
        };
        let drawn = |part: &PartLevels<'_>| !part.triangles.is_empty();
        let shown: Vec<MeshParts<'_>> = meshes
            .iter()
            .map(|mesh| MeshParts {
                node: mesh.node,
                parts: mesh
                    .parts
                    .iter()
                    .map(|p| if drawn(p) { *p } else { empty })
                    .collect(),
            })
            .collect();
        self.put_meshes(&shown, Lists::Single)?;
        for mesh in meshes {
            self.clear_level_nodes(mesh.node);
        }
        self.drop_level_table();
        // Prepared data describes the whole mesh.
        self.remove_prepared();
        Ok(())
    }

    /// Removes the table of levels if no mesh has levels any more.
    pub(in crate::gltf) fn drop_level_table(&mut self) {
        let mut meshes = entries_mut(&mut self.json, "meshes").iter_mut();
        let has_levels = |p: &Value| p["extensions"].get(CLUSTERED_MESH).is_some();
        if meshes.any(|m| entries_mut(m, "primitives").iter().any(has_levels)) {
            return;
        }
        take_extension(&mut self.json, CLUSTERED_MESH);
        self.disuse_extension(CLUSTERED_MESH);
    }

    /// As [`Document::set_mesh_levels`], but keeps levels of `MSFT_lod`.
    fn write_mesh_levels(
        &mut self,
        levels: &LevelTable,
        meshes: &[MeshParts<'_>],
    ) -> Result<(), WriteError> {
        let table = super::level_table::table(levels)?;
        check_all(meshes, levels.levels.len())?;
        self.put_meshes(meshes, Lists::Clustered)?;
        self.extend(CLUSTERED_MESH, table);
        Ok(())
    }

    /// Stores meshes in the order of their levels, and drops what they no longer use.
    fn put_meshes(&mut self, meshes: &[MeshParts<'_>], lists: Lists) -> Result<(), WriteError> {
        let planned = self.plan(meshes)?;
        let mut given: Vec<(usize, &MeshParts<'_>, usize)> = Vec::new();
        let untouched = self.json.get("meshes").cloned().unwrap_or_default();
        let before = self.mesh_accessors();
        for ((mesh, primitives), parts) in planned.into_iter().zip(meshes) {
            let same = given
                .iter()
                .find(|(m, g, _)| *m == mesh && g.parts == parts.parts);
            let stored = if let Some((_, _, stored)) = same {
                *stored
            } else {
                let is_first = given.iter().all(|(m, _, _)| *m != mesh);
                let stored = if is_first {
                    mesh
                } else {
                    push(&mut self.json, "meshes", untouched[mesh].clone())
                };
                for (new, part) in primitives.into_iter().zip(&parts.parts) {
                    self.put(stored, new, part, lists);
                }
                stored
            };
            given.push((mesh, parts, stored));
            set(
                &mut entries_mut(&mut self.json, "nodes")[parts.node],
                "mesh",
                stored,
            );
        }
        self.drop_unnamed(before);
        Ok(())
    }

    /// Writes the levels of a character's meshes onto the nodes that show them.
    pub(in crate::gltf) fn add_stored_levels(
        &mut self,
        levels: &LevelTable,
        (meshes, nodes): (&[RawMesh], &[usize]),
    ) -> Result<(), WriteError> {
        let most = meshes
            .iter()
            .flat_map(|m| &m.primitives)
            .map(|p| p.positions.len());
        let same: Vec<u32> = (0..most.max().unwrap_or(0) as u32).collect();
        let mut given = Vec::new();
        for (mesh, node) in meshes.iter().zip(nodes) {
            let drawn = mesh.primitives.iter().zip(&mesh.clustered);
            let drawn = drawn.filter(|(primitive, _)| !primitive.triangles.is_empty());
            let parts: Vec<_> = drawn
                .map(|(primitive, object)| PartLevels {
                    vertices: &same[..primitive.positions.len()],
                    triangles: &object.triangles,
                    clusters: &object.clusters,
                })
                .collect();
            if !parts.is_empty() {
                given.push(MeshParts { node: *node, parts });
            }
        }
        if given.is_empty() {
            return Ok(());
        }
        self.write_mesh_levels(levels, &given)
    }

    /// Returns the mesh of each node, and its primitives in their new order; changes nothing.
    fn plan(
        &self,
        meshes: &[MeshParts<'_>],
    ) -> Result<Vec<(usize, Vec<NewPrimitive>)>, WriteError> {
        let limits = Limits::default();
        let mut reader = Reader::new(self, &limits, Notes::default());
        let mut out: Vec<(usize, Vec<NewPrimitive>)> = Vec::new();
        for (i, mesh) in meshes.iter().enumerate() {
            let unread = |e: ReadError| mismatch(mesh.node, e.to_string());
            let place = mesh_of(&reader, mesh.node).map_err(unread)?;
            let index = self.json["nodes"][mesh.node].get("mesh");
            let index = index.and_then(whole).unwrap_or(0) as usize;
            let is_known = meshes[..i]
                .iter()
                .zip(&out)
                .any(|(m, (o, _))| *o == index && m.parts == mesh.parts);
            if is_known {
                out.push((index, Vec::new()));
                continue;
            }
            let origins = origins(&mut reader, &place).map_err(unread)?;
            if origins.len() != mesh.parts.len() {
                let what = format!(
                    "{} parts, but the file has {} readable primitives",
                    mesh.parts.len(),
                    origins.len()
                );
                return Err(mismatch(mesh.node, what));
            }
            let mut primitives = Vec::new();
            for (origin, part) in origins.iter().zip(&mesh.parts) {
                let raw = |v: &u32| origin.vertices.get(*v as usize).copied();
                let order: Option<Vec<u32>> = part.vertices.iter().map(raw).collect();
                let order = order.ok_or_else(|| {
                    let what = "a vertex index is out of range";
                    mismatch(mesh.node, format!("primitive {}: {what}", origin.primitive))
                })?;
                let place = place.entry("primitives", origin.primitive);
                let place =
                    place.ok_or_else(|| mismatch(mesh.node, "the primitive does not exist"))?;
                refuse_unknown(&place)?;
                let new = new_primitive(&mut reader, (&place, origin.primitive), &order);
                primitives.push(new.map_err(unread)?);
            }
            out.push((index, primitives));
        }
        Ok(out)
    }

    /// Stores a primitive in its new order.
    fn put(&mut self, mesh: usize, new: NewPrimitive, part: &PartLevels<'_>, lists: Lists) {
        let arrays: Vec<usize> = new
            .arrays
            .into_iter()
            .map(|a| self.add_reordered(a))
            .collect();
        self.state_bounds(&arrays, &Limits::default());
        let short = part.vertices.len() <= MAX_SHORT;
        let corners = part.triangles.as_flattened().iter();
        let bytes: Vec<u8> = if short {
            corners.flat_map(|&c| (c as u16).to_le_bytes()).collect()
        } else {
            corners.flat_map(|c| c.to_le_bytes()).collect()
        };
        let view = self.add_view(&bytes, Use::Indices);
        let list = |triangles: usize| {
            json!({
                "bufferView": view,
                "componentType": if short { 5123 } else { 5125 },
                "count": triangles * 3,
                "type": "SCALAR",
            })
        };
        let own = self.add_accessor(list(part.clusters.triangles(0) as usize));
        let clustered = (lists == Lists::Clustered).then(|| {
            let clusters: Vec<Value> = part.clusters.clusters().iter().map(cluster).collect();
            json!({
                "version": VERSION,
                "indices": self.add_accessor(list(part.triangles.len())),
                "vertices": part.clusters.vertex_counts(),
                "clusters": clusters,
            })
        });
        let mesh = &mut entries_mut(&mut self.json, "meshes")[mesh];
        let primitive = &mut entries_mut(mesh, "primitives")[new.primitive];
        for (target, name, array) in new.slots {
            let owner = match target {
                None => &mut primitive["attributes"],
                Some(t) => &mut primitive["targets"][t],
            };
            set(owner, &name, arrays[array]);
        }
        object(primitive).shift_remove("mode");
        set(primitive, "indices", own);
        if let Some(value) = clustered {
            let extensions = object(primitive)
                .entry("extensions")
                .or_insert_with(|| json!({}));
            set(extensions, CLUSTERED_MESH, value);
        } else {
            take_extension(primitive, CLUSTERED_MESH);
        }
    }

    /// Returns all accessors that meshes use.
    pub(in crate::gltf) fn mesh_accessors(&self) -> BTreeSet<usize> {
        let mut json = json!({ "meshes": self.json.get("meshes") });
        let mut found = BTreeSet::new();
        each_accessor_reference(&mut json, &mut |i| {
            found.insert(i);
            i
        });
        found
    }
}

fn mismatch(node: usize, what: impl Into<String>) -> WriteError {
    WriteError::mismatch(format!("nodes[{node}].mesh"), what)
}

fn check_all(meshes: &[MeshParts<'_>], levels: usize) -> Result<(), WriteError> {
    for mesh in meshes {
        for (p, part) in mesh.parts.iter().enumerate() {
            check(part, levels).map_err(|what| mismatch(mesh.node, format!("part {p}: {what}")))?;
        }
    }
    Ok(())
}

fn check(part: &PartLevels<'_>, levels: usize) -> Result<(), String> {
    let found = part.clusters.levels();
    if found != levels || levels > MAX_LEVELS {
        return Err(format!(
            "{found} levels, the table has {levels}, the limit is {MAX_LEVELS}"
        ));
    }
    let object = ClusteredTriangles {
        clusters: part.clusters.clone(),
        triangles: part.triangles.to_vec(),
    };
    object
        .check(part.vertices.len())
        .map_err(|e| e.to_string())?;
    let finest: Vec<_> = part.clusters.ranges(0).collect();
    match finest.as_slice() {
        [] if part.triangles.is_empty() => Ok(()),
        [range] if range.start == 0 => Ok(()),
        _ => Err("the finest level must be the first range of the triangles".to_owned()),
    }
}

fn refuse_unknown(primitive: &Place<'_>) -> Result<(), WriteError> {
    let extensions = primitive.get("extensions");
    for (name, place) in extensions.iter().flat_map(Place::members) {
        if !HARMLESS.contains(&name) {
            let what = "may refer to vertices, whose order changes; remove it first";
            return Err(WriteError::mismatch(place.at(), what));
        }
    }
    Ok(())
}

fn new_primitive<'a>(
    reader: &mut Reader<'a>,
    (place, primitive): (&Place<'a>, usize),
    order: &[u32],
) -> Result<NewPrimitive, ReadError> {
    let mut owners = vec![(None, place.require("attributes")?)];
    let targets = place.entries("targets")?;
    owners.extend(targets.into_iter().enumerate().map(|(t, p)| (Some(t), p)));
    let mut arrays = Vec::new();
    let mut slots = Vec::new();
    let mut known = BTreeMap::new();
    for (target, owner) in owners {
        for (name, index) in owner.members() {
            let old = index.whole()?;
            let array = match known.get(&old) {
                Some(array) => *array,
                None => {
                    arrays.push(reordered(reader, &index, order)?);
                    known.insert(old, arrays.len() - 1);
                    arrays.len() - 1
                }
            };
            slots.push((target, name.to_owned(), array));
        }
    }
    Ok(NewPrimitive {
        primitive,
        slots,
        arrays,
    })
}

fn cluster(cluster: &Cluster) -> Value {
    let mut value = json!({
        "first": cluster.finest_level,
        "last": cluster.coarsest_level,
        "triangles": cluster.triangles.end - cluster.triangles.start,
    });
    if cluster.region > 0 {
        set(&mut value, "region", cluster.region);
    }
    value
}
