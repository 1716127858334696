//! Sizes of the parts of a document in bytes.

use super::append::{entries_mut, index};
use super::container;
use super::document::Document;
use super::prune::each_accessor_reference;
use super::reader::Notes;
use crate::limits::Limits;
use serde::Serialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Sizes of the parts of a document in bytes. Each buffer view counts once.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct BytesByKind {
    /// The JSON document.
    pub json: usize,
    /// Keys of animations.
    pub keys: usize,
    /// Vertices, triangles and bind matrices.
    pub geometry: usize,
    /// Morph targets.
    pub morphs: usize,
    /// Pictures.
    pub textures: usize,
    /// All else, such as prepared data.
    pub other: usize,
}

impl BytesByKind {
    /// The sum.
    pub fn total(&self) -> usize {
        self.json + self.keys + self.geometry + self.morphs + self.textures + self.other
    }

    /// The parts of a GLB, as they are stored. Of bytes that are not a GLB, all are JSON.
    pub fn of_glb(bytes: &[u8]) -> Self {
        let opened = container::open(bytes, &Limits::default(), &mut Notes::default());
        match opened {
            Ok((json, binary)) => Self {
                json: bytes.len() - binary.map_or(0, <[u8]>::len),
                ..of_views(&json)
            },
            Err(_) => Self {
                json: bytes.len(),
                ..Self::default()
            },
        }
    }
}

impl Document {
    /// The parts of the document, without compression.
    pub fn bytes_by_kind(&self) -> BytesByKind {
        let beside = self.pictures.iter().flatten().map(Vec::len);
        let views = of_views(&self.json);
        BytesByKind {
            json: self.json.to_string().len(),
            textures: views.textures + beside.sum::<usize>(),
            ..views
        }
    }
}

fn of_views(json: &Value) -> BytesByKind {
    let list = |key: &str| {
        json.get(key)
            .and_then(Value::as_array)
            .into_iter()
            .flatten()
    };
    let accessors: Vec<&Value> = list("accessors").collect();
    let mut kinds: BTreeMap<usize, fn(&mut BytesByKind) -> &mut usize> = BTreeMap::new();
    for image in list("images") {
        if let Some(view) = index(image, "bufferView") {
            kinds.insert(view, |bytes| &mut bytes.textures);
        }
    }
    let mut put = |mut part: Value, kind: fn(&mut BytesByKind) -> &mut usize| {
        each_accessor_reference(&mut part, &mut |i| {
            let accessor = accessors.get(i);
            let views = [
                "/bufferView",
                "/sparse/indices/bufferView",
                "/sparse/values/bufferView",
            ];
            for view in views
                .iter()
                .filter_map(|at| accessor?.pointer(at)?.as_u64())
            {
                kinds.entry(view as usize).or_insert(kind);
            }
            i
        });
    };
    let part = |key: &str| json!({ key: json.get(key) });
    let mut without_morphs = part("meshes");
    for mesh in entries_mut(&mut without_morphs, "meshes") {
        for primitive in entries_mut(mesh, "primitives") {
            if let Some(primitive) = primitive.as_object_mut() {
                primitive.remove("targets");
            }
        }
    }
    put(without_morphs, |bytes| &mut bytes.geometry);
    // Of meshes only these are left.
    put(part("meshes"), |bytes| &mut bytes.morphs);
    put(part("skins"), |bytes| &mut bytes.geometry);
    put(part("animations"), |bytes| &mut bytes.keys);
    let mut found = BytesByKind::default();
    for (i, view) in entries_mut(&mut json.clone(), "bufferViews")
        .iter()
        .enumerate()
    {
        let extensions = view.get("extensions").and_then(Value::as_object);
        let stored = extensions.into_iter().flatten();
        let stored = stored.filter_map(|(_, e)| index(e, "byteLength")).next();
        let bytes = stored.or_else(|| index(view, "byteLength")).unwrap_or(0);
        match kinds.get(&i) {
            Some(kind) => *kind(&mut found) += bytes,
            None => found.other += bytes,
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_count_by_their_first_use() {
        let view = |bytes: usize| json!({"buffer": 0, "byteLength": bytes});
        let compressed = json!({"byteLength": 400, "extensions":
            {"EXT_meshopt_compression": {"byteLength": 40}}});
        let json = json!({
            "bufferViews": [view(1), compressed, view(100), view(1000), view(10_000), view(5)],
            "accessors": [{"bufferView": 0}, {"bufferView": 1}, {"bufferView": 2}, {"bufferView": 5}],
            "images": [{"bufferView": 3}],
            "meshes": [{"primitives": [
                {"attributes": {"POSITION": 0}, "targets": [{"POSITION": 3}, {"POSITION": 0}]},
            ]}],
            "skins": [{"inverseBindMatrices": 0}],
            "animations": [{"samplers": [{"input": 1, "output": 2}]}],
        });
        let found = of_views(&json);
        let expected = BytesByKind {
            json: 0,
            keys: 140,
            geometry: 1,
            morphs: 5,
            textures: 1000,
            other: 10_000,
        };
        assert_eq!(found, expected);
    }
}
