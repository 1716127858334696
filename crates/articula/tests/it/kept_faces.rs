//! Mesh levels keep the feature points of a face, and its table in the order of the levels.

use crate::bare::bare;
use crate::real;
use crate::short::shortened;
use articula::face::{add_face_table, face_layout};
use articula::glam::Vec3;
use articula::{
    CharacterFile, ConvertOptions, Executor, Figure, Format, LevelChoice, MeshLevelOptions,
    OpenOptions, PrepareOptions, PreparedAsset, PreparedMeshLevels, ShownLevelOptions, convert, fs,
    open, prepare,
};
use articula_core::source::Primitive;
use std::collections::BTreeSet;

const HEAD: &str = "glb/ict_head_talk_1095.glb";
const TARGETS: [f64; 4] = [1.0, 0.5, 0.25, 0.1];

fn built(head: CharacterFile, keep_face: bool) -> PreparedAsset {
    let options = PrepareOptions {
        mesh_levels: PreparedMeshLevels::New(MeshLevelOptions {
            targets: TARGETS.to_vec(),
            max_error: None,
            keep_face,
            ..MeshLevelOptions::levels(TARGETS.len())
        }),
        ..PrepareOptions::default()
    };
    prepare(head, &options, &Executor::default()).unwrap()
}

fn again(bytes: &[u8]) -> CharacterFile {
    let nothing = &mut |_: &str| Err("nothing lies beside it".into());
    open(bytes, "written.glb", &OpenOptions::default(), nothing).unwrap()
}

/// One level of an asset as a file of its own.
fn level(asset: &PreparedAsset, level: usize) -> CharacterFile {
    let options = ConvertOptions {
        mesh: Some(ShownLevelOptions {
            level: LevelChoice::Whole(level as u16),
            view: None,
        }),
        ..ConvertOptions::default()
    };
    let executor = Executor::default();
    let made = convert(again(&asset.glb), Format::Glb, &options, &executor).unwrap();
    again(&made.written.bytes)
}

fn place(p: Vec3) -> [u32; 3] {
    p.to_array().map(f32::to_bits)
}

#[test]
fn every_level_keeps_the_points_of_a_face() {
    let Some(path) = real::file(HEAD) else {
        return;
    };
    let opened = || shortened(fs::open(&path).unwrap(), 1.0);
    let figure = Figure::new(opened()).unwrap();
    let layout = face_layout(&figure, &[]).unwrap();
    let on_skin = layout.points.iter().filter_map(|p| p.vertex);
    let points: Vec<[u32; 3]> = on_skin
        .map(|v| place(figure.asset.mesh.positions[v as usize]))
        .collect();
    assert!(points.len() > 60);
    let left = |asset: &PreparedAsset, l: usize| {
        let shown = level(asset, l);
        let primitives = shown.character().meshes.iter().flat_map(|m| &m.primitives);
        let used = |p: &Primitive| p.triangles.clone().into_iter().flatten();
        let places: BTreeSet<[u32; 3]> = primitives
            .flat_map(|p| used(p).map(|v| place(p.positions[v as usize])))
            .collect();
        points.iter().filter(|p| places.contains(*p)).count()
    };
    let kept = built(opened(), true);
    let face = kept.mesh_levels.as_ref().unwrap().face.clone().unwrap();
    assert_eq!(face.points, points.len());
    // Its morph targets count by themselves.
    assert!(face.extents.is_empty());
    for l in 0..TARGETS.len() {
        assert_eq!(left(&kept, l), points.len(), "level {l}");
    }
    let free = built(opened(), false);
    assert!(free.mesh_levels.as_ref().unwrap().face.is_none());
    assert!(left(&free, TARGETS.len() - 1) < points.len() / 2);
}

/// Places of the vertices that a morph target moves, with their offsets, in the order of the file.
fn list(primitive: &Primitive, target: usize) -> Vec<[[u32; 3]; 2]> {
    let offsets = primitive.morphs[target].positions.iter();
    let all = primitive.positions.iter().zip(offsets);
    let moved = all.filter(|(_, o)| **o != Vec3::ZERO);
    moved.map(|(p, o)| [place(*p), place(*o)]).collect()
}

#[test]
fn the_table_of_a_coarser_level_is_a_prefix() {
    let Some(mut head) = bare(HEAD) else {
        return;
    };
    // Without morph targets, the table says where the face moves.
    let bare = built(head.clone(), true).mesh_levels.unwrap().face.unwrap();
    let mesh = Figure::new(head.clone()).unwrap().asset.mesh;
    assert_eq!(bare.extents.len(), mesh.len());
    assert!(bare.extents.iter().all(|e| (0.0..=1.0).contains(e)));
    let chin = bare
        .vertices
        .iter()
        .any(|v| bare.extents[*v as usize] == 1.0);
    assert!(chin, "each parameter moves its own point furthest");
    assert!(bare.extents.contains(&0.0), "the neck rests");

    let table = add_face_table(&mut head, &[]).unwrap();
    let asset = built(head, true);
    let whole = again(&asset.glb).into_character();
    let mut lengths = vec![0; TARGETS.len()];
    for (l, length) in lengths.iter_mut().enumerate() {
        let shown = level(&asset, l).into_character();
        assert_eq!(shown.meshes.len(), whole.meshes.len());
        for (a, b) in whole.meshes.iter().zip(&shown.meshes) {
            assert_eq!(a.morph_names, b.morph_names);
            for (finest, coarse) in a.primitives.iter().zip(&b.primitives) {
                for target in 0..finest.morphs.len() {
                    let (mut all, mut own) = (list(finest, target), list(coarse, target));
                    // A file of one level alone orders its vertices anew.
                    all.truncate(own.len());
                    all.sort_unstable();
                    own.sort_unstable();
                    assert_eq!(all, own, "level {l}, target {target}");
                    *length += own.len();
                }
            }
        }
    }
    assert!(table.targets > 50);
    assert!(lengths.is_sorted_by(|a, b| a > b), "{lengths:?}");
}

#[test]
fn an_asset_whose_vertices_are_reordered_gets_the_same_table() {
    let Some(mut head) = bare(HEAD) else {
        return;
    };
    let mut asset = again(&built(head.clone(), true).glb);
    let order = |file: &CharacterFile| file.character().meshes[0].primitives[1].positions.clone();
    assert_ne!(order(&asset), order(&head));
    let tables = [&mut head, &mut asset].map(|file| add_face_table(file, &[]).unwrap());
    assert_eq!(tables[0], tables[1]);
    for (a, b) in head
        .character()
        .meshes
        .iter()
        .zip(&asset.character().meshes)
    {
        for (a, b) in a.primitives.iter().zip(&b.primitives) {
            for target in 0..a.morphs.len() {
                let mut lists = [list(a, target), list(b, target)];
                lists.iter_mut().for_each(|l| l.sort_unstable());
                assert_eq!(lists[0], lists[1], "target {target}");
            }
        }
    }
}
