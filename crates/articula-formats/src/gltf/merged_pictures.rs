//! Pictures of several materials in one.

use super::append::{entries, entries_mut, index, object, push, set};
use super::document::Document;
use super::plain_textures::{coordinates, is_reference};
use super::prune::{has_unknown_extension, remove, renumbered};
use super::texture_source::sources;
use crate::uri::mime_type;
use crate::written::WriteError;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};

/// Textures that are looked up by the normal: of MToon 1 and of VRM 0.
const BY_NORMAL: [&str; 2] = ["matcapTexture", "_SphereAdd"];

/// The pictures that a material shows.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ShownPictures {
    /// Each with the name of the texture that shows it, as `baseColorTexture`; the first in the alphabet if
    /// several do.
    pub textures: BTreeMap<usize, String>,
    /// Whether some are shown at other coordinates than the first ones as they are, or may be exchanged for others.
    pub varies: bool,
}

impl Document {
    /// Returns for each material the pictures that it shows.
    pub fn shown_pictures(&self) -> Vec<ShownPictures> {
        let varies = self.has_variants();
        let textures = entries(&self.json, "textures");
        let materials = entries(&self.json, "materials").iter().enumerate();
        let shown = materials.map(|(m, material)| {
            let mut found = Found {
                textures,
                shown: ShownPictures {
                    varies,
                    ..ShownPictures::default()
                },
            };
            found.add(material);
            // What VRM 0 names beside glTF.
            let at = format!("/extensions/VRM/materialProperties/{m}/textureProperties");
            let named = self.json.pointer(&at).and_then(Value::as_object);
            for (key, texture) in named.into_iter().flatten() {
                let texture = texture.as_u64().and_then(|i| usize::try_from(i).ok());
                found.add_texture(key, texture);
            }
            found.shown
        });
        shown.collect()
    }

    /// Puts one picture, whose file is given, in the place of several, for each entry: their textures show it,
    /// within its borders, filtered as the first of them. Pictures that nothing shows any more are dropped. Returns the new index of each old
    /// picture, that of the new one for those it stands for.
    ///
    /// # Errors
    /// [`WriteError::Mismatch`] for bytes that are no picture that a texture can have. The document is then
    /// unchanged.
    pub fn merge_pictures(
        &mut self,
        merged: &[(BTreeSet<usize>, &[u8])],
    ) -> Result<Vec<usize>, WriteError> {
        let mut types = Vec::with_capacity(merged.len());
        for (_, bytes) in merged {
            let mime = mime_type("", bytes);
            if mime.is_empty() {
                let what = "the bytes are not PNG, JPEG, WebP, AVIF, KTX 2 or DDS";
                return Err(WriteError::mismatch("images", what));
            }
            types.push(mime);
        }
        let mut new_index: Vec<usize> = (0..self.count("images")).collect();
        self.pictures.resize(new_index.len(), None);
        let mut gone = BTreeSet::new();
        for ((old, bytes), mime) in merged.iter().zip(types) {
            let view = self.add_buffer_view(bytes);
            let image = json!({"bufferView": view, "mimeType": mime, "name": "atlas"});
            let picture = push(&mut self.json, "images", image);
            self.pictures.push(None);
            let mut sampler = self.sampler_of(old);
            for wrap in ["wrapS", "wrapT"] {
                // Clamped to the edge.
                set(&mut sampler, wrap, 33071);
            }
            let sampler = push(&mut self.json, "samplers", sampler);
            for texture in entries_mut(&mut self.json, "textures") {
                if sources(texture).any(|source| old.contains(&source)) {
                    let texture = object(texture);
                    texture.shift_remove("extensions");
                    texture.insert("source".to_owned(), picture.into());
                    texture.insert("sampler".to_owned(), sampler.into());
                }
            }
            self.retype_picture(picture, &mime);
            for picture_of_old in old {
                if let Some(new) = new_index.get_mut(*picture_of_old) {
                    *new = picture;
                }
            }
            gone.extend(old.iter().copied());
        }
        let dropped = self.drop_pictures(gone);
        let new = renumbered(&dropped);
        Ok(new_index.into_iter().map(new).collect())
    }

    /// The sampler of the first texture of some pictures; an empty one if it has none.
    fn sampler_of(&self, pictures: &BTreeSet<usize>) -> Value {
        let mut textures = entries(&self.json, "textures").iter();
        let shows = |texture: &&Value| sources(texture).any(|source| pictures.contains(&source));
        let sampler = textures.find(shows).and_then(|of| index(of, "sampler"));
        let sampler = sampler.and_then(|i| entries(&self.json, "samplers").get(i));
        sampler.cloned().unwrap_or(json!({}))
    }

    /// Drops those pictures that nothing names any more; returns which.
    fn drop_pictures(&mut self, mut gone: BTreeSet<usize>) -> BTreeSet<usize> {
        if has_unknown_extension(&self.json) {
            return BTreeSet::new();
        }
        for texture in entries(&self.json, "textures") {
            for source in sources(texture) {
                gone.remove(&source);
            }
        }
        const THUMBNAIL: &str = "/extensions/VRMC_vrm/meta";
        let meta = self.json.pointer(THUMBNAIL);
        if let Some(thumbnail) = meta.and_then(|meta| index(meta, "thumbnailImage")) {
            gone.remove(&thumbnail);
        }
        let removed = remove(&mut self.json, "images", &gone);
        let new = renumbered(&gone);
        let mut i = 0;
        self.pictures.retain(|_| {
            i += 1;
            !gone.contains(&(i - 1))
        });
        for texture in entries_mut(&mut self.json, "textures") {
            rename(texture, "source", &new);
            let extensions = texture.get_mut("extensions").and_then(Value::as_object_mut);
            for extension in extensions.into_iter().flat_map(|all| all.values_mut()) {
                rename(extension, "source", &new);
            }
        }
        if let Some(meta) = self.json.pointer_mut(THUMBNAIL) {
            rename(meta, "thumbnailImage", &new);
        }
        let views = removed
            .iter()
            .filter_map(|image| index(image, "bufferView"));
        self.drop_unused_views(views.collect());
        gone
    }
}

struct Found<'a> {
    textures: &'a [Value],
    shown: ShownPictures,
}

impl Found<'_> {
    /// Adds the references in a value of the material.
    fn add(&mut self, value: &Value) {
        let list = value.as_array().into_iter().flatten();
        list.for_each(|inner| self.add(inner));
        for (key, inner) in value.as_object().into_iter().flatten() {
            self.add(inner);
            if is_reference(key, inner) {
                self.shown.varies |= coordinates(inner) != (0, json!({}));
                self.add_texture(key, index(inner, "index"));
            }
        }
    }

    fn add_texture(&mut self, key: &str, texture: Option<usize>) {
        let texture = texture.and_then(|i| self.textures.get(i));
        self.shown.varies |= texture.is_some() && BY_NORMAL.contains(&key);
        for picture in texture.into_iter().flat_map(sources) {
            let names = &mut self.shown.textures;
            let name = names.entry(picture).or_insert_with(|| key.to_owned());
            if key < name.as_str() {
                key.clone_into(name);
            }
        }
    }
}

fn rename(owner: &mut Value, key: &str, new: &impl Fn(usize) -> usize) {
    if let Some(old) = index(owner, key) {
        set(owner, key, new(old));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document() -> Document {
        let other = json!({"index": 2, "texCoord": 1});
        Document {
            json: json!({
                "images": [{"name": "a"}, {"name": "b"}, {"name": "c"}, {"name": "d"}],
                "textures": [
                    {"source": 0, "sampler": 0},
                    {"source": 1, "extensions": {"EXT_texture_webp": {"source": 3}}},
                    {"source": 2},
                ],
                "samplers": [{"magFilter": 9728, "wrapS": 33648}],
                "extensionsUsed": ["EXT_texture_webp"],
                "materials": [
                    {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "emissiveTexture": {"index": 0}},
                    {"pbrMetallicRoughness": {"baseColorTexture": {"index": 1}}},
                    {"pbrMetallicRoughness": {"baseColorTexture": {"index": 2}}, "normalTexture": other},
                    {"extensions": {"VRMC_materials_mtoon": {"matcapTexture": {"index": 0}}}},
                ],
                "extensions": {
                    "VRM": {"materialProperties": [{}, {"textureProperties": {"_MainTex": 1, "_ShadeTexture": 0}}]},
                    "VRMC_vrm": {"meta": {"thumbnailImage": 2}},
                },
            }),
            buffers: Vec::new(),
            pictures: vec![None; 4],
        }
    }

    #[test]
    fn materials_show_pictures_by_all_their_textures() {
        let of = |textures: &[(usize, &str)], varies| ShownPictures {
            textures: textures
                .iter()
                .map(|(i, name)| (*i, (*name).to_owned()))
                .collect(),
            varies,
        };
        assert_eq!(
            document().shown_pictures(),
            [
                of(&[(0, "baseColorTexture")], false),
                of(
                    &[(0, "_ShadeTexture"), (1, "_MainTex"), (3, "_MainTex")],
                    false
                ),
                of(&[(2, "baseColorTexture")], true),
                of(&[(0, "matcapTexture")], true),
            ]
        );
    }

    #[test]
    fn other_coordinates_vary() {
        let mut document = document();
        let base = &mut document.json["materials"][1]["pbrMetallicRoughness"]["baseColorTexture"];
        base["extensions"] = json!({"KHR_texture_transform": {"scale": [2, 2]}});
        assert!(document.shown_pictures()[1].varies);
        let base = &mut document.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
        base["texCoord"] = json!(1);
        assert!(document.shown_pictures()[0].varies);
    }

    #[test]
    fn a_picture_takes_the_place_of_several() {
        let mut document = document();
        let png = b"\x89PNG\r\n\x1a\n rest";
        let old = BTreeSet::from([0, 1, 3]);
        let new = document.merge_pictures(&[(old, png)]).unwrap();
        assert_eq!(new, [1, 1, 0, 1]);
        let names = document.json["images"].as_array().unwrap();
        let names: Vec<&Value> = names.iter().map(|image| &image["name"]).collect();
        assert_eq!(names, ["c", "atlas"]);
        assert_eq!(document.pictures.len(), 2);
        let merged = json!({"source": 1, "sampler": 1});
        let textures = json!([merged, merged, {"source": 0}]);
        assert_eq!(document.json["textures"], textures);
        let sampler = json!({"magFilter": 9728, "wrapS": 33071, "wrapT": 33071});
        assert_eq!(document.json["samplers"][1], sampler);
        let meta = &document.json["extensions"]["VRMC_vrm"]["meta"];
        assert_eq!(meta["thumbnailImage"], 0);
        assert_eq!(document.json.get("extensionsUsed"), None);
    }

    #[test]
    fn bytes_that_are_no_picture_change_nothing() {
        let mut document = document();
        let before = document.json.clone();
        let old = BTreeSet::from([0]);
        assert!(document.merge_pictures(&[(old, b"text")]).is_err());
        assert_eq!(document.json, before);
    }
}
