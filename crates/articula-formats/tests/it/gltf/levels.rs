//! Coarser levels of nodes (MSFT_lod): read as levels of one mesh, shown once, round trips.

use super::tiny::{Tiny, read};
use articula_core::source::{Character, RawMesh};
use articula_formats::gltf::Document;
use glam::{Affine3A, Vec3};
use serde_json::{Value, json};

/// The skinned triangle on node 2 with two coarser levels on nodes 3 and 4, in no scene.
pub(crate) fn skinned() -> Tiny {
    let mut tiny = Tiny::skinned();
    let attributes = tiny.json["meshes"][0]["primitives"][0]["attributes"].clone();
    let indices = tiny.bytes_accessor("SCALAR", 5121, &[0, 1, 2, 2, 1, 0]);
    let fine = json!({"primitives": [{"attributes": attributes, "indices": indices}]});
    let coarse = json!({"primitives": [{"attributes": attributes}]});
    tiny.json["meshes"] = json!([fine, coarse, coarse]);
    let nodes = tiny.json["nodes"].as_array_mut().unwrap();
    nodes[2]["extensions"] = json!({"MSFT_lod": {"ids": [3, 4]}});
    nodes[2]["extras"] = json!({"MSFT_screencoverage": [0.5, 0.25, 0.125]});
    nodes.push(json!({"name": "coarse", "mesh": 1, "skin": 0}));
    nodes.push(json!({"name": "coarsest", "mesh": 2, "skin": 0}));
    tiny.json["extensionsUsed"] = json!(["MSFT_lod"]);
    tiny
}

/// The triangle on a moved node, with one coarser level on another.
fn rigid(coarse: Value) -> Tiny {
    let mut tiny = Tiny::triangle();
    let fine = json!({"name": "fine", "mesh": 0, "translation": [0, 2, 0], "rotation": [0, 1, 0, 0],
        "extensions": {"MSFT_lod": {"ids": [1]}}});
    tiny.json["nodes"] = json!([fine, coarse]);
    tiny.json["scenes"] = json!([{"nodes": [0]}]);
    tiny
}

fn good(tiny: &Tiny) -> Character {
    let file = tiny.read().unwrap();
    assert_eq!(file.warnings, []);
    file.value.character
}

fn one_warning(tiny: &Tiny) -> (Character, String) {
    let file = tiny.read().unwrap();
    assert_eq!(file.warnings.len(), 1, "{:?}", file.warnings);
    let warning = &file.warnings[0];
    (
        file.value.character,
        format!("{}: {}", warning.at, warning.what),
    )
}

/// Returns triangle count and minimum screen coverage of each level.
fn told(mesh: &RawMesh) -> Vec<(usize, Option<f32>)> {
    let triangles =
        |p: &[articula_core::source::Primitive]| p.iter().map(|p| p.triangles.len()).sum();
    let finest = (triangles(&mesh.primitives), mesh.screen_coverage);
    let coarser = mesh
        .levels
        .iter()
        .map(|l| (triangles(&l.primitives), l.screen_coverage));
    [finest].into_iter().chain(coarser).collect()
}

fn comes_back(character: &Character) {
    let written = Document::from_character(character).unwrap();
    assert_eq!(written.json["extensionsUsed"], json!(["MSFT_lod"]));
    let again = read(&written.write_glb().unwrap()).unwrap();
    assert_eq!(again.warnings, []);
    assert_eq!(again.value.character.meshes, character.meshes);
    assert_eq!(again.value.character.skeleton, character.skeleton);
}

#[test]
fn skinned_levels() {
    let character = good(&skinned());
    assert_eq!(character.meshes.len(), 1, "shown once");
    let mesh = &character.meshes[0];
    assert_eq!(
        told(mesh),
        [(2, Some(0.5)), (1, Some(0.25)), (1, Some(0.125))]
    );
    assert!(mesh.levels.iter().all(|level| level.skin == mesh.skin));
    assert_eq!(mesh.levels[0].primitives[0].weights[..2], [0.25, 0.75]);
    comes_back(&character);
    // A scene may show the coarser nodes too; they are still not separate meshes.
    let mut tiny = skinned();
    tiny.json["scenes"][0]["nodes"] = json!([0, 2, 3, 4]);
    assert_eq!(good(&tiny), character);
}

#[test]
fn shares_of_the_screen_may_be_few_or_none() {
    let mut tiny = skinned();
    tiny.json["nodes"][2]["extras"] = json!({"MSFT_screencoverage": [0.5, "x", 0.1]});
    let character = good(&tiny);
    let shares = [(2, Some(0.5)), (1, None), (1, Some(0.1f32))];
    assert_eq!(told(&character.meshes[0]), shares);
    tiny.json["nodes"][2]["extras"] = json!(1);
    let character = good(&tiny);
    assert_eq!(
        told(&character.meshes[0]),
        [(2, None), (1, None), (1, None)]
    );
    comes_back(&character);
}

#[test]
fn a_rigid_level_hangs_where_the_finest_hangs() {
    // The same transform: no offset.
    let same = json!({"mesh": 0, "translation": [0, 2, 0], "rotation": [0, 1, 0, 0]});
    let character = good(&rigid(same));
    let mesh = &character.meshes[0];
    assert_eq!(mesh.levels[0].skin, mesh.skin);
    assert_eq!(character.skeleton.joints.len(), 1);
    comes_back(&character);
    // Another transform: it replaces the finest with its own transform, 3 m up, unrotated.
    let other = json!({"mesh": 0, "translation": [0, 3, 0]});
    let character = good(&rigid(other.clone()));
    let joint = character.skeleton.joints[0].rest.to_affine();
    let placed = |character: &Character| {
        let offset = character.meshes[0].levels[0].skin.inverse_bind[0];
        joint.transform_point3(offset.transform_point3(Vec3::X))
    };
    assert!(placed(&character).distance(Vec3::new(1.0, 3.0, 0.0)) < 1e-6);
    let written = Document::from_character(&character).unwrap();
    let again = read(&written.write_glb().unwrap()).unwrap().value.character;
    assert_eq!(again.skeleton, character.skeleton);
    assert!(placed(&again).distance(Vec3::new(1.0, 3.0, 0.0)) < 1e-6);
    // Below its own parent it keeps that transform.
    let mut tiny = rigid(other);
    let nodes = tiny.json["nodes"].as_array_mut().unwrap();
    nodes.push(json!({"translation": [5, 0, 0], "children": [1]}));
    tiny.json["scenes"] = json!([{"nodes": [0, 2]}]);
    let character = good(&tiny);
    assert_eq!(character.meshes.len(), 1);
    assert!(placed(&character).distance(Vec3::new(6.0, 3.0, 0.0)) < 1e-5);
}

#[test]
fn branches_with_as_many_meshes_are_paired() {
    let mut tiny = Tiny::triangle();
    tiny.json["nodes"] = json!([
        {"children": [1, 2], "translation": [1, 0, 0], "extensions": {"MSFT_lod": {"ids": [3]}}},
        {"name": "left", "mesh": 0, "translation": [0, 1, 0]},
        {"name": "right", "mesh": 0},
        {"children": [4, 5], "translation": [2, 0, 0]},
        {"name": "left coarse", "mesh": 0},
        {"name": "right coarse", "mesh": 0},
    ]);
    tiny.json["scenes"] = json!([{"nodes": [0]}]);
    let character = good(&tiny);
    let names: Vec<_> = character.meshes.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["left", "right"]);
    // The whole branch is 1 m further; the left part is also 1 m lower than the finest.
    let offsets = character
        .meshes
        .iter()
        .map(|m| m.levels[0].skin.inverse_bind[0]);
    let offsets: Vec<Affine3A> = offsets.collect();
    let wanted = [Vec3::new(1.0, -1.0, 0.0), Vec3::X];
    assert_eq!(offsets, wanted.map(Affine3A::from_translation));
    comes_back(&character);
    // One more in the coarser branch: the pairing is undefined.
    let nodes = tiny.json["nodes"].as_array_mut().unwrap();
    nodes[3]["children"] = json!([4, 5, 6]);
    nodes.push(json!({"mesh": 0}));
    let (character, warning) = one_warning(&tiny);
    assert_eq!(
        warning,
        "nodes[3]: a level with 3 meshes is left out: the finest has 2"
    );
    assert_eq!(character.meshes.len(), 2, "nor are they shown");
}

#[test]
fn morph_targets_of_a_level_are_those_of_the_mesh_or_none() {
    let mut tiny = Tiny::triangle();
    let offsets = tiny.floats("VEC3", &[1.0; 9]);
    let attributes = tiny.json["meshes"][0]["primitives"][0]["attributes"].clone();
    let mesh = |targets: usize| {
        let targets = vec![json!({"POSITION": offsets}); targets];
        json!({"primitives": [{"attributes": attributes, "targets": targets}]})
    };
    tiny.json["meshes"] = json!([mesh(2), mesh(2), mesh(0), mesh(1)]);
    tiny.json["nodes"] = json!([{"mesh": 0, "extensions": {"MSFT_lod": {"ids": [1, 2, 3]}}},
        {"mesh": 1}, {"mesh": 2}, {"mesh": 3}]);
    tiny.json["scenes"] = json!([{"nodes": [0]}]);
    let (character, warning) = one_warning(&tiny);
    assert!(warning.contains("the finest has 2"), "{warning}");
    let levels = character.meshes[0].levels.iter();
    let morphs: Vec<_> = levels.map(|l| l.primitives[0].morphs.len()).collect();
    assert_eq!(morphs, [2, 0, 0]);
    comes_back(&character);
}

#[test]
fn broken_levels_are_left_out() {
    let cases = [
        (
            json!(9),
            "levels are left out: nodes[2].extensions.MSFT_lod.ids: expected an array",
        ),
        (
            json!([9]),
            "the level is left out: nodes[2].extensions.MSFT_lod.ids[0]: index 9",
        ),
        (json!([2]), "the node itself or an ancestor of it"),
        (json!(["x"]), "the level is left out"),
        // Node 1 shows nothing.
        (
            json!([1]),
            "a level with 0 meshes is left out: the finest has 1",
        ),
    ];
    for (ids, says) in cases {
        let mut tiny = skinned();
        tiny.json["nodes"][2]["extensions"]["MSFT_lod"]["ids"] = ids.clone();
        // Otherwise they are in no scene, which is another warning.
        tiny.json["nodes"].as_array_mut().unwrap().truncate(3);
        let (character, warning) = one_warning(&tiny);
        assert!(warning.contains(says), "{ids}: {warning}");
        assert_eq!(character.meshes[0].levels, []);
    }
    let mut tiny = skinned();
    tiny.json["nodes"][3]
        .as_object_mut()
        .unwrap()
        .remove("skin");
    let (character, warning) = one_warning(&tiny);
    assert!(
        warning.starts_with("nodes[3]: the level cannot take the position"),
        "{warning}"
    );
    assert_eq!(told(&character.meshes[0]).len(), 2);
    let mut tiny = skinned();
    tiny.json["nodes"][3]["extensions"] = json!({"MSFT_lod": {"ids": [4]}});
    assert_eq!(good(&tiny), good(&skinned()), "levels of levels");
    tiny.json["materials"] = json!([{"extensions": {"MSFT_lod": {"ids": [1]}}}]);
    let (_, warning) = one_warning(&tiny);
    assert_eq!(
        warning,
        "materials[0]: coarser levels of a material are left out"
    );
}
