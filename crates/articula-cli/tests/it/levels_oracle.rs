//! Levels stored in files, checked by other programs: the Khronos validator checks the files, JSON
//! schemas the extension, three.js the shown levels.

use crate::judges::{ask, judges_are_here};
use crate::program::{folder, json};
use crate::real;
use crate::thinned;
use articula::build::Clustered;
use articula::formats::Limits;
use articula::formats::gltf::{self, GltfFile};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Characters with skins and morph targets, sparse, quantised and shared arrays.
const CHARACTERS: &[&str] = &[
    "glb/pab_arnaud.glb",
    "glb/Quaternius_platformer_game_pack__Character.glb",
    "glb/RobotExpressive.glb",
    "glb/MorphStressTest.gltf",
    "glb/mh_female_default163_arkit52.glb",
    "glb/AnimatedMorphCube.glb",
    "vrm/Godette_vrm_v4.vrm",
    "fixtures/msft_lod/SimpleSkinLOD.gltf",
];

const LEVELS: usize = 4;

/// A file, the levels of its meshes, and how they are stored.
struct Stored {
    file: GltfFile,
    of: Vec<Vec<Clustered>>,
    stored: PathBuf,
    nodes: PathBuf,
}

fn store(name: &str) -> Option<Stored> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("stored-levels");
    std::fs::create_dir_all(&folder).unwrap();
    let bytes = real::bytes(name)?;
    let mut alone = |uri: &str| Err(format!("{uri} is not needed"));
    let file = gltf::read(&bytes, &Limits::default(), &mut alone).unwrap();
    let file = file.value;
    let meshes = file.character.meshes.iter();
    let of: Vec<_> = meshes.map(|m| thinned::clustered(m, LEVELS)).collect();
    let mut changed = file.clone();
    thinned::store(&mut changed, &of).unwrap();
    let stem = Path::new(name).file_stem().unwrap().to_string_lossy();
    let [stored, nodes] = ["stored", "nodes"].map(|how| folder.join(format!("{stem}.{how}.glb")));
    std::fs::write(&stored, changed.document.write_glb().unwrap()).unwrap();
    for node in &file.node_of_mesh {
        let table = thinned::table(LEVELS);
        changed
            .document
            .add_level_nodes(*node, &table, 1.0)
            .unwrap();
    }
    std::fs::write(&nodes, changed.document.write_glb().unwrap()).unwrap();
    Some(Stored {
        file,
        of,
        stored,
        nodes,
    })
}

fn word(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

#[test]
fn stored_levels_are_valid_and_keep_to_the_schema() {
    if !judges_are_here() {
        return;
    }
    let stored: Vec<_> = CHARACTERS.iter().filter_map(|name| store(name)).collect();
    let files = stored
        .iter()
        .flat_map(|s| [word(&s.stored), word(&s.nodes)]);
    let files: Vec<String> = files.collect();
    let (verdict, good) = ask("validate.mjs", &files);
    assert!(good, "{verdict}");
    let schemas = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/formats");
    let (verdict, good) = ask("schemas.mjs", &[vec![word(&schemas)], files].concat());
    assert!(good, "{verdict}");
    let verdict: Value = serde_json::from_str(&verdict).unwrap();
    for (files, stored) in verdict.as_array().unwrap().chunks(2).zip(&stored) {
        // The document and every primitive; a mesh used by two nodes is stored once.
        let primitives: usize = stored.of.iter().map(Vec::len).sum();
        let judged = files[0]["judged"].as_u64().unwrap() as usize;
        assert!((2..=primitives + 1).contains(&judged), "{files:?}");
    }
}

/// Every mix of levels that a file allows is an ordinary valid file, and three.js shows its
/// triangles.
#[test]
fn mixes_of_levels_are_valid_and_shown() {
    if !judges_are_here() {
        return;
    }
    let here = folder("levels-mixes");
    let mut files = Vec::new();
    for name in ["glb/pab_arnaud.glb", "vrm/Godette_vrm_v4.vrm"] {
        let Some(mut file) = real::file(name) else {
            continue;
        };
        if name.ends_with("arnaud.glb") {
            // Its longest clips would be most of the time.
            let cut = ["convert", &word(&file), "cut.glb", "--clip", "jog"];
            json(&here, &[&cut[..], &["--trim", "..0.2"]].concat());
            file = here.join("cut.glb");
        }
        let stem = Path::new(name).file_stem().unwrap().to_string_lossy();
        let built = format!("{stem}.built.glb");
        let words = ["--levels", "3", "--split", "face,hands"];
        json(
            &here,
            &[&["build", &word(&file), &built], &words[..]].concat(),
        );
        let found = json(&here, &["inspect", &built]);
        let mixable = found["mesh_levels"]["mixable_to"].as_u64().unwrap();
        let last = found["mesh_levels"]["levels"].as_array().unwrap().len() as u64 - 1;
        assert!(mixable > 0, "{name}: no mix is allowed");
        let pairs = (0..=mixable).flat_map(|a| (0..=mixable).map(move |b| (a, b)));
        for (head, rest) in pairs.chain([(last, last)]) {
            let out = format!("{stem}.{head}{rest}.glb");
            let levels = format!("face={head},rest={rest}");
            let made = json(&here, &["convert", &built, &out, "--mesh-level", &levels]);
            files.push((here.join(&out), made["mesh"]["triangles"].as_u64().unwrap()));
        }
    }
    let names: Vec<String> = files.iter().map(|(path, _)| word(path)).collect();
    let (verdict, good) = ask("validate.mjs", &names);
    assert!(good, "{verdict}");
    for (path, triangles) in &files {
        // A part that vanishes keeps one triangle of three equal corners.
        assert_eq!(drawn(path), *triangles, "{}", path.display());
    }
}

/// Number of triangles that three.js draws, without those of three equal corners.
fn drawn(path: &Path) -> u64 {
    let mut count = 0;
    for primitive in primitives(path) {
        let corners = primitive["indices"].as_array().unwrap().iter();
        let corners: Vec<u64> = corners.map(|i| i.as_u64().unwrap()).collect();
        let triangles = corners.as_chunks::<3>().0.iter();
        count += triangles.filter(|[a, b, c]| a != b || b != c).count() as u64;
    }
    count
}

/// What three.js says of each primitive, in the order of the nodes.
fn primitives(path: &Path) -> Vec<Value> {
    let (answer, good) = ask("skinned_positions.mjs", &[word(path)]);
    assert!(good, "{answer}");
    let list: Value = serde_json::from_str(&answer).unwrap();
    list.as_array().unwrap().clone()
}

/// Flat positions of each primitive, in the order of the nodes.
fn shown(path: &Path) -> Vec<Vec<[f64; 3]>> {
    let list = primitives(path);
    list.iter().map(|p| triples(&p["positions"])).collect()
}

fn triples(numbers: &Value) -> Vec<[f64; 3]> {
    let numbers = numbers.as_array().unwrap().iter();
    let numbers: Vec<f64> = numbers.map(|x| x.as_f64().unwrap()).collect();
    numbers.as_chunks::<3>().0.to_vec()
}

/// Triangles with the lowest corner first, sorted.
fn set(corners: &[[f64; 3]]) -> Vec<[[u64; 3]; 3]> {
    let bits = |p: &[f64; 3]| p.map(|x| (x + 0.0).to_bits());
    let turned = |t: &[[f64; 3]; 3]| {
        let [a, b, c] = [bits(&t[0]), bits(&t[1]), bits(&t[2])];
        [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap()
    };
    let mut all: Vec<_> = corners.as_chunks::<3>().0.iter().map(turned).collect();
    all.sort_unstable();
    all
}

/// Every level consists of corners of the original, bit by bit in three.js; viewers without the
/// extension show the original.
#[test]
fn three_js_shows_every_level() {
    if !judges_are_here() {
        return;
    }
    for name in ["glb/pab_arnaud.glb", "glb/KayKit_Knight.glb"] {
        let Some(stored) = store(name) else { continue };
        let original = shown(&real::file(name).unwrap());
        let plain = shown(&stored.stored);
        let (answer, good) = ask("levels.mjs", &[word(&stored.stored)]);
        assert!(good, "{answer}");
        let levels: Value = serde_json::from_str(&answer).unwrap();
        let levels = levels.as_array().unwrap();
        let meshes = stored.file.character.meshes.iter().zip(&stored.of);
        let parts = meshes.flat_map(|(m, of)| m.primitives.iter().zip(of));
        let parts: Vec<_> = parts.collect();
        assert_eq!(
            (parts.len(), original.len()),
            (levels.len(), levels.len()),
            "{name}"
        );
        for (i, (part, of)) in parts.into_iter().enumerate() {
            for (vertex, place) in of.vertices.iter().zip(&plain[i]) {
                assert_eq!(original[i][*vertex as usize], *place, "{name}");
            }
            for (l, level) in thinned::levels(part, LEVELS).iter().enumerate() {
                let corner = |v: &u32| original[i][*v as usize];
                let expected: Vec<_> = level.as_flattened().iter().map(corner).collect();
                let drawn = triples(&levels[i]["corners"][l]);
                assert!(set(&drawn) == set(&expected), "{name} part {i} level {l}");
                let groups = levels[i]["groups"][l].as_u64().unwrap() as usize;
                assert_eq!(groups, of.clusters.ranges(l).count());
            }
        }
    }
}
