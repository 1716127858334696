//! Mesh levels in memory equal those read back from the file.

use crate::reference_human::of_2000;
use articula_build::{
    ClipOptions, LeftOutReason, MeshLevelOptions, MeshLevels, SimplifyOptions, character,
    mesh_level_triangles, mesh_levels,
};
use articula_core::source::Character;
use articula_formats::Limits;
use articula_formats::gltf::{Document, GltfFile, read};
use articula_formats::gltf::{MeshParts, PartLevels};
use glam::Vec3;

fn reread(document: &Document) -> GltfFile {
    let bytes = document.write_glb().unwrap();
    let nothing = &mut |_: &str| Err("a GLB has nothing beside it".into());
    read(&bytes, &Limits::default(), nothing).unwrap().value
}

/// The human, one of its meshes with a morph target and colours, so that all arrays exist.
fn source() -> Character {
    let mut source = of_2000().clone();
    let lips = &mut source.meshes[1];
    lips.morph_names = vec!["smile".to_owned()];
    lips.morph_weights = vec![0.0];
    for primitive in &mut lips.primitives {
        let up = |p: &Vec3| Vec3::Y * (p.x * 0.1);
        let positions = primitive.positions.iter().map(up).collect();
        primitive.morphs = vec![articula_core::source::MorphTarget {
            positions,
            normals: Vec::new(),
        }];
        let color = |p: &Vec3| glam::Vec4::new(p.x.abs(), 0.5, 0.25, 1.0);
        primitive.colors = primitive.positions.iter().map(color).collect();
        primitive.texcoords = primitive.positions.iter().map(|p| p.truncate()).collect();
    }
    source
}

/// Stores the levels in a file, as an exporter does.
fn store(file: &mut GltfFile, made: &MeshLevels) {
    let mut objects = made.objects.iter();
    let mut meshes = Vec::new();
    for (mesh, node) in file.character.meshes.iter().zip(&file.node_of_mesh) {
        let parts = objects.by_ref().take(mesh.primitives.len());
        meshes.push(MeshParts {
            node: *node,
            parts: parts
                .map(|o| PartLevels {
                    vertices: &o.vertices,
                    triangles: &o.triangles,
                    clusters: &o.clusters,
                })
                .collect(),
        });
    }
    file.document.set_mesh_levels(&made.table, &meshes).unwrap();
}

#[test]
fn what_is_in_memory_is_what_is_read_back() {
    let mut file = reread(&Document::from_character(&source()).unwrap());
    let asset = character(&file.character, None, &ClipOptions::default()).unwrap();
    let options = MeshLevelOptions {
        simplify: SimplifyOptions {
            targets: vec![1.0, 0.4, 0.1],
            ..SimplifyOptions::default()
        },
        ..MeshLevelOptions::default()
    };
    let made = mesh_levels(&asset, &options).unwrap();
    let in_memory = made.character(&file.character).unwrap();
    store(&mut file, &made);
    let read_back = reread(&file.document);
    assert_ne!(
        read_back.character.meshes, file.character.meshes,
        "a new order"
    );
    // Part by part first: a difference in the whole is too much to read.
    assert_eq!(read_back.character.mesh_levels, in_memory.mesh_levels);
    for (read, made) in read_back.character.meshes.iter().zip(&in_memory.meshes) {
        for (read, made) in read.clustered.iter().zip(&made.clustered) {
            assert_eq!(read.clusters, made.clusters);
            assert_eq!(read.triangles, made.triangles);
        }
        for (read, made) in read.primitives.iter().zip(&made.primitives) {
            assert_eq!(read.triangles, made.triangles);
            assert_eq!(read.positions, made.positions);
            assert_eq!(read.weights, made.weights);
        }
    }
    assert!(read_back.character == in_memory, "something else differs");
    assert_eq!(read_back.node_of_mesh, file.node_of_mesh);
    assert_eq!(read_back.node_of_joint, file.node_of_joint);
    let of = |c: &Character| character(c, None, &ClipOptions::default()).unwrap();
    let (here, there) = (of(&in_memory), of(&read_back.character));
    assert_eq!(here.mesh, there.mesh);
    assert_eq!(here.clips, there.clips);
}

#[test]
fn levels_of_another_character_are_refused() {
    let source = source();
    let asset = character(&source, None, &ClipOptions::default()).unwrap();
    let options = MeshLevelOptions {
        simplify: SimplifyOptions {
            targets: vec![1.0, 0.5],
            ..SimplifyOptions::default()
        },
        ..MeshLevelOptions::default()
    };
    let made = mesh_levels(&asset, &options).unwrap();
    let mut fewer = source.clone();
    fewer.meshes.pop();
    assert!(made.character(&fewer).is_err());
    let mut smaller = source;
    smaller.meshes[1].primitives[0].positions.truncate(3);
    assert!(made.character(&smaller).is_err());
}

#[test]
fn levels_that_show_nothing_new_or_too_little_are_left_out() {
    let asset = character(&source(), None, &ClipOptions::default()).unwrap();
    let mut options = MeshLevelOptions {
        simplify: SimplifyOptions {
            targets: vec![1.0, 0.4, 0.01, 1e-6, 1e-7, 1e-8],
            ..SimplifyOptions::default()
        },
        ..MeshLevelOptions::default()
    };
    let all = mesh_levels(&asset, &options).unwrap();
    let count = |made: &MeshLevels| made.table.levels.len() + made.left_out.len();
    let falls = |made: &MeshLevels| {
        let mut rows = made.table.levels.windows(2);
        rows.all(|w| w[0].triangles > w[1].triangles && w[1].triangles > 0)
    };
    assert_eq!(count(&all), 6);
    // The last three targets ask for less than one triangle.
    assert!(all.left_out.len() >= 2 && falls(&all));
    let finest = all.table.levels[1].motion.max_metres;
    let coarsest = all.table.levels[2].motion.max_metres;
    assert!(finest < coarsest);
    let size = |axis: fn(Vec3) -> f32| {
        let all = || asset.mesh.positions.iter().map(|p| axis(*p));
        all().fold(f32::MIN, f32::max) - all().fold(f32::MAX, f32::min)
    };
    let size = size(|p| p.x).max(size(|p| p.y)).max(size(|p| p.z));
    options.max_error = Some(0.5 * (finest + coarsest) / size);
    let some = mesh_levels(&asset, &options).unwrap();
    assert_eq!((some.table.levels.len(), count(&some)), (2, 6));
    let reasons = some.left_out.iter().map(|l| l.reason);
    let is_coarse = |r: &LeftOutReason| matches!(r, LeftOutReason::TooCoarse(_));
    assert!(reasons.clone().next().is_some_and(|r| is_coarse(&r)));
    let triangles = mesh_level_triangles(&asset, &options).unwrap();
    assert_eq!(triangles.len(), 2);
}
