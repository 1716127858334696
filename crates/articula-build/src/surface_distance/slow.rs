//! Reference implementation of the distance of a point to a surface, for tests; also used by
//! `tests/it/surface_distance.rs`.

use glam::{DVec3, Vec3};
use proptest::prelude::*;

pub(crate) type Triangles = Vec<[u32; 3]>;

/// Closest point by minimising over the plane and all sides, in f64.
fn slow_distance(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let side = |p: DVec3, q: DVec3| {
        let along = (point - p).dot(q - p) / (q - p).length_squared().max(1e-300);
        point.distance(p + (q - p) * along.clamp(0.0, 1.0))
    };
    let sides = side(a, b).min(side(b, c)).min(side(c, a));
    let normal = (b - a).cross(c - a);
    let inside = |p: DVec3, q: DVec3| normal.dot((q - p).cross(point - p)) >= 0.0;
    if normal.length() > 1e-12 && inside(a, b) && inside(b, c) && inside(c, a) {
        sides.min((point - a).dot(normal.normalize()).abs())
    } else {
        sides
    }
}

/// Distance to the closest of the triangles whose corners are finite.
pub(crate) fn slow(point: Vec3, triangles: &[[u32; 3]], positions: &[Vec3]) -> f64 {
    let at = |v: u32| positions[v as usize].as_dvec3();
    let finite = |t: &&[u32; 3]| t.iter().all(|v| positions[*v as usize].is_finite());
    let all = triangles.iter().filter(finite);
    all.map(|t| slow_distance(point.as_dvec3(), t.map(at)))
        .fold(f64::INFINITY, f64::min)
}

/// Random triangles over random points.
pub(crate) fn surface() -> impl Strategy<Value = (Vec<Vec3>, Triangles)> {
    let point = prop::array::uniform3(-1.0f32..1.0).prop_map(Vec3::from_array);
    // Some corners are equal, some triangles degenerate.
    let corner = prop_oneof![9 => point, 1 => Just(Vec3::X)];
    prop::collection::vec(corner, 3..40).prop_flat_map(|points| {
        let vertex = 0..points.len() as u32;
        let triangles = prop::collection::vec(prop::array::uniform3(vertex), 1..60);
        (Just(points), triangles)
    })
}
