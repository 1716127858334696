//! Mesh levels: deterministic, closed where the original is, without faces that reappear.

mod checks;
mod hostile;
mod seams;
mod shapes;

use articula_build::{ErrorWeighting, LevelTriangles, SimplifyOptions, simplify};
use checks::{check, is_closed, of};
use glam::Vec3;
use shapes::{ball, sheet};
use std::collections::BTreeSet;

#[test]
fn a_ball_stays_closed_at_every_level() {
    let mesh = ball(24);
    let options = SimplifyOptions::default();
    let found = of(&mesh, &options);
    check(&mesh, &found, &options);
    let whole = mesh.triangles.len() as f64;
    for (level, share) in found.levels.iter().zip(&options.targets) {
        assert!(is_closed(&found, level));
        let count = level.triangles.len() as f64;
        assert!((share * whole - 3.0..=share * whole + 1.0).contains(&count));
    }
    assert_eq!(found.levels[0].triangles, mesh.triangles);
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
    assert_eq!(two.levels[1].triangles.len(), 2);
    assert_eq!(area(&two.levels[1]), 64.0);
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
    let used: BTreeSet<u32> = found.levels[4]
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
        weighting: ErrorWeighting::Rest,
        ..SimplifyOptions::default()
    };
    assert_eq!(at(&poses, &bad), "regions");
}
