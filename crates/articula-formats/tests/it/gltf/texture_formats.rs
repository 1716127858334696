//! Pictures in other formats than PNG and JPEG: the character is read, the picture is kept.

use super::tiny::{Tiny, read};
use crate::cases::case;
use articula_formats::gltf::Document;
use proptest::prelude::*;
use serde_json::{Value, json};

/// First bytes of picture files, and their media types.
const PICTURES: [(&[u8], &str); 4] = [
    (b"RIFF\x0c\0\0\0WEBPVP8L", "image/webp"),
    (b"\0\0\0\x1cftypavif\0\0\0\0", "image/avif"),
    (b"\xabKTX 20\xbb\r\n\x1a\n", "image/ktx2"),
    (b"DDS |\0\0\0", "image/vnd-ms.dds"),
];

#[test]
fn a_required_webp_is_read_and_written_unchanged() {
    let bytes = case("tex_webp_required.glb");
    let file = read(&bytes).unwrap();
    assert_eq!(file.warnings, []);
    let character = &file.value.character;
    assert_eq!(character.skeleton.joints.len(), 21);
    assert_eq!(character.materials[0].base_color_image, Some(0));
    assert_eq!(character.images[0].mime_type, "image/webp");
    let again = read(&file.value.document.write_glb().unwrap()).unwrap();
    assert_eq!(again.value.document.json, file.value.document.json);
    assert_eq!(again.value.character, *character);
}

/// A triangle with a picture that only an extension of its texture names.
fn pictured(name: &str, picture: &[u8], place: &str) -> Tiny {
    let mut tiny = Tiny::skinned();
    let view = tiny.view(picture);
    tiny.json["images"] = json!([{"bufferView": view}]);
    tiny.json["textures"] = json!([{"extensions": {name: {"source": 0}}}]);
    tiny.json[place] = match place {
        "textures" => tiny.json["textures"].clone(),
        _ => json!([{"bufferView": view, "extensions": {name: {}}}]),
    };
    tiny.json["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
    tiny.json["extensionsRequired"] = json!([name]);
    tiny.json["extensionsUsed"] = json!([name]);
    tiny
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn any_required_extension_of_textures_is_read_and_kept(
        author in "[A-Z]{2,5}", kind in "[a-z]{3,8}", picture in 0..4usize, in_image: bool,
        is_named: bool,
    ) {
        let middle = if is_named { "texture_" } else { "" };
        let name = format!("{author}_{middle}{kind}");
        let (head, mime) = PICTURES[picture];
        let place = if in_image { "images" } else { "textures" };
        let tiny = pictured(&name, head, place);
        let file = tiny.read().unwrap();
        let image = &file.value.character.images[0];
        prop_assert_eq!((&image.bytes[..], image.mime_type.as_str()), (head, mime));
        prop_assert_eq!(file.value.character.materials[0].base_color_image, Some(0));
        let written = read(&file.value.document.write_glb().unwrap()).unwrap().value;
        prop_assert_eq!(&written.document.json, &file.value.document.json);
        prop_assert_eq!(written.character, file.value.character);
    }

    #[test]
    fn any_extension_of_anything_else_is_refused(
        author in "[A-Z]{2,5}", kind in "[a-su-z]{3,8}", is_used: bool,
    ) {
        let name = format!("{author}_{kind}");
        let mut tiny = Tiny::skinned();
        tiny.json["extensionsRequired"] = json!([name]);
        if is_used {
            tiny.json["meshes"][0]["primitives"][0]["extensions"] = json!({&name: {}});
            tiny.json["textures"] = json!([{"extensions": {&name: {}}}]);
        }
        let error = tiny.read().unwrap_err().to_string();
        prop_assert!(error.contains(&format!("re-export without {name}")), "{error}");
    }
}

#[test]
fn a_picture_that_can_be_shown_comes_before_one_that_cannot() {
    let mut tiny = pictured("KHR_texture_basisu", PICTURES[2].0, "textures");
    let png = tiny.view(b"\x89PNG");
    let images = tiny.json["images"].as_array_mut().unwrap();
    images.push(json!({"bufferView": png}));
    tiny.json["textures"][0]["source"] = json!(1);
    let shown = |tiny: &Tiny| tiny.read().unwrap().value.character.materials[0].base_color_image;
    assert_eq!(shown(&tiny), Some(1));
    // The texture names the KTX file itself, and an extension the other one.
    tiny.json["textures"][0]["source"] = json!(0);
    tiny.json["textures"][0]["extensions"]["KHR_texture_basisu"]["source"] = json!(1);
    assert_eq!(shown(&tiny), Some(1));
    tiny.json["textures"][0]["extensions"]["KHR_texture_basisu"]["source"] = json!(7);
    assert_eq!(shown(&tiny), Some(0));
}

#[test]
fn a_new_document_names_each_picture_in_the_extension_of_its_format() {
    for (head, mime) in PICTURES {
        let character = pictured("KHR_texture_basisu", head, "textures");
        let character = character.read().unwrap().value.character;
        let document = Document::from_character(&character).unwrap();
        let texture = &document.json["textures"][0];
        let name = match mime {
            "image/webp" => "EXT_texture_webp",
            "image/avif" => "EXT_texture_avif",
            "image/ktx2" => "KHR_texture_basisu",
            _ => "MSFT_texture_dds",
        };
        assert_eq!(texture, &json!({"extensions": {name: {"source": 0}}}));
        assert_eq!(document.json["extensionsRequired"], json!([name]));
        let again = read(&document.write_glb().unwrap()).unwrap().value;
        assert_eq!(again.character.images, character.images);
    }
}

#[test]
fn a_replaced_picture_leaves_no_extension_behind() {
    let mut document = read(&case("tex_webp_required.glb")).unwrap().value.document;
    document.set_pictures(&[(0, b"\x89PNG picture")]).unwrap();
    assert_eq!(document.json["textures"], json!([{"source": 0}]));
    assert_eq!(document.json["images"][0]["mimeType"], "image/png");
    for list in ["extensionsUsed", "extensionsRequired"] {
        assert_eq!(document.json.get(list), None::<&Value>);
    }
}
