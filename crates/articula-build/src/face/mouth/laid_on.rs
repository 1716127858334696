//! Parts that lie on the skin around the mouth, such as lips of their own or a moustache.

use super::super::points::{FacePoints, FaceSurface};
use super::super::table::{Mirror, SurfaceGraph, nearest, sheet};
use articula_core::feature_points::PointId;
use glam::{Vec2, Vec3};

/// Distances, by height of the face, within which a part is at a point of the outer lips, and a vertex stands for a
/// point of the lips.
const AT_LIPS: f32 = 0.03;
const STANDS: f32 = 0.04;
/// How far a part of one lip may reach across the line between them, by half the width of the mouth.
const ACROSS: f32 = 0.2;
/// Middles of the outer contours.
const MIDDLES: [PointId; 2] = [(8, 1), (8, 2)];

/// The vertices of these parts, each with 0 for the upper sheet to 1 for the lower one. `lips` are vertices of the skin
/// of the upper and of the lower lip, and `flat` unrolls a place that is around the mouth.
pub(super) fn laid_on(
    surface: &FaceSurface,
    points: &FacePoints,
    (mirror, lips): (&Mirror, &[Vec<u32>; 2]),
    flat: impl Fn(Vec3) -> Option<Vec2>,
) -> Vec<(u32, f32)> {
    let at = |v: u32| surface.positions[v as usize];
    let height = points.height();
    let is_other = |v: &u32| points.parts.others.binary_search(v).is_ok();
    // Lips may share places, but no vertices.
    let apart: Vec<u32> = (0..surface.positions.len() as u32).collect();
    let mut found = Vec::new();
    for part in surface.parts(&apart) {
        let places = || part.vertices.iter().map(|v| at(*v));
        let middles = MIDDLES.iter().filter_map(|p| Some(points.get(*p)?.place));
        let is_at_lips = middles.into_iter().any(|middle| {
            let nearest = places()
                .map(|p| p.distance(middle))
                .fold(f32::INFINITY, f32::min);
            nearest < AT_LIPS * height
        });
        if !is_at_lips || !part.vertices.iter().all(is_other) {
            continue;
        }
        let Some(heights) = places()
            .map(|p| Some(flat(p)?.y))
            .collect::<Option<Vec<f32>>>()
        else {
            continue;
        };
        if heights.iter().all(|y| *y > -ACROSS) || heights.iter().all(|y| *y < ACROSS) {
            let lower = if heights.iter().sum::<f32>() > 0.0 {
                0.0
            } else {
                1.0
            };
            found.extend(part.vertices.iter().map(|v| (*v, lower)));
            continue;
        }
        let graph = SurfaceGraph::of(&surface.positions, &apart, &part.triangles, mirror);
        let stands = |of_skin: &u32| {
            let vertex = part.vertices[nearest(places(), at(*of_skin))?];
            (at(vertex).distance(at(*of_skin)) < STANDS * height).then_some(vertex)
        };
        let away = lips.each_ref().map(|lip| {
            let seeds = lip.iter().filter_map(stands);
            graph.distances(&seeds.collect::<Vec<u32>>())
        });
        let lower = |v: &u32| sheet(away[0][*v as usize], away[1][*v as usize], 0.01 * height);
        found.extend(part.vertices.iter().map(|v| (*v, lower(v))));
    }
    found
}
