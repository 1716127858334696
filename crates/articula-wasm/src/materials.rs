//! Materials of a file as JSON, in the form of glTF.

use crate::texture_coordinates::{base_texture, coordinates, keep_textures};
use crate::variants::variants;
use articula::Figure;
use articula::core::source::Material;
use serde_json::{Map, Value, json};

/// Materials, textures and pictures of a figure's file.
pub(crate) fn materials(figure: &Figure) -> Value {
    let character = figure.opened.character();
    let images = character.images.iter();
    let images: Vec<Value> = images
        .map(|image| json!({"name": image.name, "mimeType": image.mime_type}))
        .collect();
    let document = figure.opened.gltf().map(|gltf| &gltf.document.json);
    let (materials, textures) = match document {
        Some(json) => of_document(json),
        None => of_character(&character.materials),
    };
    let variants = document.map(variants).unwrap_or_default();
    json!({"materials": materials, "textures": textures, "images": images, "variants": variants})
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
