//! Mesh levels: deterministic, closed where the original is, without faces that reappear.

mod checks;
mod hostile;
mod seams;
pub(crate) mod shapes;

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
fn levels_between_targets_are_noted_and_change_no_other_one() {
    let mesh = ball(24);
    let without = of(&mesh, &SimplifyOptions::default());
    let options = SimplifyOptions {
        between: 2,
        ..SimplifyOptions::default()
    };
    let found = of(&mesh, &options);
    assert_eq!(found.levels, without.levels);
    assert!(without.between.is_empty());
    // Thirds, on a logarithmic scale, of the ways from 50 to 25, 10 and 1.5 %.
    let shares = [0.397, 0.315, 0.184, 0.136, 0.053, 0.028];
    assert_eq!(found.between.len(), shares.len());
    let whole = mesh.triangles.len() as f64;
    for (level, share) in found.between.iter().zip(shares) {
        assert!(is_closed(&found, level));
        let off = level.triangles.len() as f64 - share * whole;
        assert!((-3.0..=2.0).contains(&off), "{share}: {off}");
    }
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

/// A ball beside another one of a given radius.
fn two_balls(radius: f32) -> (articula_core::Mesh, usize) {
    let (large, small) = (ball(24), ball(6));
    let mut positions = large.positions.clone();
    let beside = |p: &Vec3| *p * radius + Vec3::X * 1.5;
    positions.extend(small.positions.iter().map(beside));
    let first = large.len() as u32;
    let mut triangles = large.triangles.clone();
    triangles.extend(small.triangles.iter().map(|t| t.map(|v| v + first)));
    (shapes::mesh(positions, triangles), large.len())
}

#[test]
fn a_piece_stays_closed_unless_it_is_tiny() {
    let options = SimplifyOptions {
        targets: vec![1.0, 0.005],
        ..SimplifyOptions::default()
    };
    for (radius, stays) in [(0.4, true), (0.01, false)] {
        let (mesh, first) = two_balls(radius);
        let found = of(&mesh, &options);
        let is_small = |t: &&[u32; 3]| t[0] as usize >= first;
        let left = found.levels[1].triangles.iter().filter(is_small).count();
        assert!(is_closed(&found, &found.levels[1]));
        assert_eq!(left >= 4, stays, "{left} triangles of radius {radius}");
    }
}

#[test]
fn vertices_that_morphs_move_keep_more_triangles() {
    let mut mesh = ball(24);
    let is_above = |v: &u32| mesh.positions[*v as usize].y > 0.0;
    let vertices: Vec<u32> = (0..mesh.len() as u32).filter(is_above).collect();
    mesh.morphs = vec![articula_core::Morph {
        slot: 0,
        positions: vec![Vec3::Y * 0.1; vertices.len()],
        normals: vec![Vec3::ZERO; vertices.len()],
        vertices,
    }];
    let options = SimplifyOptions {
        targets: vec![1.0, 0.1],
        ..SimplifyOptions::default()
    };
    // The rest pose alone, so that the displacement itself shapes nothing.
    let found = of(&mesh, &options);
    let height = |t: &[u32; 3]| t.iter().map(|v| mesh.positions[*v as usize].y).sum::<f32>();
    let levels = &found.levels[1].triangles;
    let above = levels.iter().filter(|t| height(t) > 0.0).count();
    let below = levels.len() - above;
    assert!(above * 4 > below * 5, "{above} above, {below} below");
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
    for targets in [
        vec![],
        vec![0.5],
        vec![1.0, 0.3, 0.4],
        vec![1.0, 1.0],
        vec![1.0, -0.1],
        vec![1.0, f64::NAN],
    ] {
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

#[test]
fn meshes_that_contradict_themselves_are_refused() {
    let whole = ball(4);
    let count = whole.len();
    let at = |change: &dyn Fn(&mut articula_core::Mesh)| {
        let mut mesh = whole.clone();
        change(&mut mesh);
        let poses = std::slice::from_ref(&whole.positions);
        simplify(&mesh, poses, &SimplifyOptions::default()).map_err(|e| e.at)
    };
    let refused = |change: &dyn Fn(&mut articula_core::Mesh)| at(change).unwrap_err();
    let morph = |m: &mut articula_core::Mesh, vertex: usize, positions: usize, normals: usize| {
        m.morphs = vec![articula_core::Morph {
            slot: 0,
            vertices: vec![vertex as u32],
            positions: vec![Vec3::Y; positions],
            normals: vec![Vec3::Y; normals],
        }];
    };
    assert!(at(&|m| morph(m, count - 1, 1, 1)).is_ok());
    assert_eq!(refused(&|m| morph(m, count, 1, 1)), "mesh.morphs[0]");
    assert_eq!(refused(&|m| morph(m, 0, 2, 1)), "mesh.morphs[0]");
    assert_eq!(refused(&|m| morph(m, 0, 1, 0)), "mesh.morphs[0]");
    assert_eq!(refused(&|m| m.normals.truncate(3)), "mesh.normals");
    assert_eq!(refused(&|m| m.texcoords.truncate(3)), "mesh.texcoords");
    assert_eq!(refused(&|m| m.colors.truncate(3)), "mesh.colors");
    assert_eq!(refused(&|m| m.weights.truncate(3)), "mesh.weights");
    let bindings = "mesh.binding_indices";
    assert_eq!(refused(&|m| m.binding_indices.truncate(3)), bindings);
    assert_eq!(refused(&|m| m.binding_indices[2] = 1), bindings);
    assert_eq!(refused(&|m| m.influences = 2), "mesh.weights");
    let outside = |m: &mut articula_core::Mesh| m.triangles[3][1] = count as u32;
    assert_eq!(refused(&outside), "mesh.triangles[3]");
    let part = "mesh.parts[0]";
    assert_eq!(refused(&|m| m.parts[0].vertices.end = count + 1), part);
    assert_eq!(refused(&|m| m.parts[0].vertices.start = count + 1), part);
    assert_eq!(refused(&|m| m.parts[0].triangles.start = 1), part);
    assert_eq!(refused(&|m| m.parts[0].triangles.end -= 1), "mesh.parts");
    let second = |m: &mut articula_core::Mesh| {
        m.parts.push(m.parts[0].clone());
        m.parts[1].triangles.end = 5;
    };
    assert_eq!(refused(&second), "mesh.parts[1]");
    let turned = |m: &mut articula_core::Mesh| {
        m.parts.push(m.parts[0].clone());
        let end = m.triangles.len();
        m.parts[1].triangles = std::ops::Range { start: end, end: 5 };
    };
    assert_eq!(refused(&turned), "mesh.parts[1]");
}

#[test]
fn options_have_a_value_for_each_vertex_or_none() {
    let mesh = ball(4);
    let count = mesh.len();
    let at = |options: &SimplifyOptions| {
        let poses = std::slice::from_ref(&mesh.positions);
        simplify(&mesh, poses, options).map_err(|e| e.at)
    };
    let with = |length: usize| {
        let options = SimplifyOptions::default;
        let weights = SimplifyOptions {
            vertex_weights: vec![1.0; length],
            ..options()
        };
        let wedges = SimplifyOptions {
            wedges: vec![1; length],
            ..options()
        };
        [at(&weights), at(&wedges)].map(|found| found.err())
    };
    assert_eq!(with(0), [None, None]);
    assert_eq!(with(count), [None, None]);
    let expected = ["vertex_weights", "wedges"].map(|at| Some(at.to_owned()));
    assert_eq!(with(1), expected);
    let locked = |v: usize| SimplifyOptions {
        locked: vec![v as u32],
        ..SimplifyOptions::default()
    };
    assert!(at(&locked(count - 1)).is_ok());
    assert_eq!(at(&locked(count)).unwrap_err(), "locked");
}
