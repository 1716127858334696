//! Exchange of geometry and pictures: a document without them, and with others in their place.

use super::append::{entries_mut, index, object, set};
use super::compression::take_extension;
use super::document::Document;
use super::extension::VARIANTS;
use super::geometry::{self, add_primitive};
use super::origin::{mesh_of, origins};
use super::reader::{Notes, Reader};
use crate::error::ReadError;
use crate::limits::Limits;
use crate::uri::mime_type;
use crate::written::WriteError;
use articula_core::source::{MorphTarget, Primitive};
use glam::Vec3;
use serde_json::Value;
use std::collections::BTreeSet;

/// Geometry of the mesh that a node shows.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshGeometry<'a> {
    /// The node, as in `node_of_mesh` of [`GltfFile`](super::GltfFile).
    pub node: usize,
    /// One entry for each primitive of the mesh as read; its material is ignored.
    pub parts: Vec<&'a Primitive>,
}

/// A mesh of the document and the primitives that get new arrays.
struct Planned {
    mesh: usize,
    is_skinned: bool,
    primitives: Vec<usize>,
}

/// Returns a primitive of a single triangle whose corners are one vertex, in the middle of another
/// primitive: it shows nothing, and keeps mesh, skin, material and the number of morph targets in
/// use. The vertex follows the joints of the other's first one, or the first joint of the skin if the
/// other has no vertex; its morph targets do not move it.
#[must_use]
pub fn placeholder(of: &Primitive) -> Primitive {
    let first = of.positions.first().copied().unwrap_or_default();
    let (low, high) = of
        .positions
        .iter()
        .fold((first, first), |(low, high), p| (low.min(*p), high.max(*p)));
    let influences = of.influences.max(1);
    let still = |target: &MorphTarget| MorphTarget {
        positions: vec![Vec3::ZERO],
        normals: target
            .normals
            .first()
            .map(|_| Vec3::ZERO)
            .into_iter()
            .collect(),
    };
    let (joints, weights) = if of.positions.is_empty() {
        let weight_of = |i| if i == 0 { 1.0 } else { 0.0 };
        (
            vec![0; influences],
            (0..influences).map(weight_of).collect(),
        )
    } else {
        let first_of = |count: usize| 0..count.min(influences);
        (
            of.joints[first_of(of.joints.len())].to_vec(),
            of.weights[first_of(of.weights.len())].to_vec(),
        )
    };
    Primitive {
        positions: vec![0.5 * (low + high)],
        normals: of.normals.iter().take(1).copied().collect(),
        texcoords: of.texcoords.iter().take(1).copied().collect(),
        colors: of.colors.iter().take(1).copied().collect(),
        influences,
        joints,
        weights,
        morphs: of.morphs.iter().map(still).collect(),
        triangles: vec![[0; 3]],
        material: of.material,
    }
}

impl Document {
    /// Replaces the arrays of meshes: positions, normals, the first texture coordinates, colours,
    /// influences, morph targets and triangles. All other attributes are removed, and so are levels,
    /// prepared data and extensions of primitives, except `KHR_materials_variants`; materials, names
    /// of morph targets and all else stay. A primitive without triangles gets its [`placeholder`].
    /// Arrays that nothing uses any more are dropped.
    ///
    /// # Errors
    /// [`WriteError::Mismatch`] if a node has no mesh, parts are not those that
    /// [`read`](super::read) returns, or the arrays of a part do not match each other, the joints of
    /// the node's skin or the number of morph targets. The document is then unchanged.
    pub fn set_geometry(&mut self, meshes: &[MeshGeometry<'_>]) -> Result<(), WriteError> {
        let planned: Vec<Planned> = meshes
            .iter()
            .map(|mesh| self.planned(mesh))
            .collect::<Result<_, _>>()?;
        let untouched = self.json.get("meshes").cloned().unwrap_or_default();
        let before = self.mesh_accessors();
        let mut given: Vec<(usize, usize)> = Vec::new();
        for (i, (plan, mesh)) in planned.iter().zip(meshes).enumerate() {
            let same = given.iter().find(|(before, _)| {
                planned[*before].mesh == plan.mesh && meshes[*before].parts == mesh.parts
            });
            let stored = match same {
                Some((_, stored)) => *stored,
                None => {
                    let is_first = given.iter().all(|(b, _)| planned[*b].mesh != plan.mesh);
                    let stored = if is_first {
                        plan.mesh
                    } else {
                        let copy = untouched[plan.mesh].clone();
                        super::append::push(&mut self.json, "meshes", copy)
                    };
                    self.put_arrays(stored, plan, &mesh.parts);
                    stored
                }
            };
            given.push((i, stored));
            set(
                &mut entries_mut(&mut self.json, "nodes")[mesh.node],
                "mesh",
                stored,
            );
        }
        for mesh in meshes {
            self.clear_level_nodes(mesh.node);
        }
        self.drop_unnamed(before);
        self.drop_level_table();
        self.remove_prepared();
        Ok(())
    }

    /// Checks the parts of a mesh; changes nothing.
    fn planned(&self, mesh: &MeshGeometry<'_>) -> Result<Planned, WriteError> {
        let limits = Limits::default();
        let mut reader = Reader::new(self, &limits, Notes::default());
        let at = format!("nodes[{}].mesh", mesh.node);
        let unread = |e: ReadError| WriteError::mismatch(&at, e.to_string());
        let place = mesh_of(&reader, mesh.node).map_err(unread)?;
        let primitives: Vec<usize> = origins(&mut reader, &place)
            .map_err(unread)?
            .iter()
            .map(|origin| origin.primitive)
            .collect();
        if primitives.len() != mesh.parts.len() {
            let what = format!(
                "{} parts, but the file has {} readable primitives",
                mesh.parts.len(),
                primitives.len()
            );
            return Err(WriteError::mismatch(at, what));
        }
        let node = &self.json["nodes"][mesh.node];
        let skin = index(node, "skin");
        let joints = skin.and_then(|s| self.json["skins"][s]["joints"].as_array());
        let joint_count = joints.map_or(1, Vec::len);
        for (part, primitive) in mesh.parts.iter().zip(&primitives) {
            let old = place.entry("primitives", *primitive);
            let morphs = old.map_or(0, |old| old.count("targets"));
            let place = || format!("{at}.primitives[{primitive}]");
            geometry::check(part, (joint_count, morphs), place)?;
        }
        Ok(Planned {
            mesh: index(node, "mesh").unwrap_or(0),
            is_skinned: skin.is_some(),
            primitives,
        })
    }

    /// Stores new arrays of some primitives of a mesh.
    fn put_arrays(&mut self, mesh: usize, plan: &Planned, parts: &[&Primitive]) {
        for (part, primitive) in parts.iter().zip(&plan.primitives) {
            let new = if part.triangles.is_empty() {
                add_primitive(self, &placeholder(part), plan.is_skinned)
            } else {
                add_primitive(self, part, plan.is_skinned)
            };
            let owner = &mut entries_mut(&mut self.json, "meshes")[mesh];
            let old = &mut entries_mut(owner, "primitives")[*primitive];
            for member in ["attributes", "indices", "targets"] {
                match new.get(member) {
                    Some(value) => set(old, member, value.clone()),
                    None => drop(object(old).shift_remove(member)),
                }
            }
            object(old).shift_remove("mode");
            let extensions = old.get("extensions").and_then(Value::as_object);
            let names: Vec<String> = extensions
                .into_iter()
                .flat_map(|e| e.keys().cloned())
                .collect();
            for name in names.iter().filter(|name| *name != VARIANTS) {
                take_extension(old, name);
            }
        }
    }

    /// Replaces pictures, by their indices, with files of a format that a texture can have: PNG,
    /// JPEG, WebP, AVIF, KTX 2 or DDS; the bytes of the old ones are dropped. Textures then name the
    /// picture in the extension of its format.
    ///
    /// # Errors
    /// [`WriteError::Mismatch`] if there is no such picture, or the bytes are of no such format.
    /// The document is then unchanged.
    pub fn set_pictures(&mut self, pictures: &[(usize, &[u8])]) -> Result<(), WriteError> {
        let count = self.count("images");
        let mut types = Vec::with_capacity(pictures.len());
        for (i, bytes) in pictures {
            let at = format!("images[{i}]");
            let mime = mime_type("", bytes);
            if *i >= count {
                let what = format!("there are {count} pictures");
                return Err(WriteError::mismatch(at, what));
            }
            if mime.is_empty() {
                return Err(WriteError::mismatch(
                    at,
                    "the bytes are not PNG, JPEG, WebP, AVIF, KTX 2 or DDS",
                ));
            }
            types.push(mime);
        }
        let mut unused = BTreeSet::new();
        for ((i, bytes), mime) in pictures.iter().zip(types) {
            let view = self.add_buffer_view(bytes);
            let image = &mut entries_mut(&mut self.json, "images")[*i];
            unused.extend(index(image, "bufferView"));
            object(image).shift_remove("uri");
            set(image, "bufferView", view);
            set(image, "mimeType", mime.as_str());
            self.retype_picture(*i, &mime);
            if let Some(fetched) = self.pictures.get_mut(*i) {
                *fetched = None;
            }
        }
        self.drop_unused_views(unused);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::Transform;
    use articula_core::source::{Character, Image, Joint, Material, RawMesh, Skeleton, Skin};
    use glam::{Affine3A, Vec2};

    /// A skinned square with a morph target and a picture.
    fn character() -> Character {
        let square = Primitive {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
            texcoords: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
            influences: 1,
            joints: vec![1; 4],
            weights: vec![1.0; 4],
            morphs: vec![MorphTarget {
                positions: vec![Vec3::Z; 4],
                normals: Vec::new(),
            }],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            material: Some(0),
            ..Primitive::default()
        };
        let joint = |parent| Joint {
            name: format!("{parent:?}"),
            parent,
            rest: Transform::IDENTITY,
            in_skin: true,
        };
        Character {
            skeleton: Skeleton {
                joints: vec![joint(None), joint(Some(0))],
            },
            meshes: vec![RawMesh {
                name: "square".into(),
                skin: Skin {
                    joints: vec![0, 1],
                    inverse_bind: vec![Affine3A::IDENTITY; 2],
                },
                primitives: vec![square],
                morph_names: vec!["smile".into()],
                morph_weights: vec![0.25],
                ..RawMesh::default()
            }],
            materials: vec![Material {
                base_color_image: Some(0),
                ..Material::default()
            }],
            images: vec![Image {
                name: "skin".into(),
                mime_type: "image/png".into(),
                bytes: [b"\x89PNG".as_slice(), &[7; 5000]].concat(),
            }],
            ..Character::default()
        }
    }

    fn read(document: &Document) -> super::super::GltfFile {
        let bytes = document.write_glb().unwrap();
        let read = super::super::read(&bytes, &Limits::default(), &mut |_| Err("none".into()));
        read.unwrap().value
    }

    #[test]
    fn a_primitive_without_anything_becomes_a_placeholder_of_the_first_joint() {
        let original = character();
        let mut document = Document::from_character(&original).unwrap();
        let nothing = Primitive {
            influences: 2,
            morphs: vec![MorphTarget::default()],
            ..Primitive::default()
        };
        let meshes = [MeshGeometry {
            node: 2,
            parts: vec![&nothing],
        }];
        document.set_geometry(&meshes).unwrap();
        let shown = &read(&document).character.meshes[0].primitives[0];
        assert_eq!(shown.positions, [Vec3::ZERO]);
        assert_eq!((shown.joints[0], shown.weights[0]), (0, 1.0));
        assert_eq!(shown.morphs[0].positions, [Vec3::ZERO]);
    }

    #[test]
    fn geometry_and_pictures_leave_and_come_back() {
        let original = character();
        let mut document = Document::from_character(&original).unwrap();
        let whole = document.write_glb().unwrap().len();
        let mesh = &original.meshes[0].primitives[0];
        let empty = placeholder(mesh);
        let parts = |part| {
            vec![MeshGeometry {
                node: 2,
                parts: vec![part],
            }]
        };
        document.set_geometry(&parts(&empty)).unwrap();
        let dot = b"\x89PNG dot".as_slice();
        document.set_pictures(&[(0, dot)]).unwrap();
        assert!(document.write_glb().unwrap().len() + 5000 < whole);
        let stripped = read(&document).character;
        assert_eq!(stripped.skeleton, original.skeleton);
        assert_eq!(stripped.images[0].bytes, dot);
        let left = &stripped.meshes[0];
        assert_eq!(left.primitives[0].positions, [Vec3::new(0.5, 0.5, 0.0)]);
        assert_eq!(left.primitives[0].morphs.len(), 1);
        assert_eq!(left.skin, original.meshes[0].skin);
        assert_eq!(left.morph_names, ["smile"]);
        assert_eq!(left.morph_weights, [0.25]);

        document.set_geometry(&parts(mesh)).unwrap();
        document
            .set_pictures(&[(0, &original.images[0].bytes)])
            .unwrap();
        let back = read(&document).character;
        // A file stores four influences for each vertex.
        let stored = read(&Document::from_character(&original).unwrap()).character;
        assert_eq!(back.meshes, stored.meshes);
        assert_eq!(back.images[0].bytes, original.images[0].bytes);
        assert_eq!(
            document.write_glb().unwrap().len().div_ceil(64),
            whole.div_ceil(64)
        );
    }

    #[test]
    fn an_empty_part_gets_a_placeholder() {
        let original = character();
        let mut document = Document::from_character(&original).unwrap();
        let none = Primitive {
            triangles: Vec::new(),
            ..original.meshes[0].primitives[0].clone()
        };
        let parts = vec![&none];
        document
            .set_geometry(&[MeshGeometry { node: 2, parts }])
            .unwrap();
        let read = read(&document).character;
        assert_eq!(read.meshes[0].primitives[0].triangles, [[0; 3]]);
    }

    #[test]
    fn parts_and_pictures_that_do_not_fit_are_refused() {
        let original = character();
        let mut document = Document::from_character(&original).unwrap();
        let before = document.clone();
        let mut wrong = original.meshes[0].primitives[0].clone();
        wrong.morphs.clear();
        for (node, parts) in [(2, vec![&wrong]), (2, vec![]), (0, vec![]), (9, vec![])] {
            let given = [MeshGeometry { node, parts }];
            assert!(document.set_geometry(&given).is_err());
        }
        assert!(document.set_pictures(&[(1, b"\x89PNG")]).is_err());
        assert!(document.set_pictures(&[(0, b"GIF89a")]).is_err());
        assert_eq!(document, before);
    }
}
