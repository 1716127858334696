//! Compressed buffer views: read like uncompressed ones, and written uncompressed.

use super::tiny::{Tiny, read};
use articula_formats::Limits;
use articula_formats::gltf::{self, GltfFile};
use glam::{Vec3, Vec4};
use serde_json::{Value, json};

const EXT: &str = "EXT_meshopt_compression";
const KHR: &str = "KHR_meshopt_compression";

/// Encodes attributes in the simplest form of bitstream v1: one block, every difference as a byte.
fn encoded(elements: &[u8], stride: usize) -> Vec<u8> {
    assert!(elements.len() / stride <= 16, "one block");
    let mut out = vec![0xa1];
    out.resize(1 + stride / 4, 0xff);
    for lane in 0..stride {
        let mut before = 0u8;
        for byte in elements.iter().skip(lane).step_by(stride) {
            let difference = byte.wrapping_sub(before) as i8;
            out.push((difference << 1 ^ difference >> 7) as u8);
            before = *byte;
        }
    }
    let tail = stride + stride / 4;
    out.resize(out.len() + tail.max(24), 0);
    out
}

/// Moves a view's bytes into a compressed form in buffer 0, without an uncompressed copy.
fn compress(tiny: &mut Tiny, name: &str, view: usize, stride: usize, change: Value) {
    let plain = tiny.json["bufferViews"][view].clone();
    let number = |key: &str| plain[key].as_u64().unwrap() as usize;
    let range = number("byteOffset")..number("byteOffset") + number("byteLength");
    let bytes = encoded(&tiny.bytes[range.clone()], stride);
    // Arbitrary bytes replace the uncompressed data, which must not be read.
    tiny.bytes[range].fill(0xEE);
    let count = number("byteLength") / stride;
    let change = merged(
        json!({"mode": "ATTRIBUTES", "count": count, "byteStride": stride}),
        change,
    );
    attach(tiny, name, view, &bytes, change);
}

/// Gives a view a compressed form; the buffer of its uncompressed form has no bytes.
fn attach(tiny: &mut Tiny, name: &str, view: usize, bytes: &[u8], members: Value) {
    let place = tiny.view(bytes);
    let place = tiny.json["bufferViews"]
        .as_array_mut()
        .unwrap()
        .remove(place);
    let plain = &mut tiny.json["bufferViews"][view];
    plain["buffer"] = json!(1);
    plain["extensions"][name] = merged(place, members);
    let length = tiny.bytes.len();
    tiny.json["buffers"] = json!([{"byteLength": length}, {"byteLength": 1 << 20}]);
    tiny.json["extensionsUsed"] = json!([name]);
    tiny.json["extensionsRequired"] = json!([name]);
}

fn merged(mut to: Value, from: Value) -> Value {
    for (key, value) in from.as_object().unwrap() {
        to[key] = value.clone();
    }
    to
}

/// Returns a triangle with indices, in all three modes: attributes, triangles, and sparse indices.
pub(crate) fn every_mode() -> Tiny {
    let mut tiny = Tiny::skinned();
    let indices = tiny.bytes_accessor("SCALAR", 5123, &[0, 0, 1, 0, 2, 0]);
    tiny.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    let at = tiny.view(&[1, 0, 0, 0]);
    let to = tiny.view(&[1.0f32, 0.0, 0.0].map(f32::to_le_bytes).concat());
    tiny.json["accessors"][0]["sparse"] = json!({"count": 1,
        "indices": {"bufferView": at, "componentType": 5125}, "values": {"bufferView": to}});
    compress(&mut tiny, KHR, 0, 12, json!({}));
    compress(&mut tiny, KHR, 1, 4, json!({"filter": "NONE"}));
    compress(&mut tiny, KHR, 2, 16, json!({}));
    // Code 0xf0: three new vertices; the table is that of the format.
    let table = [
        0x00, 0x76, 0x87, 0x56, 0x67, 0x78, 0xa9, 0x86, 0x65, 0x89, 0x68, 0x98, 0x01, 0x69, 0, 0,
    ];
    let triangle = [&[0xe1, 0xf0][..], &table].concat();
    let shape = json!({"mode": "TRIANGLES", "count": 3, "byteStride": 2});
    attach(&mut tiny, KHR, 3, &triangle, shape);
    // One index, one more than 0: zigzag and baseline bit make it 4.
    let shape = json!({"mode": "INDICES", "count": 1, "byteStride": 4});
    attach(&mut tiny, KHR, at, &[0xd1, 4, 0, 0, 0, 0], shape);
    tiny
}

fn one_warning(tiny: &Tiny) -> (GltfFile, String) {
    let file = tiny.read().unwrap();
    assert_eq!(file.warnings.len(), 1, "{:?}", file.warnings);
    (file.value, file.warnings[0].what.clone())
}

#[test]
fn all_modes_are_read_and_written_plain() {
    let tiny = every_mode();
    let (file, warning) = one_warning(&tiny);
    assert_eq!(
        warning,
        "5 buffer views are compressed (KHR_meshopt_compression); they are written uncompressed"
    );
    let plain = Tiny::skinned().read().unwrap().value.character;
    assert_eq!(file.character, plain);
    let json = &file.document.json;
    for gone in ["meshopt", "extensionsUsed", "extensionsRequired"] {
        assert!(!json.to_string().contains(gone), "{gone}: {json}");
    }
    // Five decoded views, each at a multiple of 4; none of the encoded bytes is left.
    let buffers = &file.document.buffers;
    assert_eq!(buffers[1].len(), 36 + 12 + 48 + 8 + 4);
    assert!(!buffers[0].contains(&0xFF), "{:02x?}", buffers[0]);
    let written = file.document.write_glb().unwrap();
    let again = read(&written).unwrap();
    assert_eq!(again.warnings, []);
    assert_eq!(again.value.character, plain);
}

#[test]
fn both_spellings_and_every_way_to_say_where_the_plain_bytes_would_be() {
    let plain = Tiny::skinned().read().unwrap().value.character;
    for name in [EXT, KHR] {
        for placeholder in [
            json!({"byteLength": 36}),
            json!({"byteLength": 36, "extensions": {name: {"fallback": true}}}),
            json!({"byteLength": 36, "uri": "gone.bin", "extensions": {name: {"fallback": true}}}),
            // Not marked as a fallback, but it has no uncompressed data.
            json!({"byteLength": 36, "uri": "gone.bin"}),
        ] {
            let mut tiny = Tiny::skinned();
            compress(&mut tiny, name, 0, 12, json!({}));
            tiny.json["buffers"][1] = placeholder.clone();
            let (file, _) = one_warning(&tiny);
            assert_eq!(file.character, plain, "{placeholder}");
            assert_eq!(file.document.json["buffers"].as_array().unwrap().len(), 2);
            let written = file.document.write_glb().unwrap();
            assert_eq!(read(&written).unwrap().value.character, plain);
        }
    }
}

#[test]
fn a_plain_form_beside_the_compressed_one_goes() {
    let mut tiny = Tiny::skinned();
    let before = tiny.json["bufferViews"][0].clone();
    compress(&mut tiny, EXT, 0, 12, json!({}));
    // The uncompressed form stays in buffer 0, together with views that have no other.
    tiny.json["bufferViews"][0]["buffer"] = before["buffer"].clone();
    tiny.json["buffers"].as_array_mut().unwrap().pop();
    let (file, _) = one_warning(&tiny);
    let plain = Tiny::skinned().read().unwrap().value.character;
    assert_eq!(file.character, plain);
    let buffers = &file.document.buffers;
    assert!(!buffers.concat().contains(&0xEE), "{buffers:02x?}");
    assert_eq!(file.document.json["bufferViews"][0]["buffer"], 1);
}

#[test]
fn filters_and_the_bounds_of_what_they_round() {
    let mut tiny = Tiny::skinned();
    // Mantissa 1 and exponents -1, 0 and 3: 0.5, 1 and 8, with bounds of numbers before rounding.
    let code = |e: i8| [1, 0, 0, e as u8];
    let corners = [[-1, 0, 0], [0, 3, 0], [0, 0, 3]].map(|c| c.map(code).concat());
    let positions = tiny.bytes_accessor("VEC3", 5126, &corners.concat());
    tiny.json["accessors"][positions]["min"] = json!([0.49, 0.99, 0.99]);
    tiny.json["accessors"][positions]["max"] = json!([1.01, 8.01, 8.01]);
    let view = tiny.json["bufferViews"].as_array().unwrap().len() - 1;
    compress(&mut tiny, EXT, view, 12, json!({"filter": "EXPONENTIAL"}));
    let normals = tiny.bytes_accessor("VEC3", 5120, &[127, 0, 127, 0, 127, 127, 0, 127, 127]);
    let bytes = [127, 0, 127, 9, 0, 127, 127, 9, 127, 127, 127, 9];
    let at = tiny.view(&bytes);
    tiny.json["accessors"][normals] = json!({"bufferView": at, "componentType": 5120,
        "normalized": true, "count": 3, "type": "VEC3", "max": [1, 2, 3]});
    tiny.json["bufferViews"][at]["byteStride"] = json!(4);
    compress(&mut tiny, EXT, at, 4, json!({"filter": "OCTAHEDRAL"}));
    let colors = tiny.bytes_accessor("VEC4", 5121, &[32, 63, 0xE0, 0x40].repeat(3));
    tiny.json["accessors"][colors]["normalized"] = json!(true);
    let at = tiny.json["bufferViews"].as_array().unwrap().len() - 1;
    compress(&mut tiny, EXT, at, 4, json!({"filter": "COLOR"}));
    let attributes = &mut tiny.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["POSITION"] = json!(positions);
    attributes["NORMAL"] = json!(normals);
    attributes["COLOR_0"] = json!(colors);
    let (file, _) = one_warning(&tiny);
    let primitive = &file.character.meshes[0].primitives[0];
    assert_eq!(primitive.positions[0], Vec3::new(0.5, 1.0, 1.0));
    assert_eq!(primitive.positions[2], Vec3::new(1.0, 1.0, 8.0));
    assert_eq!(primitive.normals, [Vec3::X, Vec3::Y, Vec3::NEG_Z]);
    assert_eq!(primitive.colors[0], Vec4::new(1.0, 0.0, 2.0 / 255.0, 0.0));
    let accessors = &file.document.json["accessors"];
    assert_eq!(accessors[positions]["min"], json!([0.5, 1.0, 1.0]));
    assert_eq!(accessors[positions]["max"], json!([1.0, 8.0, 8.0]));
    assert_eq!(accessors[normals]["max"], json!([127, 127, 0]));
    assert_eq!(accessors[normals].get("min"), None);
}

/// An invalid change of view 0's extension, and the expected error.
type Case = (&'static str, Value, &'static str);

#[test]
fn hostile_views() {
    let cases: [Case; 12] = [
        ("mode", json!("STRIPS"), "mode: unknown mode"),
        ("mode", json!(null), "mode: unknown mode"),
        ("filter", json!("SHARP"), "filter: unknown filter"),
        ("filter", json!(1), "filter: unknown filter"),
        (
            "filter",
            json!("COLOR"),
            "Color elements cannot have 12 bytes",
        ),
        (
            "count",
            json!(4),
            "4 elements of 12 bytes do not fill the view of 36",
        ),
        ("count", json!(u64::MAX), "do not fill the view of 36"),
        ("byteStride", json!(3), "3 elements of 3 bytes do not fill"),
        ("buffer", json!(7), "buffer: index 7"),
        ("buffer", json!(1), "exceed the buffer of 0"),
        ("byteLength", json!(10), "byte 0: 10 bytes are too short"),
        ("byteOffset", json!(u64::MAX), "exceed the buffer of"),
    ];
    for (key, value, says) in cases {
        let mut tiny = Tiny::skinned();
        compress(&mut tiny, EXT, 0, 12, json!({}));
        tiny.json["bufferViews"][0]["extensions"][EXT][key] = value.clone();
        let error = tiny.read().unwrap_err().to_string();
        let is_placed = error.starts_with("bufferViews[0].extensions.EXT_meshopt_compression");
        assert!(is_placed && error.contains(says), "{key} {value}: {error}");
    }
}

#[test]
fn decoded_bytes_count_against_the_limit() {
    // 1024 constant elements of 256 bytes, 32 per block, each block 64 control bytes: 2 kB for 256
    // kB, and forty views that all use them.
    let bomb = [&[0xa1][..], &[0xaa; 64 * 32], &[0; 256 + 64]].concat();
    let mut tiny = Tiny::new();
    let view = tiny.view(&[]);
    tiny.json["bufferViews"][view]["byteLength"] = json!(1 << 18);
    let shape = json!({"mode": "ATTRIBUTES", "count": 1024, "byteStride": 256});
    attach(&mut tiny, KHR, view, &bomb, shape);
    let view = tiny.json["bufferViews"][view].clone();
    tiny.json["bufferViews"] = json!(vec![view; 40]);
    let file = tiny.glb();
    let mut alone = |_: &str| Err("nothing".to_owned());
    let mut refused = |bytes: u64| {
        let limits = Limits {
            bytes,
            ..Limits::default()
        };
        gltf::read(&file, &limits, &mut alone)
            .err()
            .map(|e| e.to_string())
    };
    assert_eq!(refused(41 << 18), None);
    let error = refused(16 << 18).unwrap();
    assert!(error.starts_with("bufferViews[15].extensions"), "{error}");
    assert!(
        error.contains("bytes of buffers and pictures, the limit is"),
        "{error}"
    );
}

#[test]
fn a_list_of_extensions_keeps_the_other_names() {
    let mut tiny = Tiny::skinned();
    compress(&mut tiny, EXT, 0, 12, json!({}));
    tiny.json["extensionsUsed"] = json!(["KHR_mesh_quantization", EXT, "KHR_materials_unlit"]);
    tiny.json["extensionsRequired"] = json!([EXT, "KHR_mesh_quantization"]);
    let json = one_warning(&tiny).0.document.json;
    assert_eq!(
        json["extensionsUsed"],
        json!(["KHR_mesh_quantization", "KHR_materials_unlit"])
    );
    assert_eq!(json["extensionsRequired"], json!(["KHR_mesh_quantization"]));
}
