//! Levels stored in documents: only the order changes, and broken levels are rejected.

use super::tiny::{Tiny, read};
use crate::real;
use crate::thinned::{clustered, levels, part, store, table};
use articula_build::Clustered;
use articula_core::source::{Primitive, RawMesh};
use articula_formats::gltf::MeshParts;
use articula_formats::gltf::{Document, GltfFile};
use serde_json::{Value, json};

/// Returns a sheet of 4 x 4 squares with every kind of array: interleaved and strided, integers,
/// sparse over zeros and over values, used twice, unused vertices; skinned and morphed.
fn sheet() -> Tiny {
    sheet_in(Tiny::skinned())
}

fn sheet_in(mut tiny: Tiny) -> Tiny {
    let side = 5u32;
    let count = (side * side + 2) as usize;
    // Positions and the second texture coordinates interleaved, two unused vertices at the end.
    let mut bytes = Vec::new();
    for v in 0..count as u32 {
        let position = [(v % side) as f32, (v / side) as f32, 0.1 * (v % 7) as f32];
        let texcoord = [v as f32, -(v as f32)];
        let numbers = position.into_iter().chain(texcoord);
        bytes.extend(numbers.flat_map(f32::to_le_bytes));
    }
    let view = tiny.view(&bytes);
    tiny.json["bufferViews"][view]["byteStride"] = json!(20);
    let of_view = |offset: u32, kind| {
        json!({"bufferView": view, "byteOffset": offset, "componentType": 5126, "count": count,
            "type": kind})
    };
    let mut positions = of_view(0, "VEC3");
    positions["min"] = json!([0, 0, 0]);
    positions["max"] = json!([4, 5, 0.6]);
    let positions = tiny.accessor(positions);
    let second = tiny.accessor(of_view(12, "VEC2"));
    let each = |f: &dyn Fn(u32) -> Vec<u8>| (0..count as u32).flat_map(f).collect::<Vec<u8>>();
    let normals = tiny.view(&each(&|v| vec![0, (v % 2) as u8, 127, 0]));
    tiny.json["bufferViews"][normals]["byteStride"] = json!(4);
    let normals = tiny.accessor(json!({"bufferView": normals, "componentType": 5120,
        "normalized": true, "count": count, "type": "VEC3"}));
    let colors = tiny.bytes_accessor("VEC4", 5121, &each(&|v| vec![v as u8, 9, 7, 255]));
    tiny.json["accessors"][colors]["normalized"] = json!(true);
    let custom = tiny.bytes_accessor("VEC2", 5123, &each(&|v| vec![v as u8, 1, 2, 3]));
    let joints = tiny.bytes_accessor("VEC4", 5121, &each(&|v| vec![0, (v % 2) as u8, 0, 0]));
    let weights: Vec<f32> = (0..count)
        .flat_map(|v| {
            if v % 2 == 0 {
                [1., 0., 0., 0.]
            } else {
                [0.25, 0.75, 0., 0.]
            }
        })
        .collect();
    let weights = tiny.floats("VEC4", &weights);
    let moved: Vec<u8> = vec![3, 11, 24, 26];
    let indices = tiny.view(&moved);
    let offsets: Vec<u8> = (0..12).flat_map(|i| (i as f32).to_le_bytes()).collect();
    let values = tiny.view(&offsets);
    let sparse = json!({"count": 4, "indices": {"bufferView": indices, "componentType": 5121},
        "values": {"bufferView": values}});
    let smile = tiny.accessor(
        json!({"componentType": 5126, "count": count, "type": "VEC3",
        "sparse": sparse, "min": [0, 0, 0], "max": [9, 10, 11]}),
    );
    let base = tiny.floats("VEC3", &vec![0.5; count * 3]);
    tiny.json["accessors"][base]["sparse"] = sparse;
    let corner = |x, y| (y * side + x) as u8;
    let squares = (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| (x, y)));
    let corners: Vec<u8> = squares
        .flat_map(|(x, y)| {
            let [a, b, c, d] = [
                corner(x, y),
                corner(x + 1, y),
                corner(x, y + 1),
                corner(x + 1, y + 1),
            ];
            [a, b, c, b, d, c]
        })
        .collect();
    let indices = tiny.bytes_accessor("SCALAR", 5121, &corners);
    tiny.json["meshes"] = json!([{"weights": [0, 0], "extras": {"targetNames": ["smile", "frown"]},
    "primitives": [{
        "attributes": {"POSITION": positions, "NORMAL": normals, "TEXCOORD_1": second,
            "TEXCOORD_0": second, "COLOR_0": colors, "_CUSTOM": custom, "JOINTS_0": joints,
            "WEIGHTS_0": weights},
        "targets": [{"POSITION": smile}, {"POSITION": smile, "NORMAL": base}],
        "indices": indices,
        "extras": {"kept": true},
    }]}]);
    tiny
}

/// Returns the sheet with four levels, and with nodes for them.
pub(crate) fn stored() -> Vec<u8> {
    let mut file = sheet().read().unwrap().value;
    let of = vec![clustered(&file.character.meshes[0], 4)];
    store(&mut file, &of).unwrap();
    file.document.add_level_nodes(2, &table(4), 1.0).unwrap();
    file.document.write_glb().unwrap()
}

fn reread(document: &Document) -> GltfFile {
    let read = read(&document.write_glb().unwrap()).unwrap();
    assert_eq!(read.warnings, []);
    read.value
}

/// Returns the bytes of an accessor's element, with sparse ones resolved.
fn element(document: &Document, accessor: &Value, i: usize) -> Vec<u8> {
    let json = &document.json;
    let accessor = &json["accessors"][accessor.as_u64().unwrap() as usize];
    let parts = match accessor["type"].as_str().unwrap() {
        "SCALAR" => 1,
        other => other[3..].parse().unwrap(),
    };
    let of = |code: &Value| match code.as_u64().unwrap() {
        5120 | 5121 => 1,
        5122 | 5123 => 2,
        _ => 4,
    };
    let size = parts * of(&accessor["componentType"]);
    let at = |owner: &Value, i: usize, size: usize| {
        let view = &json["bufferViews"][owner["bufferView"].as_u64().unwrap() as usize];
        let offset = |o: &Value| o["byteOffset"].as_u64().unwrap_or(0) as usize;
        let stride = view["byteStride"].as_u64().map_or(size, |s| s as usize);
        let start = offset(view) + offset(owner) + i * stride;
        document.buffers[0][start..start + size].to_vec()
    };
    let sparse = &accessor["sparse"];
    for s in (0..sparse["count"].as_u64().unwrap_or(0) as usize).rev() {
        let mut index = at(
            &sparse["indices"],
            s,
            of(&sparse["indices"]["componentType"]),
        );
        index.resize(8, 0);
        if u64::from_le_bytes(index.try_into().unwrap()) == i as u64 {
            return at(&sparse["values"], s, size);
        }
    }
    if accessor.get("bufferView").is_none() {
        return vec![0; size];
    }
    at(accessor, i, size)
}

/// Checks that every array of a primitive is unchanged for each stored vertex.
fn same_arrays(old: (&Document, &Value), new: (&Document, &Value), vertices: &[u32]) {
    let owners = |p: &Value| {
        let targets = p["targets"].as_array().cloned().unwrap_or_default();
        [vec![p["attributes"].clone()], targets].concat()
    };
    let (before, after) = (owners(old.1), owners(new.1));
    assert_eq!(before.len(), after.len());
    for (before, after) in before.iter().zip(&after) {
        let names = |o: &Value| o.as_object().unwrap().keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(before), names(after));
        for name in names(before) {
            for (i, v) in vertices.iter().enumerate() {
                let was = element(old.0, &before[&name], *v as usize);
                assert_eq!(
                    element(new.0, &after[&name], i),
                    was,
                    "{name} of vertex {v}"
                );
            }
        }
    }
}

/// Returns triangles with their lowest corner first, sorted.
fn set(triangles: impl Iterator<Item = [u32; 3]>) -> Vec<[u32; 3]> {
    let turned = |[a, b, c]: [u32; 3]| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap();
    let mut all: Vec<_> = triangles.map(turned).collect();
    all.sort_unstable();
    all
}

/// Checks that a mesh shows at each level the triangles of which the level was made.
fn same_levels(before: &RawMesh, after: &RawMesh, of: &[Clustered], count: usize) {
    assert_eq!(after.clustered.len(), before.primitives.len());
    for (p, (part, object)) in before.primitives.iter().zip(&after.clustered).enumerate() {
        let name = |t: [u32; 3]| t.map(|v| of[p].vertices[v as usize]);
        for (l, level) in levels(part, count).iter().enumerate() {
            let shown = set(object.level(l).map(name));
            assert_eq!(shown, set(level.iter().copied()), "level {l}");
        }
        let new = &after.primitives[p];
        assert_eq!(new.triangles, object.level(0).collect::<Vec<_>>());
        assert_eq!(new.positions, picked(&part.positions, &of[p].vertices));
        assert_eq!(new.normals, picked(&part.normals, &of[p].vertices));
        assert_eq!(new.texcoords, picked(&part.texcoords, &of[p].vertices));
        for (old, new) in part.morphs.iter().zip(&new.morphs) {
            assert_eq!(new.positions, picked(&old.positions, &of[p].vertices));
        }
    }
}

fn picked<T: Copy>(list: &[T], order: &[u32]) -> Vec<T> {
    if list.is_empty() {
        return Vec::new();
    }
    order.iter().map(|v| list[*v as usize]).collect()
}

#[test]
fn every_array_goes_with_its_vertices() {
    let mut file = sheet().read().unwrap().value;
    let before = file.clone();
    let of = vec![clustered(&file.character.meshes[0], 4)];
    store(&mut file, &of).unwrap();
    let primitive = |d: &Document| d.json["meshes"][0]["primitives"][0].clone();
    let (old, new) = (primitive(&before.document), primitive(&file.document));
    assert_eq!(of[0][0].vertices.len(), 25, "two vertices were not used");
    same_arrays(
        (&before.document, &old),
        (&file.document, &new),
        &of[0][0].vertices,
    );
    let after = reread(&file.document);
    same_levels(
        &before.character.meshes[0],
        &after.character.meshes[0],
        &of[0],
        4,
    );
    assert_eq!(after.character.mesh_levels, Some(table(4)));
    assert_eq!(after.character.skeleton, before.character.skeleton);
    // Component types are kept; sparse arrays stay sparse; an array used twice is one.
    let accessor = |slot: &Value| &file.document.json["accessors"][slot.as_u64().unwrap() as usize];
    assert_eq!(
        accessor(&new["attributes"]["NORMAL"])["componentType"],
        5120
    );
    assert_eq!(accessor(&new["attributes"]["COLOR_0"])["normalized"], true);
    assert_eq!(
        new["attributes"]["TEXCOORD_0"],
        new["attributes"]["TEXCOORD_1"]
    );
    assert_eq!(new["targets"][0]["POSITION"], new["targets"][1]["POSITION"]);
    let smile = accessor(&new["targets"][0]["POSITION"]);
    assert_eq!(
        smile["sparse"]["count"], 3,
        "one of four was of an unused vertex"
    );
    assert_eq!(
        smile["max"],
        json!([6.0, 7.0, 8.0]),
        "and it was the greatest"
    );
    assert_eq!(accessor(&new["attributes"]["POSITION"])["max"][1], 4.0);
    assert_eq!(accessor(&new["indices"])["componentType"], 5123);
    assert_eq!(new["extras"], json!({"kept": true}));
    // Unreferenced data was dropped.
    let count = file.document.json["accessors"].as_array().unwrap().len();
    assert_eq!(count, 11 + 3, "three were of no use before");
    let bytes = file.document.buffers[0].len();
    assert!(
        bytes < before.document.buffers[0].len() + 25 * 8 + 600,
        "{bytes}"
    );
}

#[test]
fn storing_again_replaces_and_made_anew_it_is_the_same() {
    let mut file = sheet().read().unwrap().value;
    let of = vec![clustered(&file.character.meshes[0], 4)];
    store(&mut file, &of).unwrap();
    let once = reread(&file.document);
    let anew = Document::from_character(&once.character).unwrap();
    let again = reread(&anew);
    assert_eq!(again.character.meshes, once.character.meshes);
    assert_eq!(again.character.mesh_levels, once.character.mesh_levels);
    // Other levels of the reordered mesh: nothing of the first stays.
    let mut twice = once.clone();
    let of = vec![clustered(&once.character.meshes[0], 4)];
    store(&mut twice, &of).unwrap();
    let sizes = [&once, &twice].map(|f| f.document.write_glb().unwrap().len());
    assert!(sizes[1] <= sizes[0] + 400, "{sizes:?}");
    assert_eq!(
        reread(&twice.document).character.meshes[0].clustered.len(),
        1
    );
}

/// A strip, a fan, triangles without indices, points; and all parts share one vertex array.
#[test]
fn strips_fans_points_and_shared_arrays() {
    let mut tiny = Tiny::new();
    let corners: Vec<f32> = (0..24).map(|i| (i * i % 11) as f32).collect();
    let positions = tiny.floats("VEC3", &corners);
    let strip = tiny.bytes_accessor("SCALAR", 5121, &[0, 1, 2, 3, 4]);
    let fan = tiny.bytes_accessor("SCALAR", 5121, &[7, 6, 5, 4]);
    let attributes = json!({"POSITION": positions});
    tiny.json["meshes"] = json!([{"primitives": [
        {"attributes": attributes, "mode": 0},
        {"attributes": attributes, "mode": 5, "indices": strip},
        {"attributes": attributes, "mode": 6, "indices": fan},
        {"attributes": attributes},
    ]}]);
    tiny.json["nodes"] = json!([{"mesh": 0}]);
    tiny.json["scenes"] = json!([{"nodes": [0]}]);
    let mut file = tiny.read().unwrap().value;
    let before = file.character.meshes[0].clone();
    assert_eq!(before.primitives.len(), 3);
    let of = vec![clustered(&before, 3)];
    store(&mut file, &of).unwrap();
    let primitives = &file.document.json["meshes"][0]["primitives"];
    assert_eq!(primitives[0]["mode"], 0);
    assert_eq!(
        primitives[0]["attributes"],
        json!({"POSITION": 0}),
        "points keep theirs"
    );
    assert!(primitives[1].get("mode").is_none());
    let bytes = file.document.write_glb().unwrap();
    let after = read(&bytes).unwrap().value;
    same_levels(&before, &after.character.meshes[0], &of[0], 3);
    file.document.add_level_nodes(0, &table(3), 1.0).unwrap();
    let coarser = &file.document.json["meshes"][1]["primitives"];
    let modes: Vec<_> = coarser
        .as_array()
        .unwrap()
        .iter()
        .map(|p| &p["mode"])
        .collect();
    assert_eq!(
        modes.last(),
        Some(&&json!(0)),
        "and points are there at every level"
    );
}

/// New clips drop the arrays of the old ones, which renumbers accessors.
#[test]
fn levels_survive_new_clips() {
    let mut tiny = Tiny::skinned();
    let turns = tiny.floats("VEC4", &[0., 0., 0., 1., 0., 1., 0., 0.]);
    tiny.channel(
        json!({"node": 1, "path": "rotation"}),
        "LINEAR",
        &[0., 1.],
        turns,
    );
    // The arrays of the animation come before those of the sheet.
    let animations = tiny.json["animations"].take();
    let mut tiny = sheet_in(tiny);
    tiny.json["animations"] = animations;
    let mut file = tiny.read().unwrap().value;
    let of = vec![clustered(&file.character.meshes[0], 4)];
    store(&mut file, &of).unwrap();
    file.document.add_level_nodes(2, &table(4), 1.0).unwrap();
    let before = reread(&file.document).character;
    let count = |d: &Document| d.json["accessors"].as_array().unwrap().len();
    let accessors = count(&file.document);
    let (joints, meshes) = (file.node_of_joint.clone(), file.node_of_mesh.clone());
    file.document.replace_clips(&[], &joints, &meshes).unwrap();
    assert_eq!(count(&file.document), accessors - 2);
    let after = reread(&file.document).character;
    assert_eq!(after.meshes, before.meshes);
    assert_eq!(after.mesh_levels, before.mesh_levels);
}

#[test]
fn a_mesh_that_two_nodes_show_is_stored_once_if_it_can_be() {
    let mut tiny = sheet();
    let body = tiny.json["nodes"][2].clone();
    tiny.json["nodes"].as_array_mut().unwrap().push(body);
    tiny.json["scenes"][0]["nodes"] = json!([0, 2, 3]);
    let file = tiny.read().unwrap().value;
    assert_eq!(file.node_of_mesh, [2, 3]);
    let of = clustered(&file.character.meshes[0], 4);
    let mut same = file.clone();
    store(&mut same, &[of.clone(), of.clone()]).unwrap();
    assert_eq!(same.document.json["meshes"].as_array().unwrap().len(), 1);
    let mut levels = levels(&file.character.meshes[0].primitives[0], 4);
    levels[3].truncate(1);
    let order = articula_build::ClusterOrder::Store;
    let other = articula_build::cluster(&levels, 27, &[], order).unwrap();
    let mut apart = file.clone();
    store(&mut apart, &[of.clone(), vec![other]]).unwrap();
    assert_eq!(apart.document.json["meshes"].as_array().unwrap().len(), 2);
    let meshes = reread(&apart.document).character.meshes;
    let coarsest = [0, 1].map(|m: usize| meshes[m].clustered[0].clusters.triangles(3));
    assert_ne!(coarsest[0], coarsest[1]);
    assert_eq!(coarsest[1], 1);
}

#[test]
fn what_does_not_fit_is_refused_and_changes_nothing() {
    let mut file = sheet().read().unwrap().value;
    let untouched = file.document.clone();
    let of = clustered(&file.character.meshes[0], 3);
    let mut refused = |node, parts: Vec<_>, levels| {
        let error = file
            .document
            .set_mesh_levels(&table(levels), &[MeshParts { node, parts }]);
        assert_eq!(file.document, untouched);
        error.unwrap_err().to_string()
    };
    let good = part(&of[0]);
    assert!(refused(0, vec![good], 3).starts_with("nodes[0].mesh: "));
    assert!(refused(2, vec![good, good], 3).contains("2 parts, but the file has 1"));
    assert!(refused(2, vec![good], 2).contains("3 levels, the table has 2"));
    let mut far = of[0].vertices.clone();
    far[0] = 27;
    let parts = vec![articula_formats::gltf::PartLevels {
        vertices: &far,
        ..good
    }];
    assert!(refused(2, parts, 3).contains("a vertex index is out of range"));
    let source = &file.character.meshes[0].primitives[0];
    let chunks = articula_build::ClusterOrder::Chunks;
    let chunks = articula_build::cluster(&levels(source, 3), 27, &[], chunks).unwrap();
    assert!(refused(2, vec![part(&chunks)], 3).contains("must be the first range"));
    let mut tiny = sheet();
    tiny.json["meshes"][0]["primitives"][0]["extensions"] = json!({"X_outline": {"indices": 0}});
    let mut file = tiny.read().unwrap().value;
    let error = store(&mut file, &[of]).unwrap_err().to_string();
    assert!(
        error.starts_with("meshes[0].primitives[0].extensions.X_outline: "),
        "{error}"
    );
}

/// Any broken level gives a character without levels, and a warning.
#[test]
fn broken_levels_are_not_believed() {
    let mut file = sheet().read().unwrap().value;
    let of = vec![clustered(&file.character.meshes[0], 3)];
    store(&mut file, &of).unwrap();
    let good = reread(&file.document).character;
    let pointer = "/meshes/0/primitives/0/extensions/ARTICULA_clustered_mesh";
    let breaks: [(&str, Value); 12] = [
        ("/vertices/0", json!(99)),
        ("/vertices/0", json!(1)),
        ("/vertices/2", json!(24)),
        ("/vertices", json!([])),
        ("/vertices", json!(vec![25; 300])),
        ("/clusters/0/first", json!(3)),
        ("/clusters/0/last", json!(-1)),
        ("/clusters/1/triangles", json!(4_294_967_295u32)),
        ("/clusters/0/triangles", json!(0)),
        ("/clusters/0/region", json!(70000)),
        ("/indices", json!(0)),
        ("/indices", json!(9999)),
    ];
    for (member, value) in breaks {
        let mut document = file.document.clone();
        let (owner, key) = member.rsplit_once('/').unwrap();
        let owner = document.json.pointer_mut(&format!("{pointer}{owner}"));
        let owner = owner.unwrap();
        match key.parse::<usize>() {
            Ok(i) => owner[i] = value.clone(),
            Err(_) => owner[key] = value.clone(),
        }
        let read = read(&document.write_glb().unwrap()).unwrap();
        assert!(
            read.value.character.meshes[0].clustered.is_empty(),
            "{member} {value}"
        );
        assert_eq!(
            read.value.character.meshes[0].primitives,
            good.meshes[0].primitives
        );
        assert_eq!(
            read.warnings.len(),
            1,
            "{member} {value}: {:?}",
            read.warnings
        );
    }
    let mut document = file.document.clone();
    document.json["extensions"]["ARTICULA_clustered_mesh"]["levels"][1]["errorRest"]["max"] =
        json!(-1);
    let read = read(&document.write_glb().unwrap()).unwrap();
    assert_eq!(read.warnings.len(), 1);
    assert_eq!(read.value.character.mesh_levels, None);
    assert_eq!(read.value.character.meshes, good.meshes);
}

/// A file of version 1 of the extension, written by the code of that version: a bending tube of
/// 128, 64 and 26 triangles.
const OLD: &[u8] = include_bytes!("../old/clustered-1.glb");

#[test]
fn files_of_version_1_are_read_and_written_as_version_2() {
    let old = read(OLD).unwrap();
    assert_eq!(old.warnings, []);
    let old = old.value.character;
    let clusters = &old.meshes[0].clustered[0].clusters;
    assert_eq!(clusters.vertex_counts(), [72, 39, 16]);
    assert_eq!([0, 1, 2].map(|l| clusters.triangles(l)), [128, 64, 26]);
    let table = old.mesh_levels.as_ref().unwrap();
    let counts = table.levels.iter().map(|l| (l.triangles, l.vertices));
    assert_eq!(counts.collect::<Vec<_>>(), [(128, 72), (64, 39), (26, 16)]);
    assert!(table.errors().is_ok(), "the finest has no error");
    let document = Document::from_character(&old).unwrap();
    let extension = &document.json["extensions"]["ARTICULA_clustered_mesh"];
    assert_eq!(extension["version"], 2);
    assert_eq!(extension["levels"][0]["triangles"], 128);
    let new = reread(&document).character;
    assert_eq!(new.mesh_levels, old.mesh_levels);
    assert_eq!(new.meshes[0].clustered, old.meshes[0].clustered);
    assert_eq!(new.meshes[0].primitives, old.meshes[0].primitives);
}

#[test]
fn both_versions_say_the_same() {
    let mut file = sheet().read().unwrap().value;
    let of = clustered(&file.character.meshes[0], 4);
    let mut levels = table(4);
    levels.regions = vec!["rest".to_owned(), "hands".to_owned()];
    levels.mixable_to = 1;
    let parts = MeshParts {
        node: file.node_of_mesh[0],
        parts: of.iter().map(part).collect(),
    };
    file.document.set_mesh_levels(&levels, &[parts]).unwrap();
    let new = reread(&file.document).character;
    assert_eq!(new.mesh_levels.as_ref().unwrap().mixable_to, 1);
    let name = "ARTICULA_clustered_mesh";
    let as_old = |document: &mut Document| {
        let table = &mut document.json["extensions"][name];
        assert_eq!(table["version"].take(), 2);
        table.as_object_mut().unwrap().remove("version");
        table["levels"].as_array_mut().unwrap().reverse();
        assert_eq!(table["mixableTo"], 1);
        table.as_object_mut().unwrap().remove("mixableTo");
        table["mixableFrom"] = json!(2);
        let stored = &mut document.json["meshes"][0]["primitives"][0]["extensions"][name];
        stored.as_object_mut().unwrap().remove("version");
        stored["vertices"].as_array_mut().unwrap().reverse();
        for cluster in stored["clusters"].as_array_mut().unwrap() {
            let [first, last] = ["first", "last"].map(|k| cluster[k].as_u64().unwrap());
            (cluster["first"], cluster["last"]) = (json!(3 - last), json!(3 - first));
        }
    };
    let mut old = file.document.clone();
    as_old(&mut old);
    assert_eq!(reread(&old).character, new);
    // A primitive states its own version: a rewritten table does not affect it.
    old.json["extensions"][name] = file.document.json["extensions"][name].clone();
    assert_eq!(reread(&old).character, new);
    for pointer in [
        "/extensions/ARTICULA_clustered_mesh",
        "/meshes/0/primitives/0/extensions/ARTICULA_clustered_mesh",
    ] {
        let mut unknown = file.document.clone();
        unknown.json.pointer_mut(pointer).unwrap()["version"] = json!(3);
        let found = read(&unknown.write_glb().unwrap()).unwrap();
        assert!(found.warnings[0].what.contains("version 3"), "{pointer}");
        assert_eq!(found.value.character.mesh_levels, None);
        assert_eq!(
            found.value.character.meshes[0].primitives,
            new.meshes[0].primitives
        );
    }
}

#[test]
fn level_nodes_show_the_same_levels() {
    let mut file = sheet().read().unwrap().value;
    let of = vec![clustered(&file.character.meshes[0], 4)];
    store(&mut file, &of).unwrap();
    let levels = table(4);
    let arrays = file.document.buffers[0].len();
    file.document.add_level_nodes(2, &levels, 1.0).unwrap();
    assert!(
        file.document.buffers[0].len() < arrays + 400,
        "vertices are shared"
    );
    let after = reread(&file.document).character;
    assert_eq!(after.meshes.len(), 1);
    let mesh = &after.meshes[0];
    assert_eq!(mesh.levels.len(), 3);
    for (i, level) in mesh.levels.iter().enumerate() {
        let object = &mesh.clustered[0];
        let shown: Vec<_> = object.level(i + 1).collect();
        let part: &Primitive = &level.primitives[0];
        assert_eq!(part.triangles, shown);
        let prefix = object.clusters.vertices(i + 1) as usize;
        assert_eq!(part.positions, mesh.primitives[0].positions[..prefix]);
        assert_eq!(
            part.weights,
            mesh.primitives[0].weights[..prefix * part.influences]
        );
        let morphs = part.morphs.iter().zip(&mesh.primitives[0].morphs);
        morphs.for_each(|(a, b)| assert_eq!(a.positions, b.positions[..prefix]));
        assert_eq!(level.skin, mesh.skin);
    }
    // 2 mm at one pixel: 500 pixels a metre, a disc of 500 pixels radius on 1920 x 1080.
    let share = std::f32::consts::PI * 500.0 * 500.0 / (1920.0 * 1080.0);
    let expected = [share, share / 4.0, share / 9.0, 0.0];
    let stated =
        std::iter::once(mesh.screen_coverage).chain(mesh.levels.iter().map(|l| l.screen_coverage));
    for (stated, expected) in stated.zip(expected) {
        assert!(
            (stated.unwrap() - expected).abs() < 1e-5,
            "{stated:?} {expected}"
        );
    }
    // A second call adds none; new levels of the mesh remove them.
    let nodes = |f: &GltfFile| f.document.json["nodes"].as_array().unwrap().len();
    let meshes = |f: &GltfFile| reread(&f.document).character.meshes[0].levels.len();
    file.document.add_level_nodes(2, &levels, 1.0).unwrap();
    assert_eq!((nodes(&file), meshes(&file)), (9, 3));
    let mut file = reread(&file.document);
    let of = vec![clustered(&file.character.meshes[0], 2)];
    store(&mut file, &of).unwrap();
    assert_eq!(meshes(&file), 0);
    assert!(
        !file.document.json["extensionsUsed"]
            .to_string()
            .contains("MSFT_lod")
    );
}

/// A level in which a mesh has no triangles ends the chain, and the mesh is not drawn from there
/// on.
#[test]
fn a_mesh_that_vanishes_is_not_drawn_when_small() {
    let mut file = sheet().read().unwrap().value;
    let mut levels = levels(&file.character.meshes[0].primitives[0], 3);
    levels[2].clear();
    let order = articula_build::ClusterOrder::Store;
    let of = articula_build::cluster(&levels, 27, &[], order).unwrap();
    store(&mut file, &[vec![of]]).unwrap();
    file.document.add_level_nodes(2, &table(3), 0.5).unwrap();
    let mesh = &reread(&file.document).character.meshes[0];
    assert_eq!(mesh.levels.len(), 1);
    assert!(mesh.levels[0].screen_coverage > Some(0.0));
}

#[test]
fn real_characters_keep_every_value() {
    let names = [
        "glb/RobotExpressive.glb",
        "glb/KayKit_Knight.glb",
        "glb/mh_female_default163_arkit52.glb",
        "glb/AnimatedMorphCube.glb",
        "glb/viverse/mannequin.glb",
        "vrm/Godette_vrm_v4.vrm",
        "fixtures/msft_lod/SimpleSkinLOD.gltf",
    ];
    for name in names {
        let Some(bytes) = real::bytes(name) else {
            println!("skipped: no data");
            return;
        };
        let mut file = read(&bytes).unwrap().value;
        let before = file.character.clone();
        let of: Vec<_> = before.meshes.iter().map(|m| clustered(m, 5)).collect();
        store(&mut file, &of).unwrap_or_else(|e| panic!("{name}: {e}"));
        let after = read(&file.document.write_glb().unwrap())
            .unwrap()
            .value
            .character;
        assert_eq!(after.clips, before.clips, "{name}");
        assert_eq!(after.skeleton, before.skeleton, "{name}");
        assert_eq!(after.images, before.images, "{name}");
        for ((before, after), of) in before.meshes.iter().zip(&after.meshes).zip(&of) {
            same_levels(before, after, of, 5);
            assert_eq!(after.skin, before.skin, "{name}");
        }
    }
}
