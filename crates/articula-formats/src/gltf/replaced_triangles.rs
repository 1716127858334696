//! Other triangles over the vertices that a mesh has.

use super::append::{Use, entries_mut, set};
use super::document::Document;
use super::origin::{mesh_of, origins};
use super::reader::{Notes, Reader};
use super::vertex_order::is_plain_list;
use crate::error::ReadError;
use crate::limits::Limits;
use serde_json::json;

impl Document {
    /// Whether the triangles of each part of a node's mesh can be replaced: the part is a list of triangles
    /// without extensions that depend on them, and no other node shows the mesh. Parts are those of
    /// [`read`](super::read).
    ///
    /// # Errors
    /// [`ReadError`] if the node does not exist or the document is malformed.
    pub fn replaceable_parts(&self, node: usize) -> Result<Vec<bool>, ReadError> {
        let limits = Limits::default();
        let mut reader = Reader::new(self, &limits, Notes::default());
        let mesh = mesh_of(&reader, node)?;
        let shown = self.mesh_of_node(node);
        let nodes = (0..self.count("nodes")).filter(|n| self.mesh_of_node(*n) == shown);
        let is_alone = nodes.count() == 1;
        let primitives = mesh.entries("primitives")?;
        let origins = origins(&mut reader, &mesh)?;
        let plain = |p: usize| primitives.get(p).is_some_and(is_plain_list);
        let parts = origins
            .iter()
            .map(|origin| is_alone && plain(origin.primitive));
        Ok(parts.collect())
    }

    /// Replaces the triangles of parts of a node's mesh, whose vertices have the numbers that
    /// [`read`](super::read) gives them. `None` keeps those of a part. Vertices stay, used or not.
    ///
    /// # Errors
    /// [`ReadError`] if the node does not exist, a vertex is out of range or the document is malformed; the
    /// document is then unchanged.
    pub fn replace_triangles(
        &mut self,
        node: usize,
        parts: &[Option<Vec<[u32; 3]>>],
    ) -> Result<(), ReadError> {
        let lists = {
            let limits = Limits::default();
            let mut reader = Reader::new(self, &limits, Notes::default());
            let mesh = mesh_of(&reader, node)?;
            let origins = origins(&mut reader, &mesh)?;
            let mut lists = Vec::new();
            for (origin, triangles) in origins.iter().zip(parts) {
                let Some(triangles) = triangles else { continue };
                let corners = triangles.as_flattened().iter();
                let stored = corners.map(|v| origin.vertices.get(*v as usize).copied());
                let stored: Option<Vec<u32>> = stored.collect();
                let outside = || mesh.malformed("a triangle has a vertex that does not exist");
                lists.push((origin.primitive, stored.ok_or_else(outside)?));
            }
            lists
        };
        let Some(mesh) = self.mesh_of_node(node) else {
            return Ok(());
        };
        let before = self.mesh_accessors();
        for (primitive, corners) in lists {
            let bytes: Vec<u8> = corners.iter().flat_map(|v| v.to_le_bytes()).collect();
            let view = self.add_view(&bytes, Use::Indices);
            let indices = self.add_accessor(json!({
                "bufferView": view,
                "componentType": 5125,
                "count": corners.len(),
                "type": "SCALAR",
            }));
            let mesh = &mut entries_mut(&mut self.json, "meshes")[mesh];
            let primitive = &mut entries_mut(mesh, "primitives")[primitive];
            set(primitive, "indices", indices);
        }
        self.drop_unnamed(before);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::Transform;
    use articula_core::source::{Character, Joint, Primitive, RawMesh, Skeleton, Skin};
    use glam::{Affine3A, Vec3};

    /// A square of two triangles.
    fn square() -> Document {
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let primitive = Primitive {
            positions: corners
                .iter()
                .map(|(x, y)| Vec3::new(*x, *y, 0.0))
                .collect(),
            influences: 1,
            joints: vec![0; 4],
            weights: vec![1.0; 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Primitive::default()
        };
        let character = Character {
            skeleton: Skeleton {
                joints: vec![Joint {
                    name: "root".into(),
                    parent: None,
                    rest: Transform::IDENTITY,
                    in_skin: true,
                }],
            },
            meshes: vec![RawMesh {
                name: "square".into(),
                skin: Skin {
                    joints: vec![0],
                    inverse_bind: vec![Affine3A::IDENTITY],
                },
                primitives: vec![primitive],
                ..RawMesh::default()
            }],
            ..Character::default()
        };
        Document::from_character(&character).unwrap()
    }

    fn node(document: &Document) -> usize {
        let mut nodes = 0..document.count("nodes");
        nodes
            .rfind(|n| document.mesh_of_node(*n).is_some())
            .unwrap()
    }

    fn triangles(document: &Document) -> Vec<[u32; 3]> {
        let read = crate::gltf::read_document(document.clone(), &Limits::default()).unwrap();
        read.value.character.meshes[0].primitives[0]
            .triangles
            .clone()
    }

    #[test]
    fn other_triangles_stand_on_the_same_vertices() {
        let mut document = square();
        let node = node(&document);
        assert_eq!(document.replaceable_parts(node).unwrap(), [true]);
        let before = document.count("accessors");
        document.replace_triangles(node, &[None]).unwrap();
        assert_eq!(triangles(&document), [[0, 1, 2], [0, 2, 3]]);
        document
            .replace_triangles(node, &[Some(vec![[1, 2, 3]])])
            .unwrap();
        assert_eq!(triangles(&document), [[1, 2, 3]]);
        assert_eq!(document.count("accessors"), before);
        let kept = document.clone();
        assert!(
            document
                .replace_triangles(node, &[Some(vec![[0, 1, 4]])])
                .is_err()
        );
        assert!(document.replace_triangles(99, &[None]).is_err());
        assert_eq!(document.json, kept.json);
    }

    #[test]
    fn strips_extended_primitives_and_meshes_shown_twice_cannot_be_replaced() {
        let mut strip = square();
        strip.json["meshes"][0]["primitives"][0]["mode"] = json!(5);
        let mut extended = square();
        extended.json["meshes"][0]["primitives"][0]["extensions"] = json!({"EXT_new": {}});
        let mut twice = square();
        let nodes = twice.json["nodes"].as_array_mut().unwrap();
        nodes.push(json!({"mesh": 0}));
        for document in [strip, extended, twice] {
            let node = node(&document);
            assert_eq!(document.replaceable_parts(node).unwrap(), [false]);
        }
    }
}
