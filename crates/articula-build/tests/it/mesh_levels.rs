//! Mesh levels of a figure of three parts: what they hold, which are left out, how they are stored.

use crate::random_figure::{character_of, flat};
use crate::simplify::shapes::{ball, sheet};
use articula_build::{
    Asset, ClipOptions, LeftOutLevel, LeftOutReason, MeshLevelOptions, MeshLevels, PoseOrigin,
    RegionMix, SimplifyOptions, character, measure_levels, measure_mesh, mesh_level_triangles,
    mesh_levels, poses, positions, simplify, surface_distances,
};
use articula_core::Mesh;
use articula_core::source::{Character, Primitive, RawMesh};
use glam::{Quat, Vec3};
use std::collections::BTreeSet;

/// A primitive whose upper half is on the second joint.
fn primitive(shape: &Mesh, scale: f32, at: Vec3) -> Primitive {
    let upper = |p: &Vec3| u16::from(p.y > 0.0);
    Primitive {
        joints: shape.positions.iter().map(upper).collect(),
        weights: vec![1.0; shape.len()],
        influences: 1,
        positions: shape.positions.iter().map(|p| *p * scale + at).collect(),
        triangles: shape.triangles.clone(),
        ..Primitive::default()
    }
}

/// A figure of the given primitives by mesh. Its second joint bends in its clip.
fn figure(primitives: Vec<Vec<Primitive>>) -> Character {
    let still = (0.0, Vec3::ZERO, Quat::IDENTITY, Vec3::ZERO);
    let bent = (0.0, Vec3::Y * 0.1, Quat::IDENTITY, Vec3::X * 0.1);
    let mut figure = character_of(&[still, bent]);
    let skin = figure.meshes[0].skin.clone();
    let mesh = |(m, primitives)| RawMesh {
        name: format!("mesh {m}"),
        skin: skin.clone(),
        primitives,
        ..RawMesh::default()
    };
    figure.meshes = primitives.into_iter().enumerate().map(mesh).collect();
    figure
}

fn three_parts() -> Character {
    let mut unused = primitive(&ball(10), 0.5, Vec3::ZERO);
    unused.positions.insert(0, Vec3::ONE * 0.2);
    unused.joints.insert(0, 0);
    unused.weights.insert(0, 1.0);
    for t in &mut unused.triangles {
        *t = t.map(|v| v + 1);
    }
    let plate = primitive(&sheet(6), 0.1, Vec3::X);
    let beside = primitive(&ball(6), 0.4, Vec3::new(-1.5, 0.2, 0.3));
    figure(vec![vec![unused, plate], vec![beside]])
}

fn asset(source: &Character) -> Asset {
    let articulation = flat(source.skeleton.joints.len());
    character(source, Some(articulation), &ClipOptions::default()).unwrap()
}

fn options() -> MeshLevelOptions {
    MeshLevelOptions {
        simplify: SimplifyOptions {
            targets: vec![1.0, 0.5, 0.2],
            ..SimplifyOptions::default()
        },
        ..MeshLevelOptions::default()
    }
}

/// The triangles of one primitive after the other as places of corners, in any order.
fn places<'a>(of: impl Iterator<Item = (&'a [Vec3], Vec<[u32; 3]>)>) -> Vec<[[u32; 3]; 3]> {
    let mut all = Vec::new();
    for (positions, triangles) in of {
        let bits = |v: u32| positions[v as usize].to_array().map(f32::to_bits);
        all.extend(triangles.iter().map(|t| {
            let [a, b, c] = t.map(bits);
            [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap()
        }));
    }
    all.sort_unstable();
    all
}

#[test]
fn levels_are_those_of_the_simplifier_with_their_measured_errors() {
    let asset = asset(&three_parts());
    let opts = options();
    let found = mesh_levels(&asset, &opts).unwrap();
    let all = poses(&asset, &opts.poses).unwrap();
    let shaping = positions(&asset, &all.shaping);
    let expected = simplify(&asset.mesh, &shaping, &opts.simplify)
        .unwrap()
        .levels;
    let levels = found.triangles(&asset.mesh);
    assert_eq!(levels.len(), 3);
    assert_eq!(found.table.levels.len(), 3);
    assert_eq!(mesh_level_triangles(&asset, &opts).unwrap(), expected);
    for (l, level) in expected.iter().enumerate() {
        assert_eq!(levels[l], level.triangles);
        for (p, part) in asset.mesh.parts.iter().enumerate() {
            let first = part.vertices.start as u32;
            let own = &level.triangles[level.parts[p].clone()];
            let local: Vec<[u32; 3]> = own.iter().map(|t| t.map(|v| v - first)).collect();
            assert_eq!(found.parts[p][l], local);
        }
        let used: BTreeSet<u32> = level.triangles.iter().flatten().copied().collect();
        let row = &found.table.levels[l];
        assert_eq!(row.triangles, level.triangles.len() as u64);
        assert_eq!(row.vertices, used.len() as u64);
    }
    let coarser: Vec<&[[u32; 3]]> = levels[1..].iter().map(Vec::as_slice).collect();
    let motion = positions(&asset, &all.measuring);
    let original = &asset.mesh.triangles;
    let distances = surface_distances(original, &coarser, &shaping[0], &motion, &opts.distance);
    let distances = distances.unwrap();
    assert_eq!(found.table.levels[0].motion.max_metres, 0.0);
    for (row, distance) in found.table.levels[1..].iter().zip(&distances) {
        assert_eq!((row.rest, row.motion), (distance.rest, distance.motion));
        assert!(row.motion.max_metres > 0.0);
    }
    let (measured, counts) = measure_levels(&asset, &coarser, &opts).unwrap();
    assert_eq!((measured, counts), (distances, found.measured));
    let is_clip = |o: &PoseOrigin| matches!(o, PoseOrigin::Clip { .. });
    let clips = all.measuring.iter().filter(|p| is_clip(&p.origin)).count();
    let is_bend = |o: &PoseOrigin| matches!(o, PoseOrigin::Bend { .. });
    let bends = all.measuring.iter().filter(|p| is_bend(&p.origin)).count();
    assert_eq!(
        (counts.clips, counts.bends, counts.morphs),
        (clips, bends, 0)
    );
    assert!(clips + bends > 0);
    assert!(found.left_out.is_empty());
    // From -1.5 - 0.4 to 1 + 0.6 along x.
    assert!((found.size_metres - 3.5).abs() < 1e-5);
}

#[test]
fn another_mesh_is_measured_against_the_original() {
    let source = three_parts();
    let asset = asset(&source);
    let opts = options();
    let levels = mesh_levels(&asset, &opts).unwrap().triangles(&asset.mesh);
    let shown: Vec<&[[u32; 3]]> = levels.iter().map(Vec::as_slice).collect();
    // The same vertices give what the levels themselves have.
    let (found, _) = measure_mesh(&asset, &asset.mesh, &shown, &opts).unwrap();
    let (own, _) = measure_levels(&asset, &shown, &opts).unwrap();
    for (found, own) in found.iter().zip(&own) {
        assert!((found.motion.max_metres - own.motion.max_metres).abs() < 1e-6);
    }
    // Vertices off by a millimetre are off by at most as much, and somewhere by most of it.
    let mut other = Mesh::clone(&asset.mesh);
    other.positions.iter_mut().for_each(|p| p.x += 1e-3);
    let (found, _) = measure_mesh(&asset, &other, &shown[..1], &opts).unwrap();
    assert!(found[0].motion.max_metres < 1.001e-3 && found[0].motion.max_metres > 0.7e-3);
    other.morph_weights.push(0.0);
    assert!(measure_mesh(&asset, &other, &shown, &opts).is_err());
    let outside = [[u32::MAX; 3]];
    assert!(measure_mesh(&asset, &asset.mesh, &[&outside], &opts).is_err());
}

#[test]
fn the_stored_character_has_all_levels_and_all_vertices() {
    let source = three_parts();
    let asset = asset(&source);
    let levels = mesh_levels(&asset, &options()).unwrap();
    let stored = levels.character(&source).unwrap();
    assert_eq!(stored.mesh_levels.as_ref(), Some(&levels.table));
    assert_eq!(stored.meshes.len(), 2);
    for (mesh, before) in stored.meshes.iter().zip(&source.meshes) {
        assert_eq!((&mesh.name, &mesh.skin), (&before.name, &before.skin));
        assert_eq!(mesh.clustered.len(), mesh.primitives.len());
        for (primitive, whole) in mesh.primitives.iter().zip(&before.primitives) {
            let bits = |p: &Primitive| -> BTreeSet<[u32; 3]> {
                p.positions
                    .iter()
                    .map(|p| p.to_array().map(f32::to_bits))
                    .collect()
            };
            assert_eq!(primitive.positions.len(), whole.positions.len());
            assert_eq!(bits(primitive), bits(whole));
        }
    }
    // The vertex that no triangle uses comes last.
    assert_eq!(
        stored.meshes[0].primitives[0].positions.last(),
        Some(&(Vec3::ONE * 0.2))
    );
    for (l, triangles) in levels.triangles(&asset.mesh).into_iter().enumerate() {
        let expected = places(std::iter::once((&*asset.mesh.positions, triangles)));
        let meshes = stored.meshes.iter();
        let own = meshes.flat_map(|m| m.primitives.iter().zip(&m.clustered));
        let of_level = own.map(|(p, c)| (&*p.positions, c.level(l).collect()));
        assert_eq!(places(of_level), expected);
        if l == 0 {
            let primitives = stored.meshes.iter().flat_map(|m| &m.primitives);
            let shown = primitives.map(|p| (&*p.positions, p.triangles.clone()));
            assert_eq!(places(shown), expected);
        }
        // One level for the whole figure, with the vertices that it uses alone.
        let mix = RegionMix::new(&stored, &[l as u16]).unwrap();
        let one = mix.character(&stored).unwrap();
        assert!(one.mesh_levels.is_none());
        assert!(one.meshes.iter().all(|m| m.clustered.is_empty()));
        let primitives = || one.meshes.iter().flat_map(|m| &m.primitives);
        let shown = primitives().map(|p| (&*p.positions, p.triangles.clone()));
        assert_eq!(places(shown), expected);
        let vertices: usize = primitives().map(|p| p.positions.len()).sum();
        assert_eq!(vertices as u64, levels.table.levels[l].vertices);
    }
}

#[test]
fn other_meshes_than_those_of_the_levels_are_refused() {
    let source = three_parts();
    let levels = mesh_levels(&asset(&source), &options()).unwrap();
    let mut fewer = source.clone();
    fewer.meshes.pop();
    assert_eq!(levels.character(&fewer).unwrap_err().at, "meshes");
    let mut shorter = source.clone();
    shorter.meshes[1].primitives[0].positions.pop();
    assert_eq!(levels.character(&shorter).unwrap_err().at, "meshes[1]");
    assert_eq!(RegionMix::new(&source, &[0]).unwrap_err().at, "meshes");
    let stored = levels.character(&source).unwrap();
    assert!(RegionMix::new(&stored, &[3]).is_err());
}

#[test]
fn levels_that_are_empty_or_equal_are_left_out() {
    let mut one = primitive(&sheet(1), 1.0, Vec3::ZERO);
    one.triangles.truncate(1);
    let mut opts = options();
    opts.simplify.targets = vec![1.0, 0.5, 0.25];
    let found = mesh_levels(&asset(&figure(vec![vec![one]])), &opts).unwrap();
    assert_eq!(found.table.levels.len(), 1);
    let left_out = |target, triangles, reason| LeftOutLevel {
        target,
        triangles,
        reason,
        instead: None,
    };
    // A half of one triangle is rounded up, a quarter down.
    let expected = [
        left_out(0.5, 1, LeftOutReason::Equal),
        left_out(0.25, 0, LeftOutReason::Empty),
    ];
    assert_eq!(found.left_out, expected);
}

#[test]
fn levels_above_the_limit_and_coarser_ones_are_left_out() {
    let asset = asset(&three_parts());
    let mut opts = options();
    opts.simplify.targets = vec![1.0, 0.999_999, 0.6, 0.3, 0.15];
    let all = mesh_levels(&asset, &opts).unwrap();
    let share = |l: usize| {
        let row = &all.table.levels[l];
        row.rest.max_metres.max(row.motion.max_metres) / all.size_metres
    };
    assert!((0..4).all(|l| all.error_share(l) == share(l)));
    assert!(share(1) < share(2));
    assert_eq!(all.left_out.len(), 1);
    let equal = all.left_out[0];
    // A level at the limit is made.
    for (limit, count) in [(share(1), 2), (share(1) * 0.99, 1), (share(3), 4)] {
        opts.max_error = Some(limit);
        let found = mesh_levels(&asset, &opts).unwrap();
        assert_eq!(found.table.levels[..], all.table.levels[..count]);
        assert_eq!(mesh_level_triangles(&asset, &opts).unwrap().len(), count);
        let coarse = (count..4).map(|l| LeftOutLevel {
            target: opts.simplify.targets[l + 1],
            triangles: all.table.levels[l].triangles as usize,
            reason: LeftOutReason::TooCoarse(share(l)),
            instead: None,
        });
        let expected: Vec<LeftOutLevel> = std::iter::once(equal).chain(coarse).collect();
        assert_eq!(found.left_out, expected);
    }
}

#[test]
fn a_level_in_between_is_made_instead_of_one_above_the_limit() {
    let asset = asset(&three_parts());
    let mut opts = options();
    opts.simplify.targets = vec![1.0, 0.6, 0.1];
    let all = mesh_levels(&asset, &opts).unwrap();
    let (fine, coarse) = (all.error_share(1), all.error_share(2));
    assert!(fine < coarse);
    opts.max_error = Some(0.5 * (fine + coarse));
    assert_eq!(mesh_levels(&asset, &opts).unwrap().table.levels.len(), 2);
    opts.halvings = 3;
    let found = mesh_levels(&asset, &opts).unwrap();
    let count = |made: &MeshLevels, level: usize| made.table.levels[level].triangles;
    assert_eq!(found.table.levels.len(), 3);
    assert_eq!(found.table.levels[..2], all.table.levels[..2]);
    assert!(found.error_share(2) <= opts.max_error.unwrap());
    assert!((count(&all, 2) + 1..count(&all, 1)).contains(&count(&found, 2)));
    let left_out = found.left_out.iter();
    let instead: Vec<_> = left_out.map(|l| (l.target, l.instead)).collect();
    assert_eq!(instead, [(0.1, Some(count(&found, 2) as usize))]);
    // Without a limit all targets are made, and nothing else.
    opts.max_error = None;
    assert_eq!(mesh_levels(&asset, &opts).unwrap(), all);
}

#[test]
fn regions_of_a_mix_have_levels_of_their_own() {
    let source = three_parts();
    let asset = asset(&source);
    let mut opts = options();
    let above = |p: &Vec3| u8::from(p.y > 0.0);
    opts.simplify.regions = asset.mesh.positions.iter().map(above).collect();
    let levels = mesh_levels(&asset, &opts).unwrap();
    assert_eq!(
        levels.table.mixable_to, 1,
        "the seam stays until the last step"
    );
    let mut stored = levels.character(&source).unwrap();
    let table = stored.mesh_levels.as_mut().unwrap();
    table.regions = ["lower", "upper"].map(str::to_owned).to_vec();
    let shown = |levels: &[u16]| {
        let mix = RegionMix::new(&stored, levels).unwrap();
        let character = mix.character(&stored).unwrap();
        let primitives = character.meshes.iter().flat_map(|m| &m.primitives);
        places(primitives.map(|p| (&*p.positions, p.triangles.clone())))
    };
    let is_upper = |t: &&[[u32; 3]; 3]| t.iter().all(|p| f32::from_bits(p[1]) > 0.0);
    let is_lower = |t: &&[[u32; 3]; 3]| t.iter().all(|p| f32::from_bits(p[1]) <= 0.0);
    let (fine, coarse, mixed) = (shown(&[0, 0]), shown(&[1, 1]), shown(&[0, 1]));
    assert!(coarse.len() < mixed.len() && mixed.len() < fine.len());
    assert!(
        fine.iter()
            .filter(is_lower)
            .eq(mixed.iter().filter(is_lower))
    );
    assert!(
        coarse
            .iter()
            .filter(is_upper)
            .eq(mixed.iter().filter(is_upper))
    );
    let table = stored.mesh_levels.as_mut().unwrap();
    table.regions.truncate(1);
    // More regions in the clusters than in the table.
    assert_eq!(RegionMix::new(&stored, &[0]).unwrap_err().at, "clusters");
}
