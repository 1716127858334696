//! Vertex attributes that no material uses.

use super::append::{entries_mut, index, object};
use super::document::Document;
use serde_json::Value;
use std::collections::BTreeSet;

/// Extensions whose materials take the first texture coordinates without naming them.
const TAKE_FIRST_TEXCOORDS: [&str; 1] = ["VRM"];

impl Document {
    /// Removes texture coordinates that no texture of the primitive's material uses, and tangents of
    /// materials without a normal texture. Custom attributes and colours stay. Primitives whose materials
    /// vary keep all.
    pub fn drop_unused_attributes(&mut self) {
        let takes_first = TAKE_FIRST_TEXCOORDS
            .iter()
            .any(|name| self.json.pointer(&format!("/extensions/{name}")).is_some());
        let materials = self.json.get("materials").and_then(Value::as_array);
        let used: Vec<Used> = materials.into_iter().flatten().map(Used::of).collect();
        let before = self.mesh_accessors();
        for mesh in entries_mut(&mut self.json, "meshes") {
            for primitive in entries_mut(mesh, "primitives") {
                if primitive.get("extensions").is_some() {
                    continue;
                }
                let material = index(primitive, "material").map(|m| used.get(m));
                let used = match material {
                    Some(Some(used)) => used.clone(),
                    // A material that does not exist.
                    Some(None) => continue,
                    None => Used::default(),
                };
                let keeps = |name: &String| match name.strip_prefix("TEXCOORD_") {
                    Some(set) => {
                        let set = set.parse().unwrap_or(usize::MAX);
                        used.sets.contains(&set) || takes_first && set == 0
                    }
                    None => name != "TANGENT" || used.has_normals,
                };
                let mut owners = vec![primitive.get_mut("attributes").map(Value::take)];
                let targets = entries_mut(primitive, "targets").iter_mut();
                owners.extend(targets.map(|target| Some(target.take())));
                for owner in owners.iter_mut().flatten() {
                    object(owner).retain(|name, _| keeps(name));
                }
                let mut owners = owners.into_iter();
                let (attributes, targets) = (owners.next().flatten(), owners.flatten());
                if let (Some(slot), Some(kept)) = (primitive.get_mut("attributes"), attributes) {
                    *slot = kept;
                }
                for (slot, kept) in entries_mut(primitive, "targets").iter_mut().zip(targets) {
                    *slot = kept;
                }
            }
        }
        self.drop_unnamed(before);
    }
}

/// What the textures of a material use.
#[derive(Debug, Clone, Default, PartialEq)]
struct Used {
    /// Sets of texture coordinates.
    sets: BTreeSet<usize>,
    has_normals: bool,
}

impl Used {
    fn of(material: &Value) -> Self {
        let mut used = Self::default();
        used.add(material);
        used
    }

    /// Adds the uses of a value at any depth, those of extensions too. A texture is an object with an
    /// index, whatever the member is called that holds it.
    fn add(&mut self, value: &Value) {
        match value {
            Value::Array(list) => list.iter().for_each(|value| self.add(value)),
            Value::Object(members) => {
                for (name, value) in members {
                    if index(value, "index").is_some() {
                        let set = index(value, "texCoord").unwrap_or(0);
                        let moved = value.pointer("/extensions/KHR_texture_transform");
                        let moved = moved.and_then(|t| index(t, "texCoord"));
                        self.sets.extend([set, moved.unwrap_or(set)]);
                        self.has_normals |= name.to_lowercase().contains("normal");
                    }
                    self.add(value);
                }
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn document(extensions: Value) -> Document {
        let attributes = json!({"POSITION": 0, "TANGENT": 1, "TEXCOORD_0": 2, "TEXCOORD_1": 3,
            "COLOR_0": 4, "_OWN": 5});
        let primitive = |material: Value| {
            json!({"attributes": attributes, "targets": [{"POSITION": 6, "TANGENT": 7}],
                "material": material})
        };
        let json = json!({
            "extensions": extensions,
            "accessors": [{}, {}, {}, {}, {}, {}, {}, {}],
            "meshes": [{"primitives": [primitive(json!(0)), primitive(json!(1)), primitive(json!(2))]}],
            "materials": [
                {"normalTexture": {"index": 0, "texCoord": 1}},
                {"extensions": {"KHR_materials_sheen": {"sheenColorTexture": {"index": 0, "texCoord": 1,
                    "extensions": {"KHR_texture_transform": {"texCoord": 0}}}}}},
                {},
            ],
        });
        Document {
            json,
            buffers: Vec::new(),
            pictures: Vec::new(),
        }
    }

    fn names(document: &Document, primitive: usize) -> Vec<String> {
        let primitive = &document.json["meshes"][0]["primitives"][primitive];
        let members =
            |owner: &Value| -> Vec<String> { owner.as_object().unwrap().keys().cloned().collect() };
        let mut names = members(&primitive["attributes"]);
        names.extend(members(&primitive["targets"][0]));
        names
    }

    #[test]
    fn attributes_without_a_texture_go() {
        let mut document = document(json!({}));
        document.drop_unused_attributes();
        let all = [
            "POSITION",
            "TANGENT",
            "TEXCOORD_1",
            "COLOR_0",
            "_OWN",
            "POSITION",
            "TANGENT",
        ];
        assert_eq!(names(&document, 0), all);
        let moved = [
            "POSITION",
            "TEXCOORD_0",
            "TEXCOORD_1",
            "COLOR_0",
            "_OWN",
            "POSITION",
        ];
        assert_eq!(names(&document, 1), moved);
        assert_eq!(
            names(&document, 2),
            ["POSITION", "COLOR_0", "_OWN", "POSITION"]
        );
    }

    #[test]
    fn materials_of_vrm_take_the_first_texture_coordinates() {
        let mut document = document(json!({"VRM": {}}));
        document.drop_unused_attributes();
        assert!(names(&document, 2).contains(&"TEXCOORD_0".to_owned()));
    }
}
