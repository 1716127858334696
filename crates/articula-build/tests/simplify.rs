//! Levels of a mesh: the same on every run, closed where the original is, and no face comes back.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use articula_build::simplify::{LevelTriangles, Simplified, SimplifyOptions, Weighting, simplify};
use articula_core::mesh::{Binding, Mesh, Part};
use glam::{Affine3A, Vec2, Vec3, Vec4};
use std::collections::{BTreeMap, BTreeSet};

/// A mesh of one part whose vertices hang on one joint.
fn mesh(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    let count = positions.len();
    Mesh {
        normals: vec![Vec3::Y; count],
        texcoords: vec![Vec2::ZERO; count],
        colors: vec![Vec4::ONE; count],
        influences: 1,
        binding_indices: vec![0; count],
        weights: vec![1.0; count],
        bindings: vec![Binding {
            joint: 0,
            inverse_bind: Affine3A::IDENTITY,
        }],
        parts: vec![Part {
            name: "all".into(),
            mesh: 0,
            material: None,
            vertices: 0..count,
            triangles: 0..triangles.len(),
        }],
        positions,
        triangles,
        ..Mesh::default()
    }
}

/// A ball of `2 * rings * rings` quads at most, triangulated, with poles.
fn ball(rings: usize) -> Mesh {
    let around = 2 * rings;
    let mut positions = vec![Vec3::Y, -Vec3::Y];
    let angle = |i: usize, of: usize| std::f32::consts::PI * i as f32 / of as f32;
    for r in 1..rings {
        let (s, c) = angle(r, rings).sin_cos();
        for a in 0..around {
            let (z, x) = angle(2 * a, around).sin_cos();
            positions.push(Vec3::new(s * x, c, s * z));
        }
    }
    let at = |r: usize, a: usize| match r {
        0 => 0,
        r if r == rings => 1,
        r => (2 + (r - 1) * around + a % around) as u32,
    };
    let mut triangles = Vec::new();
    for r in 0..rings {
        for a in 0..around {
            let [p, q, s, t] = [at(r, a), at(r, a + 1), at(r + 1, a + 1), at(r + 1, a)];
            triangles.extend([[p, q, s], [p, s, t]]);
        }
    }
    triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    mesh(positions, triangles)
}

/// A flat square of `n * n` quads in the plane y = 0.
fn sheet(n: usize) -> Mesh {
    let point = |i: usize| Vec3::new((i % (n + 1)) as f32, 0.0, (i / (n + 1)) as f32);
    let positions = (0..(n + 1) * (n + 1)).map(point).collect();
    let mut triangles = Vec::new();
    for i in (0..n * (n + 1)).filter(|i| i % (n + 1) < n) {
        let (a, b) = (i as u32, (i + n + 1) as u32);
        triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
    }
    mesh(positions, triangles)
}

fn of(mesh: &Mesh, options: &SimplifyOptions) -> Simplified {
    simplify(mesh, std::slice::from_ref(&mesh.positions), options).unwrap()
}

fn turned([a, b, c]: [u32; 3]) -> [u32; 3] {
    [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap()
}

/// Uses of each directed edge between position classes.
fn edges(found: &Simplified, level: &LevelTriangles) -> BTreeMap<(u32, u32), usize> {
    let mut uses = BTreeMap::new();
    for t in &level.triangles {
        let c = t.map(|v| found.position_classes[v as usize]);
        for k in 0..3 {
            *uses.entry((c[k], c[(k + 1) % 3])).or_default() += 1;
        }
    }
    uses
}

fn is_closed(found: &Simplified, level: &LevelTriangles) -> bool {
    let uses = edges(found, level);
    uses.iter()
        .all(|((a, b), n)| *n == 1 && uses.get(&(*b, *a)) == Some(&1))
}

/// What holds for the levels of any mesh.
fn check(mesh: &Mesh, found: &Simplified, options: &SimplifyOptions) {
    assert_eq!(found.levels.len(), options.targets.len());
    let mut before = BTreeSet::new();
    let mut gone = BTreeSet::<(usize, [u32; 3])>::new();
    let mut vertices: BTreeSet<u32> = (0..mesh.len() as u32).collect();
    for level in found.levels.iter().rev() {
        assert_eq!(level.parts.len(), mesh.parts.len());
        let mut faces = BTreeSet::new();
        let mut next = 0;
        for (p, range) in level.parts.iter().enumerate() {
            assert_eq!(range.start, next);
            next = range.end;
            for t in &level.triangles[range.clone()] {
                assert!(faces.insert((p, turned(*t))), "{t:?} is there twice");
                assert!(
                    t.iter()
                        .all(|v| mesh.parts[p].vertices.contains(&(*v as usize)))
                );
            }
        }
        assert_eq!(next, level.triangles.len());
        assert!(faces.is_disjoint(&gone), "a face comes back");
        gone.extend(before.difference(&faces).copied());
        before = faces;
        let used: BTreeSet<u32> = level.triangles.iter().flatten().copied().collect();
        assert!(used.is_subset(&vertices), "a vertex comes back");
        vertices = used;
    }
}

#[test]
fn a_ball_stays_closed_at_every_level() {
    let mesh = ball(24);
    let options = SimplifyOptions::default();
    let found = of(&mesh, &options);
    check(&mesh, &found, &options);
    let whole = mesh.triangles.len() as f64;
    for (level, share) in found.levels.iter().rev().zip(&options.targets) {
        assert!(is_closed(&found, level));
        let count = level.triangles.len() as f64;
        assert!((share * whole - 3.0..=share * whole + 1.0).contains(&count));
    }
    assert_eq!(found.levels[4].triangles, mesh.triangles);
    assert_eq!(
        of(&mesh, &options),
        found,
        "the same input gives the same levels"
    );
}

#[test]
fn a_flat_sheet_keeps_its_outline() {
    let mesh = sheet(8);
    let options = SimplifyOptions {
        targets: vec![1.0, 0.0],
        ..SimplifyOptions::default()
    };
    let found = of(&mesh, &options);
    check(&mesh, &found, &options);
    // All inner vertices and those along the sides cost nothing, the corners do.
    let area = |l: &LevelTriangles| -> f32 {
        let corners = |t: &[u32; 3]| t.map(|v| mesh.positions[v as usize]);
        let twice = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a).y;
        l.triangles.iter().map(|t| twice(corners(t)) * 0.5).sum()
    };
    let options = SimplifyOptions {
        targets: vec![1.0, 2.0 / 128.0],
        ..options
    };
    let two = of(&mesh, &options);
    assert_eq!(two.levels[0].triangles.len(), 2);
    assert_eq!(area(&two.levels[0]), 64.0);
}

#[test]
fn locked_vertices_stay() {
    let mesh = ball(12);
    let locked: Vec<u32> = (0..mesh.len() as u32).step_by(17).collect();
    let options = SimplifyOptions {
        locked: locked.clone(),
        ..SimplifyOptions::default()
    };
    let found = of(&mesh, &options);
    check(&mesh, &found, &options);
    let used: BTreeSet<u32> = found.levels[0]
        .triangles
        .iter()
        .flatten()
        .copied()
        .collect();
    assert!(locked.iter().all(|v| used.contains(v)));
}

#[test]
fn what_does_not_fit_is_refused() {
    let mesh = ball(4);
    let poses = vec![mesh.positions.clone()];
    let at = |poses: &[Vec<Vec3>], options: &SimplifyOptions| {
        simplify(&mesh, poses, options).unwrap_err().at
    };
    let options = SimplifyOptions::default();
    assert_eq!(at(&[], &options), "poses");
    assert_eq!(at(&[vec![Vec3::ZERO; 3]], &options), "poses[0]");
    let bad = SimplifyOptions {
        locked: vec![1000],
        ..SimplifyOptions::default()
    };
    assert_eq!(at(&poses, &bad), "locked");
    for targets in [vec![], vec![0.5], vec![1.0, 0.3, 0.4], vec![1.0, f64::NAN]] {
        let bad = SimplifyOptions {
            targets,
            ..SimplifyOptions::default()
        };
        assert_eq!(at(&poses, &bad), "targets");
    }
    let bad = SimplifyOptions {
        regions: vec![0; 3],
        weighting: Weighting::Rest,
        ..SimplifyOptions::default()
    };
    assert_eq!(at(&poses, &bad), "regions");
}
