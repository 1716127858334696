//! Coordinates of the textures of glTF materials, of which a mesh has one set.

use serde_json::{Map, Value};

const TRANSFORM: &str = "KHR_texture_transform";

/// The texture whose coordinates the mesh has.
pub(crate) fn base_texture(material: &Value) -> Option<&Value> {
    const BASES: [&str; 3] = [
        "/pbrMetallicRoughness/baseColorTexture",
        "/extensions/KHR_materials_pbrSpecularGlossiness/diffuseTexture",
        "/emissiveTexture",
    ];
    BASES.iter().find_map(|path| material.pointer(path))
}

/// Set and transform of the coordinates of a texture.
pub(crate) fn coordinates(info: &Value) -> (u64, Map<String, Value>) {
    let mut moved = info["extensions"][TRANSFORM].as_object().cloned();
    let own = moved.as_mut().and_then(|moved| moved.remove("texCoord"));
    let set = own.as_ref().and_then(Value::as_u64);
    let set = set.or(info["texCoord"].as_u64()).unwrap_or(0);
    (set, moved.unwrap_or_default())
}

/// Removes sets and transforms of textures with these coordinates, and textures with others.
pub(crate) fn keep_textures(value: &mut Value, own: &(u64, Map<String, Value>)) {
    if let Value::Array(list) = value {
        list.iter_mut().for_each(|value| keep_textures(value, own));
    }
    let Value::Object(members) = value else {
        return;
    };
    members.retain(|_, member| {
        !member.get("index").is_some_and(Value::is_u64) || coordinates(member) == *own
    });
    for member in members.values_mut() {
        if member.get("index").is_some_and(Value::is_u64)
            && let Value::Object(info) = member
        {
            info.remove("texCoord");
            if let Some(Value::Object(extensions)) = info.get_mut("extensions") {
                extensions.remove(TRANSFORM);
            }
        } else {
            keep_textures(member, own);
        }
    }
}
