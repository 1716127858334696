//! Variants of a file's materials, by `KHR_materials_variants`, as they change materials.

use crate::texture_coordinates::{base_texture, coordinates};
use serde_json::{Value, json};
use std::collections::BTreeMap;

const VARIANTS: &str = "KHR_materials_variants";

/// The material of parts without one.
const NONE: i64 = -1;

/// Variants of a glTF document: `{"name", "materials": [[usual, shown], …], "mixed": [usual, …]}`. Parts of one
/// usual material are drawn together, so all of them show what its first part does; those that ask for another one, or for one with other texture
/// coordinates than the mesh has, are mixed.
pub(crate) fn variants(document: &Value) -> Vec<Value> {
    let names = list(&document["extensions"][VARIANTS]["variants"]).iter();
    let parts: Vec<&Value> = list(&document["meshes"])
        .iter()
        .flat_map(|mesh| list(&mesh["primitives"]))
        .collect();
    let materials = list(&document["materials"]);
    let of_variant = |(variant, entry): (usize, &Value)| {
        let (changed, mixed) = changes(&parts, materials, variant);
        json!({"name": entry["name"], "materials": changed, "mixed": mixed})
    };
    names.enumerate().map(of_variant).collect()
}

/// What a variant shows in place of each material that it changes, and the materials that are mixed.
fn changes(parts: &[&Value], materials: &[Value], variant: usize) -> (Vec<[i64; 2]>, Vec<i64>) {
    let mut shown = BTreeMap::new();
    let mut mixed = Vec::new();
    for part in parts {
        let usual = part["material"].as_i64().unwrap_or(NONE);
        let wanted = mapped(part, variant).unwrap_or(usual);
        let fits = has_same_coordinates(materials, usual, wanted);
        let first = *shown
            .entry(usual)
            .or_insert(if fits { wanted } else { usual });
        if first != wanted && !mixed.contains(&usual) {
            mixed.push(usual);
        }
    }
    let changed = shown.into_iter().filter(|(usual, shown)| usual != shown);
    (
        changed.map(|(usual, shown)| [usual, shown]).collect(),
        mixed,
    )
}

/// The material that a variant maps a part to.
fn mapped(part: &Value, variant: usize) -> Option<i64> {
    let mappings = list(&part["extensions"][VARIANTS]["mappings"]).iter();
    let is_of = |mapping: &&Value| {
        let mut of = list(&mapping["variants"]).iter();
        of.any(|index| index.as_u64() == Some(variant as u64))
    };
    mappings.filter(is_of).find_map(|m| m["material"].as_i64())
}

/// Whether a material can be shown on a mesh with the texture coordinates of another one.
fn has_same_coordinates(materials: &[Value], usual: i64, wanted: i64) -> bool {
    let of = |index: i64| materials.get(usize::try_from(index).ok()?);
    let texture = |index| of(index).and_then(base_texture).map(coordinates);
    match (texture(usual), texture(wanted)) {
        (_, None) => true,
        (usual, Some(wanted)) => usual.unwrap_or_default() == wanted,
    }
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}
