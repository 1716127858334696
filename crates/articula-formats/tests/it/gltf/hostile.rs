//! Hostile files: each gives one clear error that names the position.

use super::tiny::{Tiny, read};
use articula_formats::gltf;
use articula_formats::{Limits, ReadError};
use articula_mutate::cut_off;
use serde_json::{Value, json};

/// An invalid change of a valid file, and the expected error.
type Case = (&'static str, fn(&mut Tiny), &'static str);

const CASES: &[Case] = &[
    (
        "asset no object",
        |t| t.json["asset"] = json!(3),
        "asset: expected an object",
    ),
    (
        "glTF 1.0",
        |t| t.json["asset"] = json!({ "version": "1.0" }),
        "glTF version 1.0",
    ),
    (
        "node cycle",
        |t| t.json["nodes"][1]["children"] = json!([0]),
        "part of a cycle",
    ),
    (
        "node its own child",
        |t| t.json["nodes"][2]["children"] = json!([2]),
        "part of a cycle",
    ),
    (
        "two parents",
        |t| t.json["nodes"][2]["children"] = json!([1]),
        "already a child of node 0",
    ),
    (
        "child beyond",
        |t| t.json["nodes"][0]["children"] = json!([3]),
        "children[0]: index 3",
    ),
    (
        "child negative",
        |t| t.json["nodes"][0]["children"] = json!([-1]),
        "whole number",
    ),
    (
        "children no list",
        |t| t.json["nodes"][0]["children"] = json!(1),
        "expected an array",
    ),
    (
        "mesh beyond",
        |t| t.json["nodes"][2]["mesh"] = json!(1),
        "nodes[2].mesh: index 1",
    ),
    (
        "skin beyond",
        |t| t.json["nodes"][2]["skin"] = json!(7),
        "nodes[2].skin: index 7",
    ),
    (
        "joint beyond",
        |t| t.json["skins"][0]["joints"] = json!([0, 9]),
        "joints[1]: index 9",
    ),
    (
        "no joints",
        |t| t.json["skins"][0]["joints"] = json!([]),
        "at least one joint",
    ),
    (
        "too few joints",
        |t| t.json["skins"][0]["joints"] = json!([0]),
        "the skin has 1",
    ),
    (
        "scene beyond",
        |t| t.json["scenes"][0]["nodes"] = json!([5]),
        "scenes[0].nodes[0]",
    ),
    (
        "rotation too short",
        |t| t.json["nodes"][0]["rotation"] = json!([0, 0, 1]),
        "expected 4",
    ),
    (
        "huge float",
        |t| t.json["nodes"][0]["scale"] = json!([1e300, 1, 1]),
        "finite number",
    ),
    (
        "count 2^31",
        |t| t.json["accessors"][0]["count"] = json!(1u64 << 31),
        "exceed the view",
    ),
    (
        "count 2^64",
        |t| t.json["accessors"][0]["count"] = json!(u64::MAX),
        "exceed the view",
    ),
    (
        "empty 2^31",
        |t| bare(t, 1 << 31),
        "decoded elements, the limit is",
    ),
    (
        "empty 2^63",
        |t| bare(t, 1 << 63),
        "decoded elements, the limit is",
    ),
    (
        "offset overflow",
        |t| t.json["accessors"][0]["byteOffset"] = json!(u64::MAX),
        "exceed the view",
    ),
    (
        "offset beyond",
        |t| t.json["accessors"][0]["byteOffset"] = json!(4),
        "exceed the view",
    ),
    (
        "stride 0",
        |t| t.json["bufferViews"][0]["byteStride"] = json!(0),
        "byteStride 0",
    ),
    (
        "stride odd",
        |t| t.json["bufferViews"][0]["byteStride"] = json!(13),
        "byteStride 13",
    ),
    (
        "stride small",
        |t| t.json["bufferViews"][0]["byteStride"] = json!(8),
        "byteStride 8",
    ),
    (
        "stride huge",
        |t| t.json["bufferViews"][0]["byteStride"] = json!(u64::MAX),
        "byteStride",
    ),
    (
        "view too long",
        |t| t.json["bufferViews"][0]["byteLength"] = json!(1u64 << 40),
        "exceed the buffer",
    ),
    (
        "view overflow",
        |t| t.json["bufferViews"][0]["byteOffset"] = json!(u64::MAX),
        "exceed the buffer",
    ),
    (
        "view beyond",
        |t| t.json["accessors"][0]["bufferView"] = json!(99),
        "index 99",
    ),
    (
        "buffer beyond",
        |t| t.json["bufferViews"][0]["buffer"] = json!(1),
        "index 1",
    ),
    (
        "buffer too long",
        |t| t.json["buffers"] = json!([{"byteLength": 1u64 << 60}]),
        "only",
    ),
    (
        "buffer of nothing",
        |t| t.json["buffers"] = json!([{"byteLength": 1}, {"byteLength": 1}]),
        "no \"uri\"",
    ),
    (
        "component unknown",
        |t| t.json["accessors"][0]["componentType"] = json!(5124),
        "not a component type",
    ),
    (
        "type unknown",
        |t| t.json["accessors"][0]["type"] = json!("VEC9"),
        "VEC9",
    ),
    (
        "wrong type",
        |t| t.json["accessors"][0]["type"] = json!("VEC2"),
        "expected elements",
    ),
    (
        "weights too few",
        |t| t.json["accessors"][2]["count"] = json!(2),
        "but 3 vertices",
    ),
    (
        "vertex beyond",
        |t| indices(t, &[0, 1, 3]),
        "vertex 3 is out of range",
    ),
    (
        "float indices",
        |t| t.json["meshes"][0]["primitives"][0]["indices"] = json!(2),
        "expected elements of type SCALAR",
    ),
    ("sparse beyond", |t| sparse(t, 1, 3), "sparse index 3"),
    (
        "sparse too many",
        |t| sparse(t, 4, 0),
        "4 sparse elements for an accessor of 3",
    ),
    (
        "material beyond",
        |t| t.json["meshes"][0]["primitives"][0]["material"] = json!(0),
        "material: index 0",
    ),
    (
        "NaN position",
        |t| t.bytes[4..8].copy_from_slice(&f32::NAN.to_le_bytes()),
        "holds NaN",
    ),
    (
        "infinite position",
        |t| t.bytes[4..8].copy_from_slice(&f32::INFINITY.to_le_bytes()),
        "holds inf",
    ),
    (
        "joint of a vertex beyond",
        |t| t.bytes[37] = 200,
        "joint 200 of a vertex is out of range",
    ),
    (
        "NaN time",
        |t| animated(t, &[f32::NAN, 1.0], 2),
        "holds NaN",
    ),
    (
        "too few values",
        |t| animated(t, &[0.0, 1.0], 1),
        "values belong to the key times",
    ),
    (
        "wrong mode",
        |t| {
            animated(t, &[0.0], 1);
            t.json["animations"][0]["samplers"][0]["interpolation"] = json!("BOUNCE");
        },
        "BOUNCE",
    ),
    (
        "sampler beyond",
        |t| {
            animated(t, &[0.0], 1);
            t.json["animations"][0]["channels"][0]["sampler"] = json!(1);
        },
        "sampler: index 1",
    ),
    (
        "nodes no list",
        |t| t.json["nodes"] = json!({}),
        "nodes: expected an array",
    ),
    (
        "attributes missing",
        |t| t.json["meshes"][0]["primitives"] = json!([{}]),
        "attributes",
    ),
];

fn bare(tiny: &mut Tiny, count: u64) {
    let accessor = json!({"componentType": 5126, "count": count, "type": "VEC3"});
    let accessor = tiny.accessor(accessor);
    tiny.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(accessor);
}

fn indices(tiny: &mut Tiny, corners: &[u8]) {
    let accessor = tiny.bytes_accessor("SCALAR", 5121, corners);
    tiny.json["meshes"][0]["primitives"][0]["indices"] = json!(accessor);
}

fn sparse(tiny: &mut Tiny, count: u64, index: u8) {
    let at = tiny.view(&[index; 4]);
    let to = tiny.view(&[0; 48]);
    tiny.json["accessors"][0]["sparse"] = json!({"count": count,
        "indices": {"bufferView": at, "componentType": 5121}, "values": {"bufferView": to}});
}

fn animated(tiny: &mut Tiny, times: &[f32], values: usize) {
    let output = tiny.floats("VEC3", &vec![0.0; values * 3]);
    let target = json!({"node": 0, "path": "translation"});
    tiny.channel(target, "LINEAR", times, output);
}

#[test]
fn each_harm_has_its_error() {
    assert!(Tiny::skinned().read().is_ok());
    for (name, spoil, says) in CASES {
        let mut tiny = Tiny::skinned();
        spoil(&mut tiny);
        match tiny.read() {
            Ok(file) => panic!("{name} was read: {:?}", file.warnings),
            Err(error) => {
                let error = error.to_string();
                assert!(error.contains(says), "{name}: {error}");
            }
        }
    }
}

#[test]
fn truncated_at_every_byte() {
    let mut tiny = Tiny::skinned();
    animated(&mut tiny, &[0.0, 1.0], 2);
    let good = tiny.glb();
    assert!(good.len() <= 4096, "{} bytes", good.len());
    assert!(read(&good).is_ok());
    let text = tiny.json.to_string();
    for bytes in cut_off(&good).chain(cut_off(text.as_bytes())) {
        assert!(read(bytes).is_err(), "cut at {}", bytes.len());
    }
}

#[test]
fn a_deep_hierarchy_is_refused_and_does_not_recurse() {
    // So small a stack has 13 bytes for each level, less than any call takes.
    let small = std::thread::Builder::new().stack_size(256 << 10);
    let read = small.spawn(a_deep_hierarchy_is_read).unwrap();
    read.join().unwrap();
}

fn a_deep_hierarchy_is_read() {
    let mut tiny = Tiny::skinned();
    let limits = Limits {
        nodes: 1 << 20,
        ..Limits::default()
    };
    let chain = 20_000;
    let node = |n: usize| json!({"children": [n + 1]});
    let mut nodes: Vec<Value> = (0..chain).map(node).collect();
    nodes.push(json!({}));
    tiny.json["nodes"] = json!(nodes);
    let mut alone = |_: &str| Err(String::new());
    let error = gltf::read(&tiny.glb(), &limits, &mut alone).unwrap_err();
    assert_eq!(
        error.to_string(),
        "nodes[128]: 129 levels of nodes, the limit is 128"
    );
    let deep = Limits {
        depth: u64::MAX,
        ..limits
    };
    tiny.json["skins"][0]["joints"] = json!([0, chain]);
    tiny.json["nodes"][chain] = json!({"name": "last"});
    let file = gltf::read(&tiny.glb(), &deep, &mut alone).unwrap();
    assert_eq!(file.value.character.skeleton.joints.len(), chain + 1);
}

#[test]
fn many_entries_of_one_thing_meet_the_limits() {
    let limit = |tiny: &Tiny, limits: Limits| {
        let mut alone = |_: &str| Ok(vec![0; 1000]);
        let error = gltf::read(&tiny.glb(), &limits, &mut alone).unwrap_err();
        assert!(matches!(error, ReadError::LimitExceeded { .. }), "{error}");
        error.to_string()
    };
    let tight = Limits {
        bytes: 100_000,
        elements: 1000,
        nodes: 50,
        ..Limits::default()
    };
    // A thousand pictures from one file.
    let mut tiny = Tiny::skinned();
    tiny.json["images"] = json!(vec![json!({"uri": "a.png"}); 1000]);
    assert!(limit(&tiny, tight).contains("bytes of buffers and pictures"));
    // A thousand pictures from one view.
    let mut tiny = Tiny::skinned();
    let view = tiny.view(&[0; 1000]);
    tiny.json["images"] = json!(vec![json!({"bufferView": view}); 1000]);
    assert!(limit(&tiny, tight).contains("bytes of pictures"));
    // A thousand primitives with one array, none of which is drawn.
    let mut tiny = Tiny::skinned();
    let primitive = json!({"attributes": {}, "mode": 0});
    tiny.json["meshes"] = json!([{"primitives": vec![primitive; 1000]}]);
    assert!(limit(&tiny, tight).contains("decoded elements"));
    // More nodes than allowed.
    let mut tiny = Tiny::skinned();
    tiny.json["nodes"] = json!(vec![json!({}); 51]);
    assert!(limit(&tiny, tight).contains("51 nodes, the limit is 50"));
    // More keys than a clip may have frames.
    let mut tiny = Tiny::skinned();
    animated(&mut tiny, &[0.0, 1.0, 2.0], 3);
    let short = Limits {
        frames: 2,
        ..Limits::default()
    };
    assert!(limit(&tiny, short).contains("3 keys of a channel"));
}
