//! Materials of a file as JSON, in the form of glTF.

use articula::Figure;
use articula::core::source::Material;
use serde_json::{Map, Value, json};

const TRANSFORM: &str = "KHR_texture_transform";

/// Materials, textures and pictures of a figure's file.
pub(crate) fn materials(figure: &Figure) -> Value {
    let character = figure.opened.character();
    let images = character.images.iter();
    let images: Vec<Value> = images
        .map(|image| json!({"name": image.name, "mimeType": image.mime_type}))
        .collect();
    let (materials, textures) = match figure.opened.gltf() {
        Some(gltf) => of_document(&gltf.document.json),
        None => of_character(&character.materials),
    };
    json!({"materials": materials, "textures": textures, "images": images})
}

fn of_document(json: &Value) -> (Vec<Value>, Vec<Value>) {
    let list = |name: &str| json[name].as_array().map_or(&[][..], Vec::as_slice);
    let samplers = list("samplers");
    let textures = list("textures").iter().map(|texture| {
        let sampler = texture["sampler"].as_u64();
        let sampler = sampler.and_then(|s| samplers.get(usize::try_from(s).ok()?));
        let mut found = Map::new();
        if let Some(image) = image_of(texture) {
            found.insert("image".to_owned(), image.clone());
        }
        found.insert("sampler".to_owned(), sampler.cloned().unwrap_or(json!({})));
        Value::Object(found)
    });
    let materials = list("materials").iter().map(|material| {
        let own = base_texture(material).map(coordinates).unwrap_or_default();
        let mut plain = material.clone();
        keep_textures(&mut plain, &own);
        plain
    });
    (materials.collect(), textures.collect())
}

/// The picture of a texture: its own, or that of an extension for another format.
fn image_of(texture: &Value) -> Option<&Value> {
    let extensions = texture["extensions"].as_object();
    let others = extensions.into_iter().flat_map(|all| all.values());
    let own = texture.get("source");
    own.or_else(|| {
        others
            .filter_map(|extension| extension.get("source"))
            .next()
    })
}

/// The texture whose coordinates the mesh has.
fn base_texture(material: &Value) -> Option<&Value> {
    const BASES: [&str; 3] = [
        "/pbrMetallicRoughness/baseColorTexture",
        "/extensions/KHR_materials_pbrSpecularGlossiness/diffuseTexture",
        "/emissiveTexture",
    ];
    BASES.iter().find_map(|path| material.pointer(path))
}

/// Set and transform of the coordinates of a texture.
fn coordinates(info: &Value) -> (u64, Map<String, Value>) {
    let mut moved = info["extensions"][TRANSFORM].as_object().cloned();
    let own = moved.as_mut().and_then(|moved| moved.remove("texCoord"));
    let set = own.as_ref().and_then(Value::as_u64);
    let set = set.or(info["texCoord"].as_u64()).unwrap_or(0);
    (set, moved.unwrap_or_default())
}

/// Removes sets and transforms of textures with these coordinates, and textures with others.
fn keep_textures(value: &mut Value, own: &(u64, Map<String, Value>)) {
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

/// Materials of a file that is not glTF, of which colours and pictures are known. A texture stands for each picture
/// of a material.
fn of_character(materials: &[Material]) -> (Vec<Value>, Vec<Value>) {
    let mut textures = Vec::new();
    let mut texture = |image: Option<usize>| {
        image.map(|image| {
            textures.push(json!({"image": image, "sampler": {}}));
            json!({"index": textures.len() - 1})
        })
    };
    let made = materials.iter().map(|material| {
        let mut surface = json!({
            "baseColorFactor": material.base_color.to_array(),
            "metallicFactor": 0.0,
            "roughnessFactor": 1.0,
        });
        let mut made = json!({
            "name": material.name,
            "doubleSided": material.double_sided,
            "emissiveFactor": material.emissive.min(articula::glam::Vec3::ONE).to_array(),
            "alphaMode": match material {
                _ if material.blends => "BLEND",
                _ if material.alpha_cutoff > 0.0 => "MASK",
                _ => "OPAQUE",
            },
        });
        if material.alpha_cutoff > 0.0 && !material.blends {
            made["alphaCutoff"] = material.alpha_cutoff.into();
        }
        if let Some(info) = texture(material.base_color_image) {
            surface["baseColorTexture"] = info;
        }
        if let Some(info) = texture(material.emissive_image) {
            made["emissiveTexture"] = info;
        }
        made["pbrMetallicRoughness"] = surface;
        if material.unlit {
            made["extensions"] = json!({"KHR_materials_unlit": {}});
        }
        made
    });
    (made.collect(), textures)
}
