//! Textures that all use the first texture coordinates as they are.
//!
//! A character holds one set of texture coordinates for each part: that of the base colour picture,
//! with its transform applied. A document that gets these coordinates must name neither another set
//! nor a transform.

use super::append::{entries_mut, index, object};
use super::compression::take_extension;
use super::document::Document;
use super::texture_source::sources;
use serde_json::{Value, json};

const TRANSFORM: &str = "KHR_texture_transform";

/// References to textures that hold numbers instead of colours.
const DATA: [&str; 16] = [
    "normalTexture",
    "occlusionTexture",
    "metallicRoughnessTexture",
    "anisotropyTexture",
    "clearcoatTexture",
    "clearcoatRoughnessTexture",
    "clearcoatNormalTexture",
    "diffuseTransmissionTexture",
    "iridescenceTexture",
    "iridescenceThicknessTexture",
    "sheenRoughnessTexture",
    "specularTexture",
    "thicknessTexture",
    "transmissionTexture",
    "shadingShiftTexture",
    "outlineWidthMultiplyTexture",
];

/// What the materials of a document use a picture for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PictureUse {
    /// As colours.
    pub colors: bool,
    /// As normals or other numbers.
    pub numbers: bool,
    /// A texture names another picture beside it, for readers of other formats.
    pub has_alternative: bool,
}

/// Set and transform of a reference to a texture.
pub(super) fn coordinates(info: &Value) -> (u64, Value) {
    let mut transform = info
        .get("extensions")
        .and_then(|e| e.get(TRANSFORM))
        .cloned()
        .unwrap_or(json!({}));
    let own = object(&mut transform).shift_remove("texCoord");
    let own = own.as_ref().and_then(Value::as_u64);
    let set = info.get("texCoord").and_then(Value::as_u64);
    (own.or(set).unwrap_or(0), transform)
}

/// Whether a value is a reference to a texture.
pub(super) fn is_reference(key: &str, value: &Value) -> bool {
    key.ends_with("Texture") && index(value, "index").is_some()
}

impl Document {
    /// Lets all textures of materials use the first texture coordinates without a transform, for
    /// geometry whose coordinates are those of the base colour picture. References to textures with
    /// other coordinates than those of the base colour are removed and described.
    pub fn set_plain_textures(&mut self) -> Vec<String> {
        let mut removed = Vec::new();
        for (m, material) in entries_mut(&mut self.json, "materials")
            .iter_mut()
            .enumerate()
        {
            let base = material
                .get("pbrMetallicRoughness")
                .and_then(|pbr| pbr.get("baseColorTexture"));
            let shown = base.map_or((0, json!({})), coordinates);
            plain(material, &format!("materials[{m}]"), &shown, &mut removed);
        }
        self.disuse_extension(TRANSFORM);
        removed
    }

    /// Returns for each picture whether it holds colours, or is not used: not only normals or other
    /// numbers.
    pub fn pictures_of_colors(&self) -> Vec<bool> {
        let uses = self.picture_uses();
        uses.iter().map(|of| of.colors || !of.numbers).collect()
    }

    /// Returns for each picture what the materials use it for. Extensions outside of materials may use
    /// pictures for more.
    pub fn picture_uses(&self) -> Vec<PictureUse> {
        let mut uses = vec![PictureUse::default(); self.count("images")];
        let textures = self.json.get("textures").and_then(Value::as_array);
        let named: Vec<Vec<usize>> = textures
            .into_iter()
            .flatten()
            .map(|texture| sources(texture).collect())
            .collect();
        for several in named.iter().filter(|named| named.len() > 1) {
            for i in several {
                if let Some(of) = uses.get_mut(*i) {
                    of.has_alternative = true;
                }
            }
        }
        let mut open: Vec<&Value> = self.json.get("materials").into_iter().collect();
        while let Some(value) = open.pop() {
            open.extend(value.as_array().into_iter().flatten());
            for (key, inner) in value.as_object().into_iter().flatten() {
                open.push(inner);
                if !is_reference(key, inner) {
                    continue;
                }
                let texture = index(inner, "index").and_then(|i| named.get(i));
                for i in texture.into_iter().flatten() {
                    if let Some(of) = uses.get_mut(*i) {
                        let is_data = DATA.contains(&key.as_str());
                        *(if is_data {
                            &mut of.numbers
                        } else {
                            &mut of.colors
                        }) = true;
                    }
                }
            }
        }
        uses
    }
}

/// Removes sets and transforms from the references in a value, and references to other coordinates.
fn plain(owner: &mut Value, at: &str, shown: &(u64, Value), removed: &mut Vec<String>) {
    if let Some(list) = owner.as_array_mut() {
        list.iter_mut().for_each(|v| plain(v, at, shown, removed));
        return;
    }
    let Some(members) = owner.as_object_mut() else {
        return;
    };
    members.retain(|key, value| {
        if !is_reference(key, value) {
            plain(value, at, shown, removed);
            return true;
        }
        if coordinates(value) != *shown {
            removed.push(format!(
                "{at}.{key}: uses other texture coordinates than the base colour; left out"
            ));
            return false;
        }
        object(value).shift_remove("texCoord");
        take_extension(value, TRANSFORM);
        true
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_coordinates_go_with_their_textures() {
        let shifted = json!({TRANSFORM: {"offset": [0.5, 0.0], "texCoord": 1}});
        let mut document = Document {
            json: json!({
                "extensionsUsed": [TRANSFORM],
                "images": [{}, {}, {}, {}],
                "textures": [{"source": 3}, {"source": 2}, {"source": 1}],
                "materials": [{
                    "pbrMetallicRoughness": {
                        "baseColorTexture": {"index": 0, "extensions": shifted},
                        "metallicRoughnessTexture": {"index": 2, "extensions": shifted},
                    },
                    "normalTexture": {"index": 1, "texCoord": 1, "scale": 2.0},
                    "extensions": {"KHR_materials_sheen": {
                        "sheenColorTexture": {"index": 0, "texCoord": 7, "extensions": shifted},
                    }},
                }],
            }),
            buffers: Vec::new(),
            pictures: Vec::new(),
        };
        assert_eq!(document.pictures_of_colors(), [true, false, false, true]);
        let unused = PictureUse::default();
        let numbers = PictureUse {
            numbers: true,
            ..unused
        };
        let colors = PictureUse {
            colors: true,
            ..unused
        };
        assert_eq!(document.picture_uses(), [unused, numbers, numbers, colors]);
        let told = document.set_plain_textures();
        assert_eq!(
            told,
            [
                "materials[0].normalTexture: uses other texture coordinates than the base colour; \
              left out"
            ]
        );
        assert_eq!(
            document.json["materials"],
            json!([{
                "pbrMetallicRoughness": {
                    "baseColorTexture": {"index": 0},
                    "metallicRoughnessTexture": {"index": 2},
                },
                "extensions": {"KHR_materials_sheen": {"sheenColorTexture": {"index": 0}}},
            }])
        );
        assert_eq!(document.json.get("extensionsUsed"), None);
    }
}
