//! Creation of a new document from a character that does not come from a glTF file.

use super::append::{Use, float_bytes, push, set, short, shorts};
use super::document::Document;
use super::geometry::add_primitive;
use super::material::{CLAMP_TO_EDGE, MIRRORED_REPEAT};
use super::texture_source::is_texture_type;
use crate::uri::mime_type;
use crate::written::WriteError;
use articula_core::Transform;
use articula_core::source::{
    Character, Image, Joint, Material, Primitive, RawMesh, Skin, TextureWrap,
};
use glam::{Affine3A, Mat4, Vec3, Vec4};
use serde_json::{Value, json};

impl Document {
    /// Creates a document that shows a character: joint `i` becomes node `i`.
    ///
    /// A mesh with one joint and an identity inverse bind matrix is attached to that joint's node;
    /// other meshes are skinned, on separate nodes at the root of the scene. Joints of a skin that
    /// no mesh uses (all of them, for a skeleton without mesh) are listed by an additional skin, so
    /// that they remain joints and can carry their articulation. Pictures of an unknown type,
    /// primitives without triangles and clips without channels, which glTF cannot represent, are
    /// left out; so are expressions and the channels that drive them (`articula-build` converts
    /// those to weights and joint transforms first).
    ///
    /// # Errors
    /// [`WriteError::Mismatch`] if the character is not consistent: a missing joint, material or
    /// picture, arrays of unequal length.
    pub fn from_character(character: &Character) -> Result<Self, WriteError> {
        check(character)?;
        let mut document = Self {
            json: json!({
                "asset": {
                    "version": "2.0",
                    "generator": concat!("articula ", env!("CARGO_PKG_VERSION")),
                },
                "scene": 0,
                "scenes": [{}],
            }),
            buffers: Vec::new(),
            pictures: Vec::new(),
        };
        if !character.name.is_empty() {
            set(
                &mut document.json["scenes"][0],
                "name",
                character.name.as_str(),
            );
        }
        document.add_look(&character.materials, &character.images);
        document.add_joints(&character.skeleton.joints);
        let node_of_mesh = document.add_meshes(character);
        document.add_loose_joints(character);
        let node_of_joint: Vec<usize> = (0..character.skeleton.joints.len()).collect();
        document.replace_clips(&character.clips, &node_of_joint, &node_of_mesh)?;
        if let Some(levels) = &character.mesh_levels {
            document.add_stored_levels(levels, (&character.meshes, &node_of_mesh))?;
        }
        if let Some(credits) = &character.credits {
            document.set_credits(credits);
        }
        if let Some(articulation) = &character.articulation {
            document.set_articulation(articulation, &node_of_joint)?;
        }
        Ok(document)
    }

    fn add_joints(&mut self, joints: &[Joint]) {
        for (j, joint) in joints.iter().enumerate() {
            let mut node = json!({});
            if !joint.name.is_empty() {
                set(&mut node, "name", joint.name.as_str());
            }
            write_transform(&mut node, joint.rest);
            push(&mut self.json, "nodes", node);
            match joint.parent {
                Some(parent) => push(&mut self.json["nodes"][parent], "children", json!(j)),
                None => self.show(j),
            };
        }
    }

    /// Adds a node to the root of the scene.
    fn show(&mut self, node: usize) -> usize {
        push(&mut self.json["scenes"][0], "nodes", json!(node))
    }

    fn add_meshes(&mut self, character: &Character) -> Vec<usize> {
        let mut skins = Vec::new();
        let mut nodes = Vec::new();
        for mesh in &character.meshes {
            let own = rigid_joint(&mesh.skin).filter(|&j| self.json["nodes"][j]["mesh"].is_null());
            let index = self.add_mesh(mesh, &mesh.primitives, own.is_none());
            let node = own.unwrap_or_else(|| {
                let node = push(&mut self.json, "nodes", json!({"name": mesh.name}));
                self.show(node);
                node
            });
            nodes.push(node);
            let Some(index) = index else { continue };
            set(&mut self.json["nodes"][node], "mesh", index);
            if own.is_none() {
                self.bind(node, &mesh.skin, &mut skins);
            }
            let own = own.map(|j| (j, character.skeleton.joints[j].rest));
            self.add_levels(mesh, (node, own), &mut skins);
        }
        nodes
    }

    /// Adds coarser levels as nodes outside of the scene, listed by the node of the mesh.
    fn add_levels<'a>(
        &mut self,
        mesh: &'a RawMesh,
        (node, own): (usize, Option<(usize, Transform)>),
        skins: &mut Vec<(&'a Skin, usize)>,
    ) {
        let mut ids = Vec::new();
        let mut coverages = vec![mesh.screen_coverage];
        for level in &mesh.levels {
            let hung = own.and_then(|(joint, rest)| hung(&level.skin, joint, rest));
            let Some(index) = self.add_mesh(mesh, &level.primitives, hung.is_none()) else {
                continue;
            };
            let mut value = json!({"name": mesh.name, "mesh": index});
            if let Some(local) = hung {
                write_transform(&mut value, local);
            }
            let stand_in = push(&mut self.json, "nodes", value);
            if hung.is_none() {
                self.bind(stand_in, &level.skin, skins);
            }
            ids.push(stand_in);
            coverages.push(level.screen_coverage);
        }
        let coverages: Vec<f32> = coverages.into_iter().map_while(|c| c).collect();
        if !coverages.is_empty() {
            let extras = json!({"MSFT_screencoverage": shorts(&coverages)});
            set(&mut self.json["nodes"][node], "extras", extras);
        }
        if !ids.is_empty() {
            let extensions = json!({"MSFT_lod": {"ids": ids}});
            set(&mut self.json["nodes"][node], "extensions", extensions);
            self.use_extension("MSFT_lod");
        }
    }

    /// Sets the skin of a node; equal skins are stored once.
    fn bind<'a>(&mut self, node: usize, skin: &'a Skin, skins: &mut Vec<(&'a Skin, usize)>) {
        let known = skins.iter().find(|(known, _)| *known == skin);
        let index = known.map_or_else(|| self.add_skin(skin), |(_, i)| *i);
        skins.push((skin, index));
        set(&mut self.json["nodes"][node], "skin", index);
    }

    /// Adds a mesh of the given parts and returns its index; `None` if they have no triangle.
    fn add_mesh(&mut self, mesh: &RawMesh, parts: &[Primitive], is_skinned: bool) -> Option<usize> {
        let drawn = parts.iter().filter(|p| !p.triangles.is_empty());
        let has_morphs = parts.iter().any(|p| !p.morphs.is_empty());
        let primitives: Vec<Value> = drawn
            .map(|primitive| add_primitive(self, primitive, is_skinned))
            .collect();
        if primitives.is_empty() {
            return None;
        }
        let mut value = json!({"name": mesh.name, "primitives": primitives});
        if has_morphs {
            set(&mut value, "weights", shorts(&mesh.morph_weights));
            set(
                &mut value,
                "extras",
                json!({"targetNames": mesh.morph_names}),
            );
        }
        Some(push(&mut self.json, "meshes", value))
    }

    fn add_skin(&mut self, skin: &Skin) -> usize {
        let accessor = self.add_inverse_bind(&skin.inverse_bind);
        let value = json!({"inverseBindMatrices": accessor, "joints": skin.joints});
        push(&mut self.json, "skins", value)
    }

    /// Adds the inverse bind matrices of a skin and returns their accessor.
    pub(super) fn add_inverse_bind(&mut self, inverse_bind: &[Affine3A]) -> usize {
        let matrices = inverse_bind.iter();
        let matrices: Vec<f32> = matrices
            .flat_map(|m| Mat4::from(*m).to_cols_array())
            .collect();
        let view = self.add_view(&float_bytes(&matrices), Use::Other);
        self.add_accessor(json!({
            "bufferView": view,
            "componentType": 5126,
            "count": inverse_bind.len(),
            "type": "MAT4",
        }))
    }

    /// Adds a skin with the joints that no written skin names.
    fn add_loose_joints(&mut self, character: &Character) {
        let joints = &character.skeleton.joints;
        let mut is_loose: Vec<bool> = joints.iter().map(|j| j.in_skin).collect();
        for skin in self.json["skins"].as_array().into_iter().flatten() {
            for joint in skin["joints"].as_array().into_iter().flatten() {
                if let Some(j) = joint.as_u64() {
                    is_loose[j as usize] = false;
                }
            }
        }
        let loose: Vec<usize> = (0..joints.len()).filter(|&j| is_loose[j]).collect();
        if !loose.is_empty() {
            push(&mut self.json, "skins", json!({"joints": loose}));
        }
    }

    fn add_look(&mut self, materials: &[Material], images: &[Image]) {
        let pictures: Vec<Option<(usize, String)>> =
            images.iter().map(|i| self.add_image(i)).collect();
        let mut known = Vec::new();
        for material in materials {
            let mut texture = |image: Option<usize>, wrap| {
                let (picture, mime) = pictures[image?].as_ref()?;
                Some(self.texture(&mut known, (*picture, mime), wrap))
            };
            let base = texture(material.base_color_image, material.base_color_wrap);
            let emissive = texture(material.emissive_image, material.emissive_wrap);
            let value = look(material, base, emissive);
            for name in value["extensions"].as_object().into_iter().flatten() {
                self.use_extension(name.0);
            }
            push(&mut self.json, "materials", value);
        }
    }

    /// Returns the texture of a picture with this continuation, and adds it if there is none.
    fn texture(
        &mut self,
        known: &mut Vec<((usize, [TextureWrap; 2]), usize)>,
        (picture, mime): (usize, &str),
        wrap: [TextureWrap; 2],
    ) -> usize {
        let key = (picture, wrap);
        if let Some((_, texture)) = known.iter().find(|(own, _)| *own == key) {
            return *texture;
        }
        let texture = self.add_texture(picture, mime);
        if wrap != [TextureWrap::Repeat; 2] {
            let mode = |wrap| match wrap {
                TextureWrap::Repeat => 10497,
                TextureWrap::Mirror => MIRRORED_REPEAT,
                TextureWrap::Clamp => CLAMP_TO_EDGE,
            };
            let sampler = json!({"wrapS": mode(wrap[0]), "wrapT": mode(wrap[1])});
            let sampler = push(&mut self.json, "samplers", sampler);
            set(&mut self.json["textures"][texture], "sampler", sampler);
        }
        known.push((key, texture));
        texture
    }

    /// Adds a picture and returns its index and type; `None` if glTF has no texture of its type.
    fn add_image(&mut self, image: &Image) -> Option<(usize, String)> {
        let mime = mime_type(&image.mime_type, &image.bytes);
        if image.bytes.is_empty() || !is_texture_type(&mime) {
            return None;
        }
        let view = self.add_buffer_view(&image.bytes);
        let value = json!({"name": image.name, "mimeType": mime, "bufferView": view});
        let picture = push(&mut self.json, "images", value);
        Some((picture, mime))
    }
}

/// A material with these textures.
fn look(material: &Material, base: Option<usize>, emissive: Option<usize>) -> Value {
    let mut surface = json!({"metallicFactor": 0.0, "roughnessFactor": 1.0});
    if material.base_color != Vec4::ONE {
        let color = shorts(&material.base_color.to_array());
        set(&mut surface, "baseColorFactor", color);
    }
    if let Some(texture) = base {
        set(&mut surface, "baseColorTexture", json!({"index": texture}));
    }
    let mut value = json!({"name": material.name, "pbrMetallicRoughness": surface});
    if material.blends {
        set(&mut value, "alphaMode", "BLEND");
    } else if material.alpha_cutoff > 0.0 {
        set(&mut value, "alphaMode", "MASK");
        set(&mut value, "alphaCutoff", short(material.alpha_cutoff));
    }
    if material.double_sided {
        set(&mut value, "doubleSided", true);
    }
    let mut extensions = json!({});
    if material.emissive != Vec3::ZERO {
        let strength = material.emissive.max_element().max(1.0);
        let factor = shorts(&(material.emissive / strength).to_array());
        set(&mut value, "emissiveFactor", factor);
        if strength > 1.0 {
            let strength = json!({"emissiveStrength": short(strength)});
            set(&mut extensions, "KHR_materials_emissive_strength", strength);
        }
    }
    if let Some(texture) = emissive {
        set(&mut value, "emissiveTexture", json!({"index": texture}));
    }
    if material.unlit {
        set(&mut extensions, "KHR_materials_unlit", json!({}));
    }
    if extensions != json!({}) {
        set(&mut value, "extensions", extensions);
    }
    value
}

/// Returns the only joint of a rigid skin.
fn rigid_joint(skin: &Skin) -> Option<usize> {
    let is_identity = skin.inverse_bind == [Affine3A::IDENTITY];
    match skin.joints[..] {
        [joint] if is_identity => Some(joint),
        _ => None,
    }
}

/// Returns the transform of a level's node relative to the joint that its mesh is attached to;
/// `None` if the level does not follow that joint alone, or needs shear.
fn hung(skin: &Skin, joint: usize, rest: Transform) -> Option<Transform> {
    if rigid_joint(skin) == Some(joint) {
        return Some(rest);
    }
    match (&skin.joints[..], &skin.inverse_bind[..]) {
        ([only], [offset]) if *only == joint => {
            Transform::from_matrix(Mat4::from(rest.to_affine() * *offset))
        }
        _ => None,
    }
}

pub(super) fn write_transform(node: &mut Value, rest: Transform) {
    let identity = Transform::IDENTITY;
    if rest.translation != identity.translation {
        set(node, "translation", shorts(&rest.translation.to_array()));
    }
    if rest.rotation != identity.rotation {
        set(node, "rotation", shorts(&rest.rotation.to_array()));
    }
    if rest.scale != identity.scale {
        set(node, "scale", shorts(&rest.scale.to_array()));
    }
}

/// Returns an error if the character would result in an invalid file.
fn check(character: &Character) -> Result<(), WriteError> {
    let wrong = |at: String, what: &str| Err(WriteError::mismatch(at, what));
    for (j, joint) in character.skeleton.joints.iter().enumerate() {
        if joint.parent.is_some_and(|parent| parent >= j) {
            return wrong(format!("joint {j}"), "its parent must come before it");
        }
    }
    for (m, material) in character.materials.iter().enumerate() {
        if material.images().any(|i| i >= character.images.len()) {
            return wrong(format!("material {m}"), "its image index is out of range");
        }
    }
    for (m, mesh) in character.meshes.iter().enumerate() {
        let at = format!("mesh {m}");
        check_parts(
            character,
            &mesh.skin,
            &mesh.primitives,
            mesh.morph_weights.len(),
            &at,
        )?;
        for (l, level) in mesh.levels.iter().enumerate() {
            let has_morphs = level.primitives.iter().any(|p| !p.morphs.is_empty());
            let morphs = if has_morphs {
                mesh.morph_weights.len()
            } else {
                0
            };
            let at = format!("mesh {m} level {l}");
            check_parts(character, &level.skin, &level.primitives, morphs, &at)?;
        }
    }
    Ok(())
}

fn check_parts(
    character: &Character,
    skin: &Skin,
    primitives: &[Primitive],
    morphs: usize,
    at: &str,
) -> Result<(), WriteError> {
    let joints = character.skeleton.joints.len();
    let fits = skin.joints.len() == skin.inverse_bind.len() && !skin.joints.is_empty();
    if !fits || skin.joints.iter().any(|&j| j >= joints) {
        let what = "its skin does not match the skeleton";
        return Err(WriteError::mismatch(at, what));
    }
    for (p, primitive) in primitives.iter().enumerate() {
        let at = || format!("{at} primitive {p}");
        super::geometry::check(primitive, (skin.joints.len(), morphs), at)?;
        let materials = character.materials.len();
        if primitive.material.is_some_and(|i| i >= materials) {
            let what = "its material index is out of range";
            return Err(WriteError::mismatch(at(), what));
        }
    }
    Ok(())
}
