//! Seams between parts, textures and regions.

use super::checks::{check, is_closed, of};
use super::shapes::{ball, sheet};
use articula_build::{SimplifyOptions, simplify};
use articula_core::{Mesh, Part};
use glam::{Vec2, Vec3};
use std::collections::BTreeSet;

/// A ball of two parts, above and below the equator, with separate vertices and textures.
fn halves() -> Mesh {
    let whole = ball(24);
    let above = |t: &[u32; 3]| {
        let middle: Vec3 = t.iter().map(|v| whole.positions[*v as usize]).sum();
        middle.y > 0.0
    };
    let count = whole.len();
    let mut mesh = whole.clone();
    mesh.positions.extend(&whole.positions);
    mesh.normals.extend(&whole.normals);
    mesh.texcoords.extend(vec![Vec2::ONE; count]);
    mesh.colors.extend(&whole.colors);
    mesh.binding_indices.extend(&whole.binding_indices);
    mesh.weights.extend(&whole.weights);
    mesh.triangles = whole.triangles.iter().copied().filter(above).collect();
    let split = mesh.triangles.len();
    let below = whole.triangles.iter().filter(|t| !above(t));
    mesh.triangles
        .extend(below.map(|t| t.map(|v| v + count as u32)));
    mesh.parts = vec![
        Part {
            triangles: 0..split,
            ..whole.parts[0].clone()
        },
        Part {
            vertices: count..2 * count,
            triangles: split..mesh.triangles.len(),
            ..whole.parts[0].clone()
        },
    ];
    mesh
}

#[test]
fn parts_that_touch_stay_closed() {
    let mesh = halves();
    let options = SimplifyOptions::default();
    let found = of(&mesh, &options);
    check(&mesh, &found, &options);
    for level in &found.levels {
        assert!(is_closed(&found, level));
        assert!(level.parts.iter().all(|p| !p.is_empty()));
    }
    let count = found.levels[4].triangles.len();
    assert!(count < 60, "{count} triangles");
}

#[test]
fn parts_that_touch_stay_closed_where_their_skins_differ() {
    let mut mesh = halves();
    mesh.bindings.push(mesh.bindings[0]);
    let lower = mesh.parts[1].vertices.clone();
    mesh.binding_indices[lower].fill(1);
    let mut found = of(&mesh, &SimplifyOptions::default());
    // Closed by position, whatever the simplifier holds to be one vertex.
    let bits = |p: &Vec3| p.to_array().map(f32::to_bits);
    let first = |p: &Vec3| mesh.positions.iter().position(|q| bits(q) == bits(p));
    let classes = mesh.positions.iter().map(|p| first(p).unwrap() as u32);
    found.position_classes = classes.collect();
    for level in &found.levels {
        assert!(is_closed(&found, level));
        assert!(level.parts.iter().all(|p| !p.is_empty()));
    }
    let count = found.levels[4].triangles.len();
    assert!(count < 60, "{count} triangles");
}

/// A sheet of two texture charts left and right of x = 4, with a vertex for each side.
fn charted() -> Mesh {
    let mut mesh = sheet(8);
    let count = mesh.len() as u32;
    let right = |t: &[u32; 3], p: &[Vec3]| t.iter().any(|v| p[*v as usize].x > 4.0);
    let positions = mesh.positions.clone();
    for t in &mut mesh.triangles {
        if right(t, &positions) {
            *t = t.map(|v| v + count);
        }
    }
    mesh.positions.extend(&positions);
    mesh.normals = vec![Vec3::Y; 2 * count as usize];
    mesh.texcoords = positions
        .iter()
        .map(|p| Vec2::new(p.x, p.z) * 0.1)
        .collect();
    let moved = mesh.texcoords.clone();
    mesh.texcoords
        .extend(moved.iter().map(|t| *t + Vec2::X * 9.0));
    mesh.colors.extend_from_within(..);
    mesh.binding_indices.extend_from_within(..);
    mesh.weights.extend_from_within(..);
    mesh.parts[0].vertices = 0..2 * count as usize;
    mesh
}

#[test]
fn a_texture_seam_stays_where_it_is() {
    let mesh = charted();
    let options = SimplifyOptions {
        targets: vec![1.0, 4.0 / 128.0],
        ..SimplifyOptions::default()
    };
    let found = of(&mesh, &options);
    check(&mesh, &found, &options);
    // Two triangles for each chart: every face keeps its texture coordinates.
    assert_eq!(found.levels[1].triangles.len(), 4);
    for t in &found.levels[1].triangles {
        let corners = t.map(|v| (mesh.positions[v as usize], mesh.texcoords[v as usize]));
        let right = corners[0].1.x > 5.0;
        for (p, uv) in corners {
            assert_eq!(uv.x > 5.0, right, "one face in two charts");
            assert!(if right { p.x >= 4.0 } else { p.x <= 4.0 });
        }
    }
}

#[test]
fn vertices_between_regions_go_in_the_last_step_only() {
    let mesh = sheet(12);
    let regions: Vec<u8> = mesh.positions.iter().map(|p| u8::from(p.x > 6.5)).collect();
    let options = SimplifyOptions {
        targets: vec![1.0, 0.5, 0.3, 0.01],
        regions: regions.clone(),
        ..SimplifyOptions::default()
    };
    let found = of(&mesh, &options);
    check(&mesh, &found, &options);
    let between: BTreeSet<u32> = mesh
        .triangles
        .iter()
        .filter(|t| {
            t.iter()
                .any(|v| regions[*v as usize] != regions[t[0] as usize])
        })
        .flatten()
        .copied()
        .collect();
    let used = |level: usize| -> BTreeSet<u32> {
        found.levels[level]
            .triangles
            .iter()
            .flatten()
            .copied()
            .collect()
    };
    assert_eq!(between.len(), 26);
    assert!(between.is_subset(&used(1)) && between.is_subset(&used(2)));
    assert!(found.levels[2].triangles.len() < 100);
    assert!(!between.is_subset(&used(3)), "the last step takes them");
}

#[test]
fn every_pose_counts() {
    // Flat at rest; in the other pose a roof with its ridge along x = 4.
    let mesh = sheet(8);
    let roof = |p: &Vec3| Vec3::new(p.x, 4.0 - (p.x - 4.0).abs(), p.z);
    let poses = vec![
        mesh.positions.clone(),
        mesh.positions.iter().map(roof).collect(),
    ];
    let options = SimplifyOptions {
        targets: vec![1.0, 4.0 / 128.0],
        ..SimplifyOptions::default()
    };
    let found = simplify(&mesh, &poses, &options).unwrap();
    check(&mesh, &found, &options);
    let area = |level: &[[u32; 3]]| -> f32 {
        let corners = |t: &[u32; 3]| t.map(|v| poses[1][v as usize]);
        let twice = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a).length();
        level.iter().map(|t| twice(corners(t)) * 0.5).sum()
    };
    let level = &found.levels[1].triangles;
    assert_eq!(level.len(), 4);
    assert!(
        (area(level) - area(&mesh.triangles)).abs() < 1e-3,
        "the ridge is kept"
    );
}
