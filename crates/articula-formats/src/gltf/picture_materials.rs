//! The materials that show each picture at the texture coordinates that a character has.

use super::append::{entries, index};
use super::document::Document;
use super::extension::VARIANTS;
use super::plain_textures::{coordinates, is_reference};
use super::texture_source::sources;
use serde_json::{Value, json};
use std::collections::BTreeSet;

impl Document {
    /// Whether the materials of a primitive vary.
    pub(super) fn has_variants(&self) -> bool {
        let meshes = entries(&self.json, "meshes").iter();
        let mut primitives = meshes.flat_map(|mesh| entries(mesh, "primitives"));
        primitives.any(|p| {
            let extensions = p.get("extensions");
            extensions.is_some_and(|all| all.get(VARIANTS).is_some())
        })
    }

    /// Returns for each picture the materials that use it, if all of them do at the coordinates of their base
    /// colour, which are those of a part of a character. `None` of all others, of pictures that no material
    /// uses, and of all pictures if the materials of a primitive vary.
    pub fn picture_materials(&self) -> Vec<Option<BTreeSet<usize>>> {
        let varies = self.has_variants();
        let mut found = Found {
            textures: entries(&self.json, "textures")
                .iter()
                .map(|texture| sources(texture).collect())
                .collect(),
            materials: vec![BTreeSet::new(); self.count("images")],
            moved: BTreeSet::new(),
        };
        for (m, material) in entries(&self.json, "materials").iter().enumerate() {
            let base = material.pointer("/pbrMetallicRoughness/baseColorTexture");
            let shown = base.map_or((0, json!({})), coordinates);
            found.add(material, m, &shown);
        }
        let moved = found.moved;
        let all = found.materials.into_iter().enumerate();
        all.map(|(i, materials)| {
            let is_known = !varies && !materials.is_empty() && !moved.contains(&i);
            is_known.then_some(materials)
        })
        .collect()
    }
}

struct Found {
    /// The pictures of each texture.
    textures: Vec<Vec<usize>>,
    /// The materials of each picture.
    materials: Vec<BTreeSet<usize>>,
    /// Pictures that are shown at other coordinates.
    moved: BTreeSet<usize>,
}

impl Found {
    /// Adds the references in a value of a material whose base colour has coordinates.
    fn add(&mut self, value: &Value, material: usize, shown: &(u64, Value)) {
        let list = value.as_array().into_iter().flatten();
        list.for_each(|inner| self.add(inner, material, shown));
        for (key, inner) in value.as_object().into_iter().flatten() {
            self.add(inner, material, shown);
            if !is_reference(key, inner) {
                continue;
            }
            let pictures = index(inner, "index").and_then(|i| self.textures.get(i));
            for picture in pictures.into_iter().flatten() {
                if let Some(materials) = self.materials.get_mut(*picture) {
                    materials.insert(material);
                }
                if coordinates(inner) != *shown {
                    self.moved.insert(*picture);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_at_other_coordinates_or_of_varying_materials_are_not_known() {
        let moved = json!({"index": 2, "extensions": {"KHR_texture_transform": {"scale": [2, 2]}}});
        let mut document = Document {
            json: json!({
                "images": [{}, {}, {}, {}, {}],
                "textures": [{"source": 0}, {"source": 1}, {"source": 2}, {"source": 3}],
                "materials": [
                    {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "normalTexture": {"index": 1},
                        "emissiveTexture": moved},
                    {"pbrMetallicRoughness": {"baseColorTexture": {"index": 1, "texCoord": 1}},
                        "occlusionTexture": {"index": 3, "texCoord": 0}},
                ],
                "meshes": [{"primitives": [{"attributes": {}}]}],
            }),
            buffers: Vec::new(),
            pictures: vec![None; 5],
        };
        let of = |materials: &[usize]| Some(materials.iter().copied().collect::<BTreeSet<_>>());
        let found = document.picture_materials();
        assert_eq!(found, [of(&[0]), of(&[0, 1]), None, None, None]);
        document.json["meshes"][0]["primitives"][0]["extensions"] =
            json!({VARIANTS: {"mappings": []}});
        assert_eq!(document.picture_materials(), vec![None; 5]);
    }
}
