//! Which materials can be drawn together, with the colour as that of the vertices.

use crate::open::CharacterFile;
use articula_core::source::Material;
use glam::Vec4;
use serde_json::Value;
use std::collections::HashMap;

const VARIANTS: &str = "KHR_materials_variants";

/// For each material of a character, the first from which it differs in name and in red, green and blue of the base
/// colour factor alone. Materials of a file with variants are each their own, since a variant may take one of them away.
pub(super) fn draw_materials(opened: &CharacterFile) -> Vec<usize> {
    let materials = &opened.character().materials;
    let document = opened.gltf().map(|gltf| &gltf.document.json);
    match document.map(|json| (json, json["materials"].as_array())) {
        Some((json, Some(all))) if all.len() == materials.len() => {
            match json["extensions"].get(VARIANTS) {
                Some(_) => (0..materials.len()).collect(),
                None => firsts(all.iter().map(|material| colourless(material).to_string())),
            }
        }
        // A file that is not glTF says no more of a material than is read.
        None => firsts(materials.iter().map(looks)),
        Some(_) => (0..materials.len()).collect(),
    }
}

/// For each of some keys, where it is first.
fn firsts(keys: impl Iterator<Item = String>) -> Vec<usize> {
    let mut first_of = HashMap::new();
    keys.enumerate()
        .map(|(index, key)| *first_of.entry(key).or_insert(index))
        .collect()
}

/// A material of glTF without name and base colour; its alpha stays.
fn colourless(material: &Value) -> Value {
    let mut plain = material.clone();
    if let Some(members) = plain.as_object_mut() {
        members.remove("name");
    }
    let surface = plain.get_mut("pbrMetallicRoughness");
    if let Some(surface) = surface.and_then(Value::as_object_mut) {
        let factor = surface.remove("baseColorFactor");
        let alpha = factor.and_then(|f| f.get(3)?.as_f64()).unwrap_or(1.0);
        surface.insert("alpha".to_owned(), alpha.into());
    }
    plain
}

fn looks(material: &Material) -> String {
    let plain = Material {
        name: String::new(),
        base_color: Vec4::ONE.with_w(material.base_color.w),
        ..material.clone()
    };
    format!("{plain:?}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn of(materials: Value) -> Vec<usize> {
        let all = materials.as_array().unwrap().iter();
        firsts(all.map(|material| colourless(material).to_string()))
    }

    #[test]
    fn materials_of_other_colours_are_drawn_together() {
        let of_color = |name: &str, color: Value| json!({"name": name, "pbrMetallicRoughness": {"baseColorFactor": color, "roughnessFactor": 0.5}});
        let rough = json!({"pbrMetallicRoughness": {"roughnessFactor": 0.9}});
        let both = json!({"pbrMetallicRoughness": {"roughnessFactor": 0.5}, "doubleSided": true});
        let found = of(json!([
            of_color("skin", json!([1, 0.5, 0.5, 1])),
            rough,
            of_color("cloth", json!([0, 0, 1, 1.0])),
            of_color("glass", json!([1, 1, 1, 0.5])),
            both,
            json!({"pbrMetallicRoughness": {"roughnessFactor": 0.5}}),
        ]));
        assert_eq!(found, [0, 1, 0, 3, 4, 0]);
    }

    #[test]
    fn without_a_document_what_is_read_decides() {
        let of = |color: [f32; 4], double_sided| Material {
            base_color: Vec4::from_array(color),
            double_sided,
            ..Material::default()
        };
        let all = [
            of([1.0, 0.0, 0.0, 1.0], false),
            of([0.0, 1.0, 0.0, 1.0], true),
            of([0.0, 0.0, 1.0, 1.0], false),
            of([0.0, 0.0, 1.0, 0.9], false),
        ];
        assert_eq!(firsts(all.iter().map(looks)), [0, 1, 0, 3]);
    }
}
