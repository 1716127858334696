//! Malformed meshes, which occur nevertheless.

use super::checks::{check, of};
use super::shapes::{ball, mesh, sheet};
use articula_build::{SimplifyOptions, simplify};
use articula_core::Mesh;
use glam::Vec3;
use proptest::prelude::*;

fn fine(mesh: &Mesh) -> Vec<usize> {
    let options = SimplifyOptions::default();
    let found = of(mesh, &options);
    check(mesh, &found, &options);
    found.levels.iter().map(|l| l.triangles.len()).collect()
}

#[test]
fn nothing_has_empty_levels() {
    assert_eq!(fine(&Mesh::default()), [0; 5]);
    assert_eq!(fine(&mesh(vec![Vec3::X; 5], vec![])), [0; 5]);
}

#[test]
fn a_triangle_is_kept_as_long_as_levels_ask_for_one() {
    let one = mesh(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]);
    assert_eq!(fine(&one)[..3], [1, 1, 0], "a half of one is rounded up");
}

#[test]
fn copies_and_faces_without_three_corners_are_left_out() {
    let mut twice = ball(8);
    let count = twice.triangles.len();
    let copies: Vec<[u32; 3]> = twice
        .triangles
        .iter()
        .map(|[a, b, c]| [*b, *c, *a])
        .collect();
    twice.triangles.extend(copies);
    twice.triangles.extend([[3, 3, 4], [5, 5, 5]]);
    twice.parts[0].triangles = 0..twice.triangles.len();
    let levels = fine(&twice);
    assert_eq!(levels[0], count);
    assert!(levels[4] <= 8);
}

#[test]
fn both_sides_of_a_sheet_are_one_surface() {
    let mut both = sheet(8);
    let back: Vec<[u32; 3]> = both
        .triangles
        .iter()
        .map(|[a, b, c]| [*a, *c, *b])
        .collect();
    both.triangles.extend(back);
    both.parts[0].triangles = 0..both.triangles.len();
    let options = SimplifyOptions {
        targets: vec![1.0, 4.0 / 256.0],
        ..SimplifyOptions::default()
    };
    let found = of(&both, &options);
    check(&both, &found, &options);
    assert_eq!(found.levels[1].triangles.len(), 4, "two on each side");
    let corners = [0u32, 8, 72, 80];
    let used = |v: &u32| found.levels[1].triangles.iter().flatten().any(|w| w == v);
    assert!(corners.iter().all(used), "the outline is kept");
}

#[test]
fn triangles_with_vertices_of_their_own_are_one_surface() {
    let ball = ball(16);
    let corners = ball.triangles.iter().flatten();
    let positions = corners.map(|v| ball.positions[*v as usize]).collect();
    let count = ball.triangles.len() as u32;
    let triangles = (0..count).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let mut soup = mesh(positions, triangles);
    let shared = fine(&ball);
    assert_eq!(fine(&soup), shared);
    // Separate normals for every face, as in flat shading, do not stop it either.
    for t in soup.triangles.clone() {
        let [a, b, c] = t.map(|v| soup.positions[v as usize]);
        let normal = (b - a).cross(c - a).normalize();
        for v in t {
            soup.normals[v as usize] = normal;
        }
    }
    let flat = fine(&soup);
    assert!(
        flat.iter().zip(&shared).all(|(a, b)| a.abs_diff(*b) <= 2),
        "{flat:?}"
    );
}

#[test]
fn vertices_that_are_nowhere_stay() {
    let mut holed = ball(12);
    holed.positions[40] = Vec3::NAN;
    holed.positions[90] = Vec3::INFINITY;
    let options = SimplifyOptions::default();
    let found = of(&holed, &options);
    check(&holed, &found, &options);
    assert!(found.levels[4].triangles.iter().flatten().any(|v| *v == 40));
    assert!(found.levels[4].triangles.len() < 60);
    fine(&mesh(vec![Vec3::NAN; 3], vec![[0, 1, 2]]));
}

#[test]
fn huge_tiny_and_flat_surfaces_come_to_an_end() {
    for scale in [0.0, 1e-38, 1e-20, 1e18, 1e38] {
        let mut scaled = ball(10);
        for p in &mut scaled.positions {
            *p *= scale;
        }
        fine(&scaled);
    }
    let line = (0..200).map(|i| Vec3::X * i as f32).collect();
    fine(&mesh(line, (0..198).map(|i| [i, i + 1, i + 2]).collect()));
}

#[test]
fn hubs_and_books_of_many_faces_take_no_longer_for_it() {
    let rim = 60_000u32;
    let angle = |i: u32| std::f32::consts::TAU * i as f32 / rim as f32;
    let mut points = vec![Vec3::ZERO];
    points.extend((0..rim).map(|i| Vec3::new(angle(i).cos(), 0.0, angle(i).sin())));
    let fan = (0..rim).map(|i| [0, 1 + (i + 1) % rim, 1 + i]).collect();
    let levels = fine(&mesh(points.clone(), fan));
    assert!(levels[4] < 1000, "{levels:?}");
    let book = (2..rim).map(|i| [0, 1, i]).collect();
    fine(&mesh(points, book));
}

/// Triangles over few points of a coarse grid, so that they share corners, edges and positions.
fn tangle() -> impl Strategy<Value = (Mesh, Vec<Vec3>)> {
    let point = prop_oneof![
        20 => (0i8..4, 0i8..4, 0i8..3).prop_map(|(x, y, z)| {
            Vec3::new(f32::from(x), f32::from(y), f32::from(z))
        }),
        1 => Just(Vec3::NAN),
    ];
    let points = proptest::collection::vec((point, 0u8..2, -1.0f32..1.0), 3..40);
    points.prop_flat_map(|points| {
        let count = points.len() as u32;
        let corner = 0..count;
        let triangles = proptest::collection::vec([corner.clone(), corner.clone(), corner], 0..150);
        triangles.prop_map(move |triangles| {
            let mut mesh = mesh(points.iter().map(|p| p.0).collect(), triangles);
            for (v, (_, kind, _)) in points.iter().enumerate() {
                mesh.texcoords[v].x = f32::from(*kind);
            }
            let pose = points.iter().map(|p| p.0 + Vec3::Y * p.2).collect();
            (mesh, pose)
        })
    })
}

proptest! {
    #[test]
    fn any_tangle_has_levels((mesh, pose) in tangle(), locked in any::<prop::sample::Index>()) {
        let locked = locked.index(mesh.len()) as u32;
        let options = SimplifyOptions {
            targets: vec![1.0, 0.6, 0.3, 0.0],
            locked: vec![locked],
            ..SimplifyOptions::default()
        };
        let poses = [mesh.positions.clone(), pose];
        let found = simplify(&mesh, &poses, &options).unwrap();
        check(&mesh, &found, &options);
        prop_assert_eq!(&simplify(&mesh, &poses, &options).unwrap(), &found);
        let counts: Vec<usize> = found.levels.iter().map(|l| l.triangles.len()).collect();
        prop_assert!(counts.is_sorted_by(|a, b| a >= b));
    }
}
