//! Addition of morph targets to a mesh of a document.

use super::append::{entries_mut, index, object, push, set};
use super::document::Document;
use super::geometry::add_morph;
use super::primitive;
use super::reader::Reader;
use crate::limits::Limits;
use crate::notes::Notes;
use crate::written::WriteError;
use articula_core::source::{MorphTarget, Primitive, RawMesh};
use glam::Vec3;
use serde_json::{Value, json};

impl Document {
    /// Gives the mesh of a node the morph targets that `mesh`, which was read from it, has after those
    /// of the document.
    ///
    /// # Errors
    /// [`WriteError::Mismatch`] if the node has no mesh, there is no new morph target, parts of the
    /// mesh are not triangles or differ in their number of morph targets, or arrays have other
    /// lengths; the document is then unchanged.
    pub fn add_morph_targets(&mut self, node: usize, mesh: &RawMesh) -> Result<(), WriteError> {
        let at = || format!("nodes[{node}].mesh");
        let of_node = self.json["nodes"].get(node).and_then(|n| index(n, "mesh"));
        let entry = of_node.and_then(|m| Some((m, self.json["meshes"].get(m)?.clone())));
        let Some((number, stored)) = entry else {
            return Err(WriteError::mismatch(at(), "the node has no mesh"));
        };
        let none = Vec::new();
        let parts = stored["primitives"].as_array().unwrap_or(&none);
        if parts.len() != mesh.primitives.len() {
            let what = "some of its parts are points or lines, which have no morph targets";
            return Err(WriteError::mismatch(at(), what));
        }
        let stored_targets = |p: &Value| p["targets"].as_array().map_or(0, Vec::len);
        let before = parts.iter().map(stored_targets).max().unwrap_or(0);
        if parts.iter().any(|p| stored_targets(p) != before) || before >= mesh.morph_names.len() {
            return Err(WriteError::mismatch(
                at(),
                "it has these morph targets already",
            ));
        }
        let mut whole = Vec::with_capacity(parts.len());
        for (part, primitive) in mesh.primitives.iter().enumerate() {
            let vertices = self.vertices_of(number, part, primitive);
            if primitive.morphs.len() != mesh.morph_names.len() || vertices.is_none() {
                return Err(WriteError::mismatch(
                    at(),
                    "the lengths of its arrays do not match",
                ));
            }
            whole.extend(vertices);
        }
        for (part, (primitive, (count, vertices))) in mesh.primitives.iter().zip(whole).enumerate()
        {
            let targets = primitive.morphs[before..].iter().map(|m| {
                let target = MorphTarget {
                    positions: scattered(&m.positions, &vertices, count),
                    normals: scattered(&m.normals, &vertices, count),
                };
                add_morph(self, &target)
            });
            let targets: Vec<Value> = targets.collect();
            let stored = &mut entries_mut(&mut self.json, "meshes")[number];
            let part = &mut entries_mut(stored, "primitives")[part];
            for target in targets {
                push(part, "targets", target);
            }
        }
        for node in entries_mut(&mut self.json, "nodes") {
            let weights = node.get("weights").and_then(Value::as_array).map(Vec::len);
            if index(node, "mesh") == Some(number) && weights.is_some() {
                for _ in before..mesh.morph_names.len() {
                    push(node, "weights", json!(0.0));
                }
            }
        }
        let stored = &mut entries_mut(&mut self.json, "meshes")[number];
        set(stored, "weights", mesh.morph_weights.clone());
        let extras = object(stored).entry("extras").or_insert_with(|| json!({}));
        set(extras, "targetNames", mesh.morph_names.clone());
        Ok(())
    }

    /// Number of vertices of a stored part, and which of them the part that was read has: those that
    /// triangles use, where several parts share one array. `None` if they do not fit.
    fn vertices_of(&self, mesh: usize, part: usize, read: &Primitive) -> Option<(usize, Vec<u32>)> {
        let stored = &self.json["meshes"][mesh]["primitives"][part];
        let accessor = |owner: &Value, key: &str| self.json["accessors"].get(index(owner, key)?);
        let count = accessor(&stored["attributes"], "POSITION")?["count"].as_u64()? as usize;
        let fits = |m: &MorphTarget| {
            let len = read.positions.len();
            m.positions.len() == len && (m.normals.is_empty() || m.normals.len() == len)
        };
        if !read.morphs.iter().all(fits) {
            return None;
        }
        if read.positions.len() == count {
            return Some((count, (0..count as u32).collect()));
        }
        let limits = Limits::default();
        let mut reader = Reader::new(self, &limits, Notes::default());
        let mesh = reader.root.entry("meshes", mesh)?;
        let place = mesh.entry("primitives", part)?;
        let (_, triangles) = primitive::outline(&mut reader, &place).ok()??;
        let mut used: Vec<u32> = triangles.into_iter().flatten().collect();
        used.sort_unstable();
        used.dedup();
        (used.len() == read.positions.len()).then_some((count, used))
    }
}

/// Values at their vertices among `count`, and zeros; empty for an absent attribute.
fn scattered(values: &[Vec3], vertices: &[u32], count: usize) -> Vec<Vec3> {
    if values.is_empty() {
        return Vec::new();
    }
    let mut all = vec![Vec3::ZERO; count];
    for (vertex, value) in vertices.iter().zip(values) {
        all[*vertex as usize] = *value;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gltf;
    use articula_core::Transform;
    use articula_core::source::{Character, Joint, Skeleton, Skin};
    use glam::Affine3A;

    fn read(document: &Document) -> gltf::GltfFile {
        let bytes = document.write_glb().unwrap();
        let mut beside = |uri: &str| Err(format!("there is no {uri}"));
        gltf::read(&bytes, &Limits::default(), &mut beside)
            .unwrap()
            .value
    }

    /// A mesh of two parts with four vertices each, of which a triangle uses three.
    fn document() -> Document {
        let part = Primitive {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
            influences: 1,
            joints: vec![0; 4],
            weights: vec![1.0; 4],
            triangles: vec![[0, 1, 2]],
            ..Primitive::default()
        };
        let other = Primitive {
            triangles: vec![[1, 2, 3]],
            ..part.clone()
        };
        let character = Character {
            skeleton: Skeleton {
                joints: vec![Joint {
                    name: "head".to_owned(),
                    parent: None,
                    rest: Transform::IDENTITY,
                    in_skin: true,
                }],
            },
            meshes: vec![RawMesh {
                name: "face".to_owned(),
                skin: Skin {
                    joints: vec![0],
                    inverse_bind: vec![Affine3A::IDENTITY],
                },
                primitives: vec![part.clone(), other],
                ..RawMesh::default()
            }],
            ..Character::default()
        };
        Document::from_character(&character).unwrap()
    }

    /// The mesh of a file with one morph target: each vertex of a part moves by its number.
    fn with_target(file: &gltf::GltfFile) -> RawMesh {
        let mut mesh = file.character.meshes[0].clone();
        mesh.morph_names = vec!["jawOpen".to_owned()];
        mesh.morph_weights = vec![0.0];
        for primitive in &mut mesh.primitives {
            let offsets = (0..primitive.positions.len()).map(|v| v as f32 * Vec3::Z);
            primitive.morphs = vec![MorphTarget {
                positions: offsets.clone().collect(),
                normals: offsets.map(|o| -o).collect(),
            }];
        }
        mesh
    }

    #[test]
    fn targets_come_back_with_names_and_offsets() {
        let mut document = document();
        let file = read(&document);
        let mesh = with_target(&file);
        document
            .add_morph_targets(file.node_of_mesh[0], &mesh)
            .unwrap();
        let back = read(&document).character.meshes.swap_remove(0);
        assert_eq!(
            (&back.morph_names, &*back.morph_weights),
            (&mesh.morph_names, &[0.0][..])
        );
        assert_eq!(back.primitives, mesh.primitives);
        let again = document.add_morph_targets(file.node_of_mesh[0], &mesh);
        assert!(
            again
                .unwrap_err()
                .to_string()
                .contains("has these morph targets already")
        );
        // A further one comes after it, with the weight of its node.
        document.json["nodes"][file.node_of_mesh[0]]["weights"] = json!([0.5]);
        let mut more = read(&document).character.meshes.swap_remove(0);
        more.morph_names.push("fap3_0_1000".to_owned());
        more.morph_weights = vec![0.0; 2];
        for primitive in &mut more.primitives {
            let new = primitive.morphs[0].positions.iter().map(|p| -*p);
            let normals = primitive.morphs[0].normals.clone();
            primitive.morphs.push(MorphTarget {
                positions: new.collect(),
                normals,
            });
        }
        document
            .add_morph_targets(file.node_of_mesh[0], &more)
            .unwrap();
        let back = read(&document).character.meshes.swap_remove(0);
        assert_eq!(back.primitives, more.primitives);
        assert_eq!(back.morph_names, more.morph_names);
        assert_eq!(back.morph_weights, [0.5, 0.0]);
    }

    #[test]
    fn parts_that_share_vertices_get_targets_for_all_of_them() {
        // Both parts use the array of the first, of which a reader keeps three vertices for each.
        let mut document = document();
        let parts = document.json["meshes"][0]["primitives"]
            .as_array()
            .unwrap()
            .clone();
        let attributes = parts[0]["attributes"].clone();
        document.json["meshes"][0]["primitives"][1]["attributes"] = attributes;
        let file = read(&document);
        let mesh = with_target(&file);
        document
            .add_morph_targets(file.node_of_mesh[0], &mesh)
            .unwrap();
        let back = read(&document).character.meshes.swap_remove(0);
        assert_eq!(back.primitives, mesh.primitives);
    }

    #[test]
    fn what_does_not_fit_changes_nothing() {
        let mut document = document();
        let file = read(&document);
        let before = document.json.clone();
        let mut mesh = with_target(&file);
        mesh.primitives[1].morphs[0].positions.pop();
        let node = file.node_of_mesh[0];
        assert!(document.add_morph_targets(node, &mesh).is_err());
        mesh.primitives.pop();
        assert!(document.add_morph_targets(node, &mesh).is_err());
        assert!(document.add_morph_targets(99, &mesh).is_err());
        assert_eq!(document.json, before);
    }
}
