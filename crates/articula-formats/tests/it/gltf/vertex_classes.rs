//! Classes of vertices that are equal in the whole document.

use super::tiny::Tiny;
use serde_json::json;

/// Two triangles over six vertices, of which 3 to 5 have the positions of 0 to 2.
fn doubled() -> Tiny {
    let mut tiny = Tiny::new();
    let corners = [0., 0., 0., 1., 0., 0., 0., 1., 0.];
    let positions = tiny.floats("VEC3", &[corners, corners].concat());
    tiny.json["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": positions}}]}]);
    tiny.json["nodes"] = json!([{"mesh": 0}]);
    tiny.json["scenes"] = json!([{"nodes": [0]}]);
    tiny
}

fn classes(tiny: &Tiny, part: usize) -> Vec<u32> {
    let document = tiny.read().unwrap().value.document;
    document.vertex_classes(0, part).unwrap()
}

#[test]
fn every_array_of_the_document_counts() {
    let mut tiny = doubled();
    assert_eq!(classes(&tiny, 0), [0, 1, 2, 0, 1, 2]);
    // A second set of texture coordinates that differs in vertex 4 alone.
    let sets = [[0., 0.], [1., 0.], [0., 1.], [0., 0.], [0.5, 0.], [0., 1.]];
    let second = tiny.floats("VEC2", sets.as_flattened());
    let primitive = &mut tiny.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["TEXCOORD_1"] = json!(second);
    assert_eq!(classes(&tiny, 0), [0, 1, 2, 0, 4, 2]);
    // A sparse morph target that moves vertex 3, and one that stores zero for vertex 5.
    let indices = tiny.view(&[3, 5]);
    let values: Vec<u8> = [1f32, 0., 0., 0., 0., 0.]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let values = tiny.view(&values);
    let target = tiny.accessor(json!({"componentType": 5126, "count": 6, "type": "VEC3",
        "sparse": {"count": 2, "indices": {"bufferView": indices, "componentType": 5121},
            "values": {"bufferView": values}}}));
    let primitive = &mut tiny.json["meshes"][0]["primitives"][0];
    primitive["targets"] = json!([{"POSITION": target}]);
    assert_eq!(classes(&tiny, 0), [0, 1, 2, 3, 4, 2]);
}

#[test]
fn parts_and_vertices_are_those_of_the_character() {
    let mut tiny = doubled();
    let indices = tiny.bytes_accessor("SCALAR", 5121, &[1, 2, 4]);
    let part = tiny.json["meshes"][0]["primitives"][0].clone();
    let mut points = part.clone();
    points["mode"] = json!(0);
    let mut second = part.clone();
    second["indices"] = json!(indices);
    // Points become no part; parts that share their positions keep the vertices they use.
    tiny.json["meshes"][0]["primitives"] = json!([points, part, second]);
    let character = tiny.read().unwrap().value.character;
    assert_eq!(character.meshes[0].primitives.len(), 2);
    assert_eq!(classes(&tiny, 0), [0, 1, 2, 0, 1, 2]);
    assert_eq!(classes(&tiny, 1), [0, 1, 0], "vertices 1, 2 and 4");
    let document = tiny.read().unwrap().value.document;
    let at = |node, part| document.vertex_classes(node, part).unwrap_err().to_string();
    assert_eq!(
        at(0, 2),
        "meshes[0]: primitive 2 is out of range: there are 2"
    );
    assert_eq!(at(1, 0), "nodes[1]: there is no such node with a mesh");
}
