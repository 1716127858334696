//! Levels of real characters: round trips, and sizes compared with Draco.

use crate::real;
use articula_build::{SimplifyOptions, simplify};
use articula_core::Mesh;
use articula_formats::{Limits, gltf};
use articula_stream::StreamLimits;
use articula_stream::mesh::{
    Grid, Layout, Precision, Quantised, QuantisedMesh, decode_level, encode_level, quantise,
};

/// The first primitive of a character at five levels, finest first, without morph targets, which
/// the compared codecs do not support.
fn levels(name: &str) -> Option<Quantised> {
    let Some(bytes) = real::bytes(name) else {
        println!("skipped: no data");
        return None;
    };
    let mut beside = |uri: &str| Err(format!("{uri} is not here"));
    let read = gltf::read(&bytes, &Limits::default(), &mut beside).unwrap();
    let mut meshes = read.value.character.meshes;
    for part in meshes.iter_mut().flat_map(|m| &mut m.primitives) {
        part.morphs.clear();
    }
    for mesh in &mut meshes {
        mesh.morph_names.clear();
        mesh.morph_weights.clear();
        mesh.levels.clear();
    }
    let whole = Mesh::new(&meshes, 1 << 14).unwrap();
    let poses = std::slice::from_ref(&whole.positions);
    let simplified = simplify(&whole, poses, &SimplifyOptions::default()).unwrap();
    let first = whole.parts[0].vertices.start as u32;
    let part = &meshes[0].primitives[0];
    let lists = simplified.levels.iter().map(|level| {
        let triangles = &level.triangles[level.parts[0].clone()];
        triangles.iter().map(|t| t.map(|v| v - first)).collect()
    });
    let lists: Vec<Vec<[u32; 3]>> = lists.collect();
    let grid = Grid::new(std::slice::from_ref(part), 14).unwrap();
    Some(quantise(part, &lists, &grid, &Precision::default()).unwrap())
}

/// The values of a corner.
type Corner<'a> = ([i32; 3], &'a [(u16, u8)], [i32; 2], [i32; 2]);

/// The faces by value, sorted.
fn faces(mesh: &QuantisedMesh) -> Vec<[Corner<'_>; 3]> {
    let corner = |w: u32| {
        let w = w as usize;
        let p = mesh.wedge_points[w] as usize;
        let normal = mesh.normals.get(w).copied().unwrap_or_default();
        let texcoord = mesh.texcoords.get(w).copied().unwrap_or_default();
        (mesh.positions[p], &mesh.skins[p][..], normal, texcoord)
    };
    let mut faces: Vec<[Corner<'_>; 3]> = mesh
        .faces
        .iter()
        .map(|f| {
            let mut f = f.map(corner);
            let first = (0..3).min_by_key(|&k| &f[k]).unwrap();
            f.rotate_left(first);
            f
        })
        .collect();
    faces.sort_unstable();
    faces
}

/// Size of the coarsest level and all refinements in bytes; each is checked by decoding.
fn whole(levels: &[QuantisedMesh], layout: &Layout) -> usize {
    let limits = StreamLimits::default();
    let coarsest = levels.last().unwrap();
    let bytes = encode_level(None, coarsest, layout).unwrap();
    let mut shown = decode_level(None, &bytes, layout, &limits).unwrap();
    assert_eq!(faces(&shown), faces(coarsest));
    let mut size = bytes.len();
    for pair in levels.windows(2).rev() {
        let [fine, coarse] = [&pair[0], &pair[1]];
        let truth = faces(fine);
        let bytes = encode_level(Some(coarse), fine, layout).unwrap();
        let finer = decode_level(Some(&shown), &bytes, layout, &limits).unwrap();
        assert!(faces(&finer) == truth);
        assert_eq!(finer.positions[..shown.positions.len()], shown.positions);
        assert_eq!(finer.skins[..shown.positions.len()], shown.skins);
        assert_eq!(
            finer.wedge_points[..shown.wedge_points.len()],
            shown.wedge_points
        );
        assert_eq!(finer.normals[..shown.normals.len()], shown.normals);
        assert_eq!(finer.texcoords[..shown.texcoords.len()], shown.texcoords);
        // A level that was received alone is refined by the same bytes to the same mesh.
        let alone = encode_level(None, coarse, layout).unwrap();
        let alone = decode_level(None, &alone, layout, &limits).unwrap();
        let other = decode_level(Some(&alone), &bytes, layout, &limits).unwrap();
        assert!(faces(&other) == truth);
        shown = finer;
        size += bytes.len();
    }
    size
}

/// `draco` and `meshopt` are the sizes of the finest level as measured by the lab: Draco 1.5.7 at
/// its slowest setting with equal quantisation; meshoptimizer's codecs of vertices and indices.
fn check_sizes(name: &str, draco: usize, meshopt: usize) {
    let Some(found) = levels(name) else { return };
    let finest = &found.levels[0];
    let alone = encode_level(None, finest, &found.layout).unwrap();
    let back = decode_level(None, &alone, &found.layout, &StreamLimits::default()).unwrap();
    assert_eq!(faces(&back), faces(finest));
    let whole = whole(&found.levels, &found.layout);
    println!(
        "{name}: alone {}, five levels {whole}, Draco {draco}",
        alone.len()
    );
    // The bounds of `docs/methods/clustered-mesh.md` part 9.
    assert!(alone.len() * 100 <= draco * 105);
    assert!(whole * 100 <= draco * 120);
    assert!(whole * 100 <= alone.len() * 145);
    assert!(whole * 100 <= meshopt * 70);
}

#[test]
fn a_low_body_takes_fewer_bytes_at_all_levels_than_by_draco_at_one() {
    check_sizes("glb/pab_arnaud.glb", 28_119, 55_067);
}

#[test]
fn a_human_takes_fewer_bytes_at_all_levels_than_by_draco_at_one() {
    check_sizes("glb/mh_female_dance.glb", 93_693, 211_601);
}
