//! The picture of a texture: named by the texture itself, or by an extension for another picture
//! format.
//!
//! Source: glTF 2.0, 5.29; `EXT_texture_webp`, `EXT_texture_avif`, `KHR_texture_basisu` and
//! `MSFT_texture_dds`, which all hold a `source` as the texture does.

use super::append::{entries_mut, index, object, push, set};
use super::compression::take_extension;
use super::document::Document;
use serde_json::{Value, json};

/// Extensions of textures, and the media type of their pictures.
const FORMATS: [(&str, &str); 4] = [
    ("EXT_texture_webp", "image/webp"),
    ("EXT_texture_avif", "image/avif"),
    ("KHR_texture_basisu", "image/ktx2"),
    ("MSFT_texture_dds", "image/vnd-ms.dds"),
];

/// Media types of pictures that a texture names itself.
const OWN: [&str; 2] = ["image/png", "image/jpeg"];

/// Members of a document whose extensions affect textures alone.
const OF_TEXTURES: [&str; 3] = ["textures", "images", "samplers"];

/// Whether all that an extension affects is textures: its name says so, or only textures, images
/// and samplers have it.
pub(super) fn is_of_textures(json: &Value, name: &str) -> bool {
    is_named_for_textures(name) || uses(json, name, false) == Some(true)
}

/// Whether the name of an extension is that of a texture extension, such as `EXT_texture_webp`.
pub(super) fn is_named_for_textures(name: &str) -> bool {
    name.split_once('_')
        .is_some_and(|(_, rest)| rest.starts_with("texture_"))
}

/// Whether all uses of an extension in a value are those of textures; `None` without any.
fn uses(value: &Value, name: &str, in_texture: bool) -> Option<bool> {
    let all = |found: Option<bool>, next: Option<bool>| match (found, next) {
        (Some(a), Some(b)) => Some(a && b),
        (a, b) => a.or(b),
    };
    match value {
        Value::Array(list) => {
            let inner = list.iter().map(|value| uses(value, name, in_texture));
            inner.fold(None, all)
        }
        Value::Object(members) => {
            let own = value.get("extensions").and_then(|e| e.get(name));
            let inner = members.iter().map(|(key, value)| {
                let is_texture = in_texture || OF_TEXTURES.contains(&key.as_str());
                uses(value, name, is_texture)
            });
            inner.fold(own.map(|_| in_texture), all)
        }
        _ => None,
    }
}

/// The pictures that a texture names: its own, then those of its extensions.
pub(super) fn sources(texture: &Value) -> impl Iterator<Item = usize> {
    let extensions = texture.get("extensions").and_then(Value::as_object);
    let others = extensions.into_iter().flat_map(|all| all.values());
    let others = others.filter_map(|extension| index(extension, "source"));
    index(texture, "source").into_iter().chain(others)
}

/// The extension by which a texture names a picture of a media type; `None` for one that needs none,
/// and for an unknown one.
fn extension_for(mime: &str) -> Option<&'static str> {
    let found = FORMATS.iter().find(|(_, of)| *of == mime);
    found.map(|(name, _)| *name)
}

impl Document {
    /// Adds a texture for a picture of a media type and returns its index. A type that glTF has no
    /// texture of is named as its source all the same.
    pub(super) fn add_texture(&mut self, picture: usize, mime: &str) -> usize {
        let mut texture = json!({});
        name_picture(&mut texture, picture, mime);
        let added = push(&mut self.json, "textures", texture);
        self.list_texture_formats();
        added
    }

    /// Lets the textures of a picture name it where its new media type belongs. A texture that has
    /// another picture in that place keeps that one.
    pub(super) fn retype_picture(&mut self, picture: usize, mime: &str) {
        for texture in entries_mut(&mut self.json, "textures") {
            if !sources(texture).any(|source| source == picture) {
                continue;
            }
            if index(texture, "source") == Some(picture) {
                object(texture).shift_remove("source");
            }
            for (name, _) in FORMATS {
                let named = texture.get("extensions").and_then(|e| e.get(name));
                if named.and_then(|e| index(e, "source")) == Some(picture) {
                    take_extension(texture, name);
                }
            }
            name_picture(texture, picture, mime);
        }
        self.list_texture_formats();
    }

    /// Lists the extensions of the known picture formats as used, and as required if a texture has
    /// no other picture; those that no texture has are removed from both lists.
    fn list_texture_formats(&mut self) {
        for (name, _) in FORMATS {
            let textures = entries_mut(&mut self.json, "textures").iter();
            let having =
                textures.filter(|t| t.get("extensions").is_some_and(|e| e.get(name).is_some()));
            let has_other: Vec<bool> = having.map(|t| t.get("source").is_some()).collect();
            if has_other.is_empty() {
                self.disuse_extension(name);
                continue;
            }
            self.use_extension(name);
            if has_other.contains(&false) {
                self.require_extension(name);
            }
        }
    }
}

/// Names a picture in a texture, unless its place is taken.
fn name_picture(texture: &mut Value, picture: usize, mime: &str) {
    let Some(name) = extension_for(mime) else {
        if texture.get("source").is_none() {
            set(texture, "source", picture);
        }
        return;
    };
    let extensions = object(texture)
        .entry("extensions")
        .or_insert_with(|| json!({}));
    if extensions.get(name).is_none() {
        set(extensions, name, json!({"source": picture}));
    }
}

/// Whether a document can have a texture of a media type.
pub(super) fn is_texture_type(mime: &str) -> bool {
    OWN.contains(&mime) || extension_for(mime).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document(json: Value) -> Document {
        Document {
            json,
            buffers: Vec::new(),
            pictures: Vec::new(),
        }
    }

    #[test]
    fn an_extension_of_textures_is_known_by_its_name_or_its_places() {
        for name in ["EXT_texture_webp", "KHR_texture_basisu", "ACME_texture_jxl"] {
            assert!(is_of_textures(&json!({}), name), "{name}");
        }
        let used = json!({
            "textures": [{"extensions": {"ACME_pictures": {"source": 0}}}],
            "images": [{"extensions": {"ACME_pictures": {}, "ACME_both": {}}}],
            "meshes": [{"primitives": [{"extensions": {"ACME_both": {}, "ACME_mesh": {}}}]}],
        });
        assert!(is_of_textures(&used, "ACME_pictures"));
        for name in [
            "ACME_both",
            "ACME_mesh",
            "ACME_absent",
            "ACME_texturelike",
            "texture_x",
        ] {
            assert!(!is_of_textures(&used, name), "{name}");
        }
    }

    #[test]
    fn a_picture_of_another_type_moves_to_the_place_of_that_type() {
        let before = json!({
            "textures": [{"extensions": {"EXT_texture_webp": {"source": 0}}}, {"source": 1}],
            "extensionsUsed": ["EXT_texture_webp"],
            "extensionsRequired": ["EXT_texture_webp"],
        });
        let mut moved = document(before.clone());
        moved.retype_picture(0, "image/png");
        let plain = json!({"textures": [{"source": 0}, {"source": 1}]});
        assert_eq!(moved.json, plain);
        moved.retype_picture(0, "image/webp");
        assert_eq!(moved.json, before);
    }

    #[test]
    fn a_texture_with_a_picture_of_its_own_requires_nothing() {
        let mut both = document(json!({"textures": [
            {"source": 1, "extensions": {"KHR_texture_basisu": {"source": 0}}},
        ]}));
        both.retype_picture(0, "image/ktx2");
        assert_eq!(both.json["extensionsUsed"], json!(["KHR_texture_basisu"]));
        assert_eq!(both.json.get("extensionsRequired"), None);
        both.retype_picture(0, "image/png");
        assert_eq!(both.json["textures"], json!([{"source": 1}]));
    }
}
