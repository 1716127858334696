//! Size of the meshes of a document, in bytes.

use super::document::Document;
use serde_json::Value;
use std::collections::BTreeSet;

impl Document {
    /// Returns the size in bytes of all buffer views that meshes use for attributes, morph targets
    /// and indices, including those of all mesh levels. Each view counts once and in full.
    pub fn mesh_bytes(&self) -> usize {
        let list = |name: &str| self.json.get(name).and_then(Value::as_array);
        let mut accessors = BTreeSet::new();
        for mesh in list("meshes").into_iter().flatten() {
            let primitives = mesh.get("primitives").and_then(Value::as_array);
            for primitive in primitives.into_iter().flatten() {
                accessors_of(primitive, &mut accessors);
            }
        }
        let mut views = BTreeSet::new();
        for accessor in accessors {
            let Some(accessor) = list("accessors").and_then(|all| all.get(accessor)) else {
                continue;
            };
            views.extend(index(accessor, "/bufferView"));
            views.extend(index(accessor, "/sparse/indices/bufferView"));
            views.extend(index(accessor, "/sparse/values/bufferView"));
        }
        let bytes = |view: usize| {
            let view = list("bufferViews")?.get(view)?;
            index(view, "/byteLength")
        };
        views.into_iter().filter_map(bytes).sum()
    }
}

fn accessors_of(primitive: &Value, found: &mut BTreeSet<usize>) {
    let number = |value: &Value| value.as_u64().map(|n| n as usize);
    let targets = primitive.get("targets").and_then(Value::as_array);
    let semantics = primitive
        .get("attributes")
        .into_iter()
        .chain(targets.into_iter().flatten());
    for semantic in semantics.filter_map(Value::as_object) {
        found.extend(semantic.values().filter_map(number));
    }
    found.extend(index(primitive, "/indices"));
    let levels = format!("/extensions/{}/indices", super::extension::CLUSTERED_MESH);
    found.extend(index(primitive, &levels));
}

fn index(value: &Value, pointer: &str) -> Option<usize> {
    value.pointer(pointer)?.as_u64().map(|n| n as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn views_count_once_and_only_for_meshes() {
        let view = |bytes: usize| json!({"buffer": 0, "byteLength": bytes});
        let json = json!({
            "bufferViews": [view(100), view(10), view(1), view(5), view(7)],
            "accessors": [
                {"bufferView": 0}, {"bufferView": 0}, {"bufferView": 1}, {"bufferView": 2},
                {"sparse": {"indices": {"bufferView": 3}, "values": {"bufferView": 4}}},
            ],
            "meshes": [{"primitives": [
                {"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "targets": [{"POSITION": 4}]},
            ]}],
            "animations": [{"samplers": [{"input": 3, "output": 3}]}],
        });
        let document = Document {
            json,
            buffers: Vec::new(),
            pictures: Vec::new(),
        };
        assert_eq!(document.mesh_bytes(), 100 + 10 + 5 + 7);
    }
}
