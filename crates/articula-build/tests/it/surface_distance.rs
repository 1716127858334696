//! Distances between posed surfaces equal those of the plain, slow method, on random and real
//! shapes.

use crate::reference_human::asset_of_2000;
use crate::slow::{Triangles, slow, surface};
use articula_build::Asset;
use articula_build::{DistanceOptions, LevelDistances, surface_distances};
use articula_build::{PoseOptions, poses, positions};
use articula_core::SurfaceError;
use glam::Vec3;
use proptest::prelude::*;
use std::collections::BTreeMap;

proptest! {
    #[test]
    fn statistics_are_those_of_all_points_and_poses(
        (points, triangles) in surface(),
        pick in prop::collection::vec(any::<bool>(), 60),
        moves in prop::collection::vec(prop::array::uniform3(-0.5f32..0.5), 40 * 3),
    ) {
        let level: Triangles = triangles.iter().zip(&pick).filter(|(_, p)| **p).map(|(t, _)| *t).collect();
        let pose = |k: usize| -> Vec<Vec3> {
            let shifts = moves[40 * k..].iter();
            points.iter().zip(shifts).map(|(p, m)| *p + Vec3::from_array(*m)).collect()
        };
        let motion: Vec<Vec<Vec3>> = (0..3).map(pose).collect();
        let opts = DistanceOptions { face_centres: 0, ..DistanceOptions::default() };
        let found = surface_distances(&triangles, &[&level, &triangles], &points, &motion, &opts).unwrap();
        let same = LevelDistances { poses: vec![SurfaceError::default(); 3], ..LevelDistances::default() };
        prop_assert_eq!(&found[1], &same, "a surface lies on itself");
        let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let mut all = Vec::new();
        for (positions, stated) in motion.iter().zip(&found[0].poses) {
            let of = |v: &u32| slow(positions[*v as usize], &level, positions);
            let distances: Vec<f64> = used.iter().map(of).collect();
            check(&distances, stated)?;
            all.extend(distances);
        }
        if !level.is_empty() {
            check(&all, &found[0].motion)?;
        }
        let means = found[0].poses.iter().map(|p| p.mean_metres).sum::<f32>() / 3.0;
        prop_assert!(level.is_empty() || (found[0].motion.mean_metres - means).abs() < 1e-5);
    }
}

fn check(distances: &[f64], stated: &SurfaceError) -> Result<(), TestCaseError> {
    let max = distances.iter().copied().fold(0.0, f64::max);
    if max == f64::INFINITY {
        prop_assert_eq!(stated.max_metres, f32::INFINITY);
        prop_assert_eq!(stated.p95_metres, f32::INFINITY);
        return Ok(());
    }
    let mut sorted = distances.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |fraction: f64| {
        let place = fraction * (sorted.len() - 1) as f64;
        let (low, high) = (
            sorted[place.floor() as usize],
            sorted[place.ceil() as usize],
        );
        low + (high - low) * place.fract()
    };
    let mean = distances.iter().sum::<f64>() / distances.len() as f64;
    let pairs = [
        (stated.max_metres, max),
        (stated.p99_metres, at(0.99)),
        (stated.p95_metres, at(0.95)),
        (stated.mean_metres, mean),
    ];
    for (stated, wanted) in pairs {
        prop_assert!(
            (f64::from(stated) - wanted).abs() < 5e-3,
            "{} {}",
            stated,
            wanted
        );
    }
    Ok(())
}

#[test]
fn a_folded_square_by_hand() {
    // A square in the ground plane, its middle and a level without the middle.
    let rest = [[0, 0], [2, 0], [2, 2], [0, 2], [1, 1]];
    let rest: Vec<Vec3> = rest
        .iter()
        .map(|[x, z]| Vec3::new(*x as f32, 0.0, *z as f32))
        .collect();
    let full = [[0, 4, 1], [1, 4, 2], [2, 4, 3], [3, 4, 0]];
    let level = [[0, 2, 1], [0, 3, 2]];
    // The middle rises by one: the level stays below it.
    let mut lifted = rest.clone();
    lifted[4].y = 1.0;
    let opts = DistanceOptions {
        face_centres: 0,
        ..DistanceOptions::default()
    };
    let found = surface_distances(&full, &[&level], &rest, &[lifted.clone()], &opts).unwrap();
    assert_eq!(found[0].rest, SurfaceError::default());
    let motion = found[0].motion;
    assert_eq!(motion.max_metres, 1.0);
    assert!((motion.mean_metres - 0.2).abs() < 1e-6, "one of five");
    // At 95 % of the way from the first to the fifth: four fifths between the last two.
    assert!((motion.p95_metres - 0.8).abs() < 1e-6);
    let with_centres = surface_distances(
        &full,
        &[&level],
        &rest,
        &[lifted.clone()],
        &DistanceOptions::default(),
    )
    .unwrap();
    // Four centres at a third of the height.
    assert!((with_centres[0].motion.mean_metres - (1.0 + 4.0 / 3.0) / 9.0).abs() < 1e-6);
    // Back from the level: the diagonal's midpoint is below the tip of a pyramid of slope 45
    // degrees, and the nearest of its sides is half a diagonal away.
    let both = DistanceOptions {
        two_sided: true,
        ..opts
    };
    let found = surface_distances(&full, &[&level], &rest, &[lifted], &both).unwrap();
    assert!((found[0].motion.max_metres - 1.0).abs() < 1e-6);
    // A level that spans a gap is far from the original though the original lies on it.
    let far: Vec<Vec3> = [[0, 0], [1, 0], [0, 1], [5, 0], [6, 0], [5, 1]]
        .iter()
        .map(|[x, y]| Vec3::new(*x as f32, *y as f32, 0.0))
        .collect();
    let (parts, web) = (
        [[0, 1, 2], [3, 4, 5]],
        [[0, 1, 2], [3, 4, 5], [1, 3, 5], [1, 5, 2]],
    );
    let one_way =
        surface_distances(&parts, &[&web], &far, &[], &DistanceOptions::default()).unwrap();
    assert_eq!(one_way[0].rest, SurfaceError::default());
    let both = DistanceOptions {
        two_sided: true,
        ..DistanceOptions::default()
    };
    let found = surface_distances(&parts, &[&web], &far, &[], &both).unwrap();
    assert_eq!(found[0].rest.max_metres, 2.0, "half of a gap of 4 m");
    assert_eq!(found[0].motion, found[0].rest, "no pose");
}

#[test]
fn hostile_surfaces() {
    let points = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::NAN];
    let full: Triangles = vec![[0, 1, 2], [0, 1, 3], [0, 0, 0]];
    let opts = DistanceOptions::default();
    let (none, bad, point): (Triangles, Triangles, Triangles) =
        (vec![], vec![[0, 1, 3]], vec![[0, 0, 0]]);
    let levels: [&[[u32; 3]]; 3] = [&none, &bad, &point];
    let found = surface_distances(
        &full,
        &levels,
        &points,
        std::slice::from_ref(&points),
        &opts,
    )
    .unwrap();
    for empty in &found[..2] {
        let all = [empty.rest, empty.motion, empty.poses[0]];
        for d in all {
            assert_eq!(
                [d.max_metres, d.p99_metres, d.p95_metres, d.mean_metres],
                [f32::INFINITY; 4]
            );
        }
    }
    assert_eq!(found[2].motion.max_metres, 1.0, "a level of one point");
    let nothing = surface_distances(&[], &[&none], &[], &[], &opts).unwrap();
    assert_eq!(nothing[0].rest, SurfaceError::default(), "nothing is off");
    let at = |original: &[[u32; 3]], level: &[[u32; 3]], motion: &[Vec<Vec3>]| {
        surface_distances(original, &[level], &points, motion, &opts)
            .unwrap_err()
            .at
    };
    assert_eq!(at(&[[0, 1, 4]], &none, &[]), "original[0]");
    assert_eq!(at(&full, &[[0, 1, 2], [9, 1, 2]], &[]), "levels[0][1]");
    assert_eq!(at(&full, &none, &[points[1..].to_vec()]), "motion[0]");
}

/// A level made by grid cells: each vertex becomes the first one of its cell.
fn clustered(asset: &Asset, cell_metres: f32) -> Triangles {
    let mut first = BTreeMap::new();
    let representative: Vec<u32> = (0..asset.mesh.len() as u32)
        .map(|v| {
            let cell = (asset.mesh.positions[v as usize] / cell_metres)
                .floor()
                .to_array();
            *first.entry(cell.map(|x| x as i32)).or_insert(v)
        })
        .collect();
    let snapped = asset
        .mesh
        .triangles
        .iter()
        .map(|t| t.map(|v| representative[v as usize]));
    snapped
        .filter(|[a, b, c]| a != b && b != c && c != a)
        .collect()
}

#[test]
fn a_human_in_motion_is_measured_as_the_slow_way_does() {
    let asset = asset_of_2000();
    let found = poses(
        asset,
        &PoseOptions {
            measuring: 3,
            ..PoseOptions::default()
        },
    )
    .unwrap();
    let motion = positions(asset, &found.measuring);
    let rest = positions(asset, &found.shaping[..1]).remove(0);
    let levels = [clustered(asset, 0.05), clustered(asset, 0.1)];
    let original = &asset.mesh.triangles;
    let opts = DistanceOptions {
        face_centres: 0,
        ..DistanceOptions::default()
    };
    let slices: Vec<&[[u32; 3]]> = levels.iter().map(Vec::as_slice).collect();
    let stated = surface_distances(original, &slices, &rest, &motion, &opts).unwrap();
    for (level, stated) in levels.iter().zip(&stated) {
        let mut used: Vec<u32> = original.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        for (positions, stated) in motion.iter().zip(&stated.poses) {
            let of = |v: &u32| slow(positions[*v as usize], level, positions);
            let worst = used.iter().map(of).fold(0.0, f64::max);
            assert!(
                (f64::from(stated.max_metres) - worst).abs() < 1e-4,
                "{worst} {stated:?}"
            );
        }
    }
    assert!(stated[0].motion.mean_metres < stated[1].motion.mean_metres);
    assert!(stated[1].motion.max_metres < 0.2, "cells of 10 cm");
}
