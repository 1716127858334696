//! Each feature of the format by the smallest file that has it.

use super::tiny::{Tiny, read};
use articula_core::source::{Interpolation, Property};
use articula_formats::gltf::{self, GltfFile};
use articula_formats::{Limits, ReadError};
use glam::{Quat, Vec3, Vec4};
use serde_json::json;

fn good(tiny: &Tiny) -> GltfFile {
    let file = tiny.read().unwrap();
    assert_eq!(file.warnings, []);
    file.value
}

fn one_warning(tiny: &Tiny) -> (GltfFile, String) {
    let file = tiny.read().unwrap();
    assert_eq!(file.warnings.len(), 1, "{:?}", file.warnings);
    let warning = &file.warnings[0];
    (file.value, format!("{}: {}", warning.at, warning.what))
}

fn error(tiny: &Tiny) -> String {
    tiny.read().unwrap_err().to_string()
}

#[test]
fn a_skinned_triangle() {
    let file = good(&Tiny::skinned());
    let character = file.character;
    let joints = &character.skeleton.joints;
    assert_eq!(joints.len(), 2, "a skinned mesh's own node is no joint");
    assert_eq!(
        (joints[1].name.as_str(), joints[1].parent),
        ("chest", Some(0))
    );
    assert_eq!(joints[1].rest.translation, Vec3::Y);
    assert!(joints.iter().all(|j| j.in_skin));
    assert_eq!(file.node_of_joint, [0, 1]);
    assert_eq!(file.node_of_mesh, [2]);
    let mesh = &character.meshes[0];
    assert_eq!(
        (mesh.name.as_str(), &mesh.skin.joints[..]),
        ("body", &[0, 1][..])
    );
    let primitive = &mesh.primitives[0];
    assert_eq!(primitive.triangles, [[0, 1, 2]], "not indexed");
    assert_eq!(primitive.influences, 4);
    assert_eq!(primitive.weights[..4], [0.25, 0.75, 0.0, 0.0]);
    assert_eq!(primitive.joints[8], 1);
}

#[test]
fn a_skinned_mesh_below_a_moved_node_ignores_that_node() {
    let mut tiny = Tiny::skinned();
    tiny.json["nodes"] = json!([
        {"name": "hips", "children": [1]},
        {"name": "chest"},
        {"name": "body", "mesh": 0, "skin": 0},
        {"name": "armature", "translation": [0, 0, 9], "scale": [100, 100, 100],
         "children": [2]},
    ]);
    tiny.json["scenes"][0]["nodes"] = json!([0, 3]);
    let character = good(&tiny).character;
    assert_eq!(character.skeleton.joints.len(), 2);
    assert_eq!(character.meshes[0].skin.joints, [0, 1]);
}

#[test]
fn joints_stand_parents_first_in_document_order_and_the_rest_is_left_out() {
    let mut tiny = Tiny::skinned();
    tiny.json["nodes"] = json!([
        {"name": "leaf"},
        {"name": "camera", "camera": 0},
        {"name": "body", "mesh": 0, "skin": 0},
        {"name": "top", "children": [5, 4, 1]},
        {"name": "left", "children": [0]},
        {"name": "prop", "mesh": 0},
    ]);
    tiny.json["skins"][0]["joints"] = json!([0, 4]);
    tiny.json["scenes"][0]["nodes"] = json!([3, 2]);
    let file = good(&tiny);
    let names: Vec<_> = file
        .character
        .skeleton
        .joints
        .iter()
        .map(|j| &j.name)
        .collect();
    assert_eq!(names, ["top", "prop", "left", "leaf"]);
    let in_skin: Vec<_> = file
        .character
        .skeleton
        .joints
        .iter()
        .map(|j| j.in_skin)
        .collect();
    assert_eq!(in_skin, [false, false, true, true]);
    // Meshes are in the order of their nodes; the prop is rigid on its own joint.
    assert_eq!(file.node_of_mesh, [2, 5]);
    let prop = &file.character.meshes[1];
    assert_eq!(prop.skin.joints, [1]);
    assert_eq!(prop.primitives[0].influences, 1);
    assert_eq!(file.character.meshes[0].skin.joints, [3, 2]);
}

#[test]
fn two_skins_share_one_skeleton() {
    let mut tiny = Tiny::skinned();
    let mut moved = [0.0; 16];
    (0..4).for_each(|i| moved[i * 5] = 1.0);
    moved[12] = -3.0;
    let matrices = tiny.floats("MAT4", &moved);
    tiny.json["skins"]
        .as_array_mut()
        .unwrap()
        .push(json!({"joints": [1], "inverseBindMatrices": matrices}));
    let primitives = tiny.json["meshes"][0]["primitives"].clone();
    tiny.json["meshes"] = json!([{"primitives": primitives}, {"primitives": primitives}]);
    // The second mesh follows the second skin's only joint.
    let zeros = tiny.bytes_accessor("VEC4", 5123, &[0; 24]);
    tiny.json["meshes"][1]["primitives"][0]["attributes"]["JOINTS_0"] = json!(zeros);
    tiny.json["nodes"]
        .as_array_mut()
        .unwrap()
        .push(json!({"mesh": 1, "skin": 1}));
    tiny.json["scenes"][0]["nodes"] = json!([0, 2, 3]);
    let character = good(&tiny).character;
    assert_eq!(character.skeleton.joints.len(), 2);
    let skin = &character.meshes[1].skin;
    assert_eq!(skin.joints, [1]);
    assert_eq!(
        Vec3::from(skin.inverse_bind[0].translation),
        Vec3::NEG_X * 3.0
    );
}

#[test]
fn nodes_outside_every_scene_count_only_for_skins_and_animations() {
    let mut tiny = Tiny::skinned();
    tiny.json["nodes"]
        .as_array_mut()
        .unwrap()
        .push(json!({"mesh": 0}));
    tiny.json["scenes"][0]["nodes"] = json!([2]);
    let (file, warning) = one_warning(&tiny);
    assert_eq!(file.character.skeleton.joints.len(), 2);
    assert_eq!(file.character.meshes.len(), 1);
    assert_eq!(
        warning,
        "nodes[3]: the node is in no scene; its mesh is left out"
    );
}

#[test]
fn sparse_accessors_with_and_without_base() {
    let mut tiny = Tiny::skinned();
    let at = tiny.view(&[1]);
    let to = tiny.view(&5f32.to_le_bytes().repeat(3));
    let sparse = json!({"count": 1,
        "indices": {"bufferView": at, "componentType": 5121}, "values": {"bufferView": to}});
    let bare = json!({"componentType": 5126, "count": 3, "type": "VEC3", "sparse": sparse});
    let bare = tiny.accessor(bare);
    tiny.json["accessors"][0]["sparse"] = sparse;
    tiny.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": bare}]);
    let character = good(&tiny).character;
    let primitive = &character.meshes[0].primitives[0];
    assert_eq!(primitive.positions, [Vec3::ZERO, Vec3::splat(5.0), Vec3::Y]);
    let morph = &primitive.morphs[0].positions;
    assert_eq!(morph[..], [Vec3::ZERO, Vec3::splat(5.0), Vec3::ZERO]);
}

#[test]
fn strides_offsets_and_quantised_attributes() {
    let mut tiny = Tiny::skinned();
    // Positions as 16-bit integers every 8 bytes from byte 2 on; normals as signed bytes.
    let mut bytes = vec![0xEE, 0xEE];
    for corner in [[1i16, 2, 3], [-4, 5, 6], [7, 8, -9]] {
        bytes.extend(corner.iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0xEE, 0xEE]);
    }
    let view = tiny.view(&bytes);
    tiny.json["bufferViews"][view]["byteStride"] = json!(8);
    let positions = tiny.accessor(json!({"bufferView": view, "byteOffset": 2,
        "componentType": 5122, "count": 3, "type": "VEC3"}));
    let normals = tiny.bytes_accessor("VEC3", 5120, &[127, 0, 0, 0, 129, 0, 128, 0, 0]);
    tiny.json["accessors"][normals]["normalized"] = json!(true);
    let colors = tiny.bytes_accessor("VEC4", 5121, &[255, 0, 51, 255].repeat(3));
    tiny.json["accessors"][colors]["normalized"] = json!(true);
    let attributes = &mut tiny.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["POSITION"] = json!(positions);
    attributes["NORMAL"] = json!(normals);
    attributes["COLOR_0"] = json!(colors);
    tiny.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let character = good(&tiny).character;
    let primitive = &character.meshes[0].primitives[0];
    assert_eq!(primitive.positions[1], Vec3::new(-4.0, 5.0, 6.0));
    assert_eq!(primitive.positions[2], Vec3::new(7.0, 8.0, -9.0));
    // 129 is -127, 128 is -128 which counts as -127.
    assert_eq!(primitive.normals, [Vec3::X, Vec3::NEG_Y, Vec3::NEG_X]);
    assert_eq!(primitive.colors[0], Vec4::new(1.0, 0.0, 0.2, 1.0));
}

#[test]
fn weights_are_mended_and_counted() {
    let mut tiny = Tiny::skinned();
    let weights = [1., 1., 0., 0., 0., 0., 0., 0., f32::NAN, 1., -2., 0.];
    let weights = tiny.floats("VEC4", &weights);
    let attributes = &mut tiny.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["WEIGHTS_0"] = json!(weights);
    let file = tiny.read().unwrap();
    let primitive = &file.value.character.meshes[0].primitives[0];
    assert_eq!(primitive.weights[..4], [0.5, 0.5, 0.0, 0.0]);
    assert_eq!(primitive.weights[4..8], [1.0, 0.0, 0.0, 0.0]);
    assert_eq!(primitive.weights[8..], [0.0, 1.0, 0.0, 0.0]);
    let said: Vec<_> = file.warnings.iter().map(|w| w.what.as_str()).collect();
    assert_eq!(
        said,
        [
            "2 weights are negative or NaN; read as 0",
            "the weights of 1 of 3 vertices do not sum to 1; normalised",
            "1 vertices have no weight; bound to the first joint",
        ]
    );
}

#[test]
fn eight_influences() {
    let mut tiny = Tiny::skinned();
    let attributes = tiny.json["meshes"][0]["primitives"][0]["attributes"].clone();
    let half = tiny.floats("VEC4", &[0.5, 0., 0., 0.].repeat(3));
    let ones = tiny.bytes_accessor("VEC4", 5121, &[1, 0, 0, 0].repeat(3));
    let now = &mut tiny.json["meshes"][0]["primitives"][0]["attributes"];
    now["JOINTS_1"] = attributes["JOINTS_0"].clone();
    now["WEIGHTS_0"] = json!(half);
    now["WEIGHTS_1"] = json!(half);
    now["JOINTS_0"] = json!(ones);
    let character = good(&tiny).character;
    let primitive = &character.meshes[0].primitives[0];
    assert_eq!(primitive.influences, 8);
    // The second set names joint 1 too, with zero weight: read as joint 0.
    assert_eq!(primitive.joints[..8], [1, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(primitive.weights[..8], [0.5, 0., 0., 0., 0.5, 0., 0., 0.]);
}

#[test]
fn morph_names_rest_weights_and_a_weights_channel() {
    let mut tiny = Tiny::triangle();
    let offsets = tiny.floats("VEC3", &[1.0; 9]);
    let normals = tiny.floats("VEC3", &[0.5; 9]);
    let mesh = &mut tiny.json["meshes"][0];
    mesh["primitives"][0]["targets"] =
        json!([{"POSITION": offsets}, {"POSITION": offsets, "NORMAL": normals}]);
    mesh["extras"] = json!({"targetNames": ["smile", "blink"]});
    mesh["weights"] = json!([0.25, 0.0]);
    tiny.json["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "weights": [0, 1]}]);
    let values = tiny.floats("SCALAR", &[0., 1., 1., 0.]);
    tiny.channel(
        json!({"node": 1, "path": "weights"}),
        "LINEAR",
        &[0., 2.],
        values,
    );
    let character = good(&tiny).character;
    assert_eq!(character.meshes[0].morph_names, ["smile", "blink"]);
    assert_eq!(character.meshes[0].morph_weights, [0.25, 0.0]);
    assert_eq!(
        character.meshes[1].morph_weights,
        [0.0, 1.0],
        "the node's own"
    );
    assert_eq!(
        character.meshes[1].primitives[0].morphs[1].normals[0],
        Vec3::splat(0.5)
    );
    let channel = &character.clips[0].channels[0];
    assert_eq!((channel.target, channel.property), (1, Property::Weights));
    assert_eq!(channel.values, [0., 1., 1., 0.]);
    assert_eq!(character.clips[0].duration_secs, 2.0);
    assert_eq!(character.clips[0].name, "animation_0");
}

#[test]
fn cubic_keys_and_normalised_rotations() {
    let mut tiny = Tiny::skinned();
    let key = [9., 9., 9., 9., 0., 0., 0., 2., 8., 8., 8., 8.];
    let cubic = tiny.floats("VEC4", &key);
    tiny.channel(
        json!({"node": 0, "path": "rotation"}),
        "CUBICSPLINE",
        &[1.5],
        cubic,
    );
    let small = tiny.bytes_accessor("VEC4", 5120, &[0, 0, 0, 127, 127, 0, 0, 0]);
    tiny.json["accessors"][small]["normalized"] = json!(true);
    tiny.channel(
        json!({"node": 1, "path": "rotation"}),
        "STEP",
        &[0., 1.],
        small,
    );
    let (file, warning) = one_warning(&tiny);
    let channels = &file.character.clips[0].channels;
    assert_eq!(channels[0].interpolation, Interpolation::CubicSpline);
    let mended = [9., 9., 9., 9., 0., 0., 0., 1., 8., 8., 8., 8.];
    assert_eq!(channels[0].values, mended, "tangents stay");
    assert!(
        warning.contains("1 quaternions are not of unit length"),
        "{warning}"
    );
    assert_eq!(channels[1].interpolation, Interpolation::Step);
    assert_eq!(channels[1].values, [0., 0., 0., 1., 1., 0., 0., 0.]);
    assert_eq!(file.character.clips[0].duration_secs, 1.5);
}

#[test]
fn keys_out_of_order_go_with_their_values() {
    let mut tiny = Tiny::skinned();
    let values: Vec<f32> = (0..4).flat_map(|i| [i as f32; 3]).collect();
    let values = tiny.floats("VEC3", &values);
    let target = json!({"node": 0, "path": "translation"});
    tiny.channel(target, "LINEAR", &[0., 2., 1., 3.], values);
    let (file, warning) = one_warning(&tiny);
    let channel = &file.character.clips[0].channels[0];
    assert_eq!(channel.times_secs, [0., 2., 3.]);
    assert_eq!(channel.values, [0., 0., 0., 1., 1., 1., 3., 3., 3.]);
    assert!(
        warning.starts_with("animations[0].samplers[0].input: 1 keys"),
        "{warning}"
    );
}

fn pointed(pointer: &str) -> serde_json::Value {
    json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}})
}

#[test]
fn pointers_to_joints_and_weights_drive_what_plain_targets_drive() {
    let mut by_pointer = Tiny::skinned();
    let mut plain = Tiny::skinned();
    for tiny in [&mut by_pointer, &mut plain] {
        tiny.json["nodes"]
            .as_array_mut()
            .unwrap()
            .push(json!({"name": "loose"}));
    }
    for (path, kind, width) in [("translation", "VEC3", 3), ("rotation", "VEC4", 4)] {
        let values: Vec<f32> = (0..2)
            .flat_map(|_| [0., 0., 0., 1.][4 - width..].to_vec())
            .collect();
        let at = by_pointer.floats(kind, &values);
        by_pointer.channel(
            pointed(&format!("/nodes/3/{path}")),
            "LINEAR",
            &[0., 1.],
            at,
        );
        let at = plain.floats(kind, &values);
        plain.channel(json!({"node": 3, "path": path}), "LINEAR", &[0., 1.], at);
    }
    by_pointer.json["extensionsRequired"] = json!(["KHR_animation_pointer"]);
    let character = good(&by_pointer).character;
    assert_eq!(character, good(&plain).character);
    assert_eq!(
        character.skeleton.joints[2].name, "loose",
        "moved, so a joint"
    );

    // A mesh's weights apply to its nodes, except one that has its own.
    let mut tiny = Tiny::triangle();
    let offsets = tiny.floats("VEC3", &[1.0; 9]);
    tiny.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": offsets}]);
    tiny.json["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "weights": [1]}, {"mesh": 0}]);
    let values = tiny.floats("SCALAR", &[0., 1.]);
    tiny.channel(pointed("/meshes/0/weights"), "LINEAR", &[0., 1.], values);
    let channels = good(&tiny).character.clips[0].channels.clone();
    let targets: Vec<_> = channels.iter().map(|c| (c.target, c.property)).collect();
    assert_eq!(targets, [(0, Property::Weights), (2, Property::Weights)]);
    assert_eq!(channels[1].values, [0., 1.]);
}

#[test]
fn channels_that_drive_nothing_we_have_are_left_out() {
    for pointer in [
        "/materials/0/alphaCutoff",
        "/nodes/2/weights/0",
        "/meshes/0/weights/0",
        "/nodes/9/scale",
    ] {
        let mut tiny = Tiny::skinned();
        let values = tiny.floats("VEC3", &[1.0; 3]);
        tiny.channel(pointed(pointer), "LINEAR", &[0.], values);
        let (file, warning) = one_warning(&tiny);
        assert_eq!(file.character.clips[0].channels, []);
        assert!(warning.contains(pointer), "{warning}");
    }
}

#[test]
fn rest_rotations_and_matrices_are_repaired() {
    let mut tiny = Tiny::skinned();
    tiny.json["nodes"][0]["rotation"] = json!([0, 0, 0, 0]);
    let (file, warning) = one_warning(&tiny);
    assert_eq!(
        file.character.skeleton.joints[0].rest.rotation,
        Quat::IDENTITY
    );
    assert!(
        warning.starts_with("nodes[0].rotation: a quaternion of length 0"),
        "{warning}"
    );
    tiny.json["nodes"][0]["rotation"] = json!([0, 0, 3, 0]);
    let (file, _) = one_warning(&tiny);
    let rotation = file.character.skeleton.joints[0].rest.rotation;
    assert_eq!(rotation, Quat::from_xyzw(0.0, 0.0, 1.0, 0.0));

    let mut tiny = Tiny::skinned();
    tiny.json["nodes"][0]["matrix"] = json!([0, 2, 0, 0, -2, 0, 0, 0, 0, 0, 2, 0, 5, 6, 7, 1]);
    let rest = good(&tiny).character.skeleton.joints[0].rest;
    assert!((rest.scale - Vec3::splat(2.0)).length() < 1e-6);
    assert!((rest.rotation * Vec3::X - Vec3::Y).length() < 1e-6);
    assert_eq!(rest.translation, Vec3::new(5.0, 6.0, 7.0));
    // Sheared: x stays, y leans over.
    tiny.json["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    let (file, warning) = one_warning(&tiny);
    let rest = file.character.skeleton.joints[0].rest;
    assert!((rest.rotation * Vec3::X - Vec3::X).length() < 1e-6);
    assert!(warning.contains("sheared"), "{warning}");
    tiny.json["nodes"][0]["matrix"] = json!(vec![0; 16]);
    let (file, _) = one_warning(&tiny);
    assert!(file.character.skeleton.joints[0].rest.is_finite());
}

#[test]
fn data_uris_and_files_beside() {
    let tiny = Tiny::skinned();
    let mut json = tiny.json.clone();
    // The length of the buffer, percent-encoded byte by byte.
    let encoded: String = tiny.bytes.iter().map(|b| format!("%{b:02x}")).collect();
    let uri = format!("data:application/octet-stream,{encoded}");
    json["buffers"] = json!([{"uri": uri, "byteLength": tiny.bytes.len()}]);
    let inline = read(json.to_string().as_bytes()).unwrap();
    let plain = tiny.read().unwrap();
    assert_eq!(inline.value.character, plain.value.character);

    json["buffers"][0]["uri"] = json!("my%20buffer.bin");
    json["images"] = json!([{"uri": "skin.png", "name": "skin"}, {"uri": "gone.png"}]);
    let mut beside = |uri: &str| match uri {
        "my buffer.bin" => Ok(tiny.bytes.clone()),
        "skin.png" => Ok(b"\x89PNG, not really".to_vec()),
        other => Err(format!("{other}: no such file")),
    };
    let limits = Limits::default();
    let text = json.to_string().into_bytes();
    let file = gltf::read(&text, &limits, &mut beside).unwrap();
    assert_eq!(file.value.character.meshes, plain.value.character.meshes);
    let images = &file.value.character.images;
    assert_eq!(images[0].mime_type, "image/png");
    assert!(images[1].bytes.is_empty());
    assert_eq!(file.warnings.len(), 1, "a missing picture is a warning");
    assert_eq!(file.warnings[0].at, "images[1]");

    let error = read(&text).unwrap_err();
    assert!(matches!(error, ReadError::Missing { .. }), "{error}");
    assert!(error.to_string().contains("my buffer.bin"));
}

#[test]
fn materials_as_a_preview_needs_them() {
    let mut tiny = Tiny::skinned();
    let picture = tiny.view(b"\xFF\xD8\xFF picture");
    let sets = tiny.floats("VEC2", &[0., 0., 1., 0., 0., 1.]);
    tiny.json["images"] = json!([{"bufferView": picture, "mimeType": "image/png"}]);
    tiny.json["textures"] = json!([{"source": 0}]);
    tiny.json["materials"] = json!([
        {"name": "cloth", "alphaMode": "MASK", "doubleSided": true, "pbrMetallicRoughness":
            {"baseColorFactor": [1, 0.5, 0, 1], "baseColorTexture": {"index": 0, "texCoord": 1}}},
        {"extensions": {"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [0, 1, 0, 1]}}},
    ]);
    let primitive = &mut tiny.json["meshes"][0]["primitives"][0];
    primitive["material"] = json!(0);
    primitive["attributes"]["TEXCOORD_1"] = json!(sets);
    let character = good(&tiny).character;
    let cloth = &character.materials[0];
    assert_eq!(cloth.base_color, Vec4::new(1.0, 0.5, 0.0, 1.0));
    assert_eq!(cloth.base_color_image, Some(0));
    assert_eq!((cloth.alpha_cutoff, cloth.double_sided), (0.5, true));
    assert_eq!(
        character.materials[1].base_color,
        Vec4::new(0.0, 1.0, 0.0, 1.0)
    );
    assert_eq!(
        character.images[0].mime_type, "image/jpeg",
        "as the bytes say"
    );
    assert_eq!(character.meshes[0].primitives[0].texcoords[1].x, 1.0);
}

#[test]
fn human_bones_of_vrm_are_joints() {
    for humanoid in [
        json!({"VRMC_vrm": {"humanoid": {"humanBones": {"hips": {"node": 0}}}}}),
        json!({"VRM": {"humanoid": {"humanBones": [
            {"bone": "hips", "node": 0}, {"bone": "jaw", "node": -1}]}}}),
        json!({"VRMC_vrm_animation": {"humanoid": {"humanBones": {"hips": {"node": 0}}}}}),
    ] {
        let mut tiny = Tiny::new();
        tiny.json["nodes"] = json!([{"name": "bone"}, {"name": "helper"}]);
        tiny.json["extensions"] = humanoid;
        let joints = good(&tiny).character.skeleton.joints;
        assert_eq!((joints.len(), joints[0].in_skin), (1, true));
    }
}

#[test]
fn required_extensions_are_read_or_refused_with_a_mend() {
    let mut tiny = Tiny::skinned();
    for fine in ["KHR_texture_transform", "KHR_materials_unlit", "VRMC_vrm"] {
        tiny.json["extensionsRequired"] = json!([fine]);
        good(&tiny);
    }
    tiny.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    let refused = error(&tiny);
    assert!(
        refused.contains("extensionsRequired[0]: KHR_draco"),
        "{refused}"
    );
    assert!(refused.contains("gltf-transform copy"), "{refused}");
    tiny.json["extensionsRequired"] = json!(["ACME_secret"]);
    assert!(error(&tiny).contains("re-export without ACME_secret"));
    tiny.json["extensionsRequired"] = json!([]);
    tiny.json["asset"]["version"] = json!("1.0");
    assert!(error(&tiny).contains("glTF version 1.0"));
}

#[test]
fn base64_of_a_buffer_may_be_broken_into_lines() {
    let mut tiny = Tiny::skinned();
    let encoded = base64::Engine::encode(&base64::prelude::BASE64_STANDARD, &tiny.bytes);
    let expected = good(&tiny).character;
    for line_end in ["\n", "\r\n", " \n\t", "%0D%0A"] {
        let lines: Vec<&str> = (0..encoded.len().div_ceil(76))
            .map(|i| &encoded[i * 76..encoded.len().min((i + 1) * 76)])
            .collect();
        let uri = format!("data:;base64,{}{line_end}", lines.join(line_end));
        tiny.json["buffers"] = json!([{"byteLength": tiny.bytes.len(), "uri": uri}]);
        let text = tiny.json.to_string();
        assert_eq!(read(text.as_bytes()).unwrap().value.character, expected);
    }
}
