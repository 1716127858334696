//! All attribute encodings of KHR_mesh_quantization, with values computed by hand.

use super::tiny::Tiny;
use articula_core::source::Primitive;
use glam::{Vec2, Vec3};
use serde_json::json;

const BYTE: u32 = 5120;
const UBYTE: u32 = 5121;
const SHORT: u32 = 5122;
const USHORT: u32 = 5123;

/// Component type, whether normalised, and the float for a stored 100 and a stored -100 (or, if
/// unsigned, the same bits).
type Store = (u32, bool, [f32; 2]);

/// Encodings of positions and texture coordinates.
const ALL: [Store; 8] = [
    (BYTE, false, [100.0, -100.0]),
    (BYTE, true, [100.0 / 127.0, -100.0 / 127.0]),
    (UBYTE, false, [100.0, 156.0]),
    (UBYTE, true, [100.0 / 255.0, 156.0 / 255.0]),
    (SHORT, false, [100.0, -100.0]),
    (SHORT, true, [100.0 / 32767.0, -100.0 / 32767.0]),
    (USHORT, false, [100.0, 65436.0]),
    (USHORT, true, [100.0 / 65535.0, 65436.0 / 65535.0]),
];

/// Stores elements of `width` numbers, each padded to four bytes as the format requires.
fn store(
    tiny: &mut Tiny,
    kind: &str,
    (component, normalized, _): Store,
    elements: &[&[i32]],
) -> usize {
    let mut bytes = Vec::new();
    for element in elements {
        for number in *element {
            let stored = number.to_le_bytes();
            let size = if component <= UBYTE { 1 } else { 2 };
            bytes.extend_from_slice(&stored[..size]);
        }
        bytes.resize(bytes.len().next_multiple_of(4), 0xEE);
    }
    let stride = bytes.len() / elements.len();
    let view = tiny.view(&bytes);
    tiny.json["bufferViews"][view]["byteStride"] = json!(stride);
    tiny.accessor(json!({"bufferView": view, "componentType": component,
        "normalized": normalized, "count": elements.len(), "type": kind}))
}

fn triangle() -> Tiny {
    let mut tiny = Tiny::skinned();
    tiny.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    tiny.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    tiny
}

fn attribute(tiny: &mut Tiny, name: &str, accessor: usize) {
    tiny.json["meshes"][0]["primitives"][0]["attributes"][name] = json!(accessor);
}

fn primitive(tiny: &Tiny) -> Primitive {
    let file = tiny.read().unwrap();
    assert_eq!(file.warnings, []);
    file.value.character.meshes[0].primitives[0].clone()
}

#[test]
fn positions() {
    for kind in ALL {
        let mut tiny = triangle();
        let corners: [&[i32]; 3] = [&[0, 0, 100], &[100, -100, 0], &[-100, 0, 0]];
        let accessor = store(&mut tiny, "VEC3", kind, &corners);
        attribute(&mut tiny, "POSITION", accessor);
        let [plus, minus] = kind.2;
        let wanted = [
            Vec3::new(0.0, 0.0, plus),
            Vec3::new(plus, minus, 0.0),
            Vec3::new(minus, 0.0, 0.0),
        ];
        assert_eq!(primitive(&tiny).positions, wanted, "{kind:?}");
    }
}

#[test]
fn the_least_signed_number_is_the_same_as_the_next() {
    for (component, least) in [(BYTE, -128), (SHORT, -32768)] {
        let mut tiny = triangle();
        let corners: [&[i32]; 3] = [&[least, 0, 0], &[least + 1, 0, 0], &[0, 1, 0]];
        let accessor = store(&mut tiny, "VEC3", (component, true, [0.0; 2]), &corners);
        attribute(&mut tiny, "POSITION", accessor);
        let positions = primitive(&tiny).positions;
        assert_eq!(positions[..2], [Vec3::NEG_X, Vec3::NEG_X]);
    }
}

#[test]
fn texture_coordinates_with_the_transform_that_makes_them_whole() {
    for kind in ALL {
        let mut tiny = triangle();
        let corners: [&[i32]; 3] = [&[0, 0], &[100, 0], &[0, -100]];
        let accessor = store(&mut tiny, "VEC2", kind, &corners);
        attribute(&mut tiny, "TEXCOORD_1", accessor);
        tiny.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        let picture = tiny.view(b"\x89PNG");
        tiny.json["images"] = json!([{"bufferView": picture}]);
        tiny.json["textures"] = json!([{"source": 0}]);
        let material = |transform| {
            json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": 7,
                "extensions": {"KHR_texture_transform": transform}}}}])
        };
        let [plus, minus] = kind.2;
        tiny.json["materials"] = material(json!({"texCoord": 1}));
        let stored = [Vec2::ZERO, Vec2::new(plus, 0.0), Vec2::new(0.0, minus)];
        assert_eq!(primitive(&tiny).texcoords, stored, "{kind:?}");
        // Powers of two, so that values computed by hand match bit for bit.
        tiny.json["materials"] =
            material(json!({"texCoord": 1, "scale": [0.5, 2], "offset": [8, 0]}));
        let wanted = stored.map(|t| Vec2::new(t.x * 0.5 + 8.0, t.y * 2.0));
        assert_eq!(primitive(&tiny).texcoords, wanted, "{kind:?}");
    }
}

#[test]
fn normals_are_made_unit_and_tangents_do_no_harm() {
    for (component, one) in [(BYTE, 127), (SHORT, 32767)] {
        let kind = (component, true, [0.0; 2]);
        let mut tiny = triangle();
        let half = one / 2;
        let normals: [&[i32]; 3] = [&[0, -one, 0], &[half, half, 0], &[0, 0, one]];
        let accessor = store(&mut tiny, "VEC3", kind, &normals);
        attribute(&mut tiny, "NORMAL", accessor);
        let tangents: [&[i32]; 3] = [&[one, 0, 0, one], &[one, 0, 0, -one], &[one, 0, 0, one]];
        let accessor = store(&mut tiny, "VEC4", kind, &tangents);
        attribute(&mut tiny, "TANGENT", accessor);
        let normals = primitive(&tiny).normals;
        assert_eq!([normals[0], normals[2]], [Vec3::NEG_Y, Vec3::Z]);
        let diagonal = Vec3::new(1.0, 1.0, 0.0).normalize();
        assert!(normals[1].distance(diagonal) < 1e-6, "{}", normals[1]);
    }
}

#[test]
fn morph_targets() {
    for kind in ALL.into_iter().filter(|(c, ..)| [BYTE, SHORT].contains(c)) {
        let mut tiny = triangle();
        let offsets: [&[i32]; 3] = [&[0, 0, 0], &[100, 0, -100], &[0, 100, 0]];
        let positions = store(&mut tiny, "VEC3", kind, &offsets);
        let mut target = json!({"POSITION": positions});
        if kind.1 {
            target["NORMAL"] = json!(store(&mut tiny, "VEC3", kind, &offsets));
            target["TANGENT"] = json!(store(&mut tiny, "VEC3", kind, &offsets));
        }
        tiny.json["meshes"][0]["primitives"][0]["targets"] = json!([target]);
        let [plus, minus] = kind.2;
        let wanted = [
            Vec3::ZERO,
            Vec3::new(plus, 0.0, minus),
            Vec3::new(0.0, plus, 0.0),
        ];
        let morph = &primitive(&tiny).morphs[0];
        assert_eq!(morph.positions, wanted, "{kind:?}");
        // Differences of normals are not unit vectors, and stay as they are.
        let normals = if kind.1 { &wanted[..] } else { &[] };
        assert_eq!(morph.normals, normals, "{kind:?}");
    }
}

#[test]
fn what_makes_positions_whole_again_is_in_node_and_skin() {
    // Without skin, in the node: 100 stored units are 1 m, 2 m up.
    let mut tiny = Tiny::triangle();
    let corners: [&[i32]; 3] = [&[0, 0, 0], &[100, 0, 0], &[0, 100, 0]];
    let accessor = store(&mut tiny, "VEC3", (SHORT, false, [0.0; 2]), &corners);
    attribute(&mut tiny, "POSITION", accessor);
    tiny.json["nodes"] =
        json!([{"mesh": 0, "scale": [0.01, 0.01, 0.01], "translation": [0, 2, 0]}]);
    let character = tiny.read().unwrap().value.character;
    let joint = character.skeleton.joints[character.meshes[0].skin.joints[0]].rest;
    let corner = character.meshes[0].primitives[0].positions[1];
    let placed = joint.to_affine().transform_point3(corner);
    assert!(placed.distance(Vec3::new(1.0, 2.0, 0.0)) < 1e-6, "{placed}");
    // With a skin, in its inverse bind matrices.
    let mut tiny = triangle();
    let accessor = store(&mut tiny, "VEC3", (SHORT, false, [0.0; 2]), &corners);
    attribute(&mut tiny, "POSITION", accessor);
    let mut matrix = [0.0f32; 16];
    [matrix[0], matrix[5], matrix[10], matrix[15]] = [0.01, 0.01, 0.01, 1.0];
    let matrices = tiny.floats("MAT4", &matrix.repeat(2));
    tiny.json["skins"][0]["inverseBindMatrices"] = json!(matrices);
    let character = tiny.read().unwrap().value.character;
    let mesh = &character.meshes[0];
    let placed = mesh.skin.inverse_bind[0].transform_point3(mesh.primitives[0].positions[1]);
    assert!(placed.distance(Vec3::X) < 1e-6, "{placed}");
}
