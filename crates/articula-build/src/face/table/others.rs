//! Parts of a head beside the skin and the eyeballs: what is inside of the mouth, and what is attached to
//! the skin.

use super::super::points::{FacePoints, FaceSurface};
use super::graph::{SurfaceGraph, nearest, smooth};
use super::mirror::Mirror;
use articula_core::feature_points::PointId;

/// Distances from the skin, by height of the face, up to which another part is attached to it, and follows
/// the nearest skin if it is attached nowhere.
const ROOT: f32 = 0.006;
const BESIDE: f32 = 0.06;
/// Distance along a part up to which it follows the place where it is attached, by height of the face.
const ATTACHED: f32 = 0.15;
/// Greatest height of a tooth, by height of the face.
const TOOTH: f32 = 0.25;

/// What becomes of the parts beside the skin and the eyeballs.
pub(super) struct Others {
    /// Vertices that follow a row of the skin.
    pub(super) followers: Vec<(u32, usize)>,
    /// Vertices inside of the mouth, ascending, and how much they turn with the lower jaw.
    pub(super) jaw: Vec<(u32, f32)>,
}

impl Others {
    pub(super) fn of(
        surface: &FaceSurface,
        points: &FacePoints,
        vertices: &[u32],
        mirror: &Mirror,
    ) -> Option<Self> {
        let height = points.height();
        let place = |point: PointId| points.get(point).map(|p| p.place);
        let at = |v: u32| surface.positions[v as usize];
        let seam = place((2, 2))?;
        let corners = [place((2, 4))?, place((2, 5))?];
        let mut near = Vec::new();
        let mut inside = Vec::new();
        for vertex in &points.parts.others {
            let p = at(*vertex);
            let is_inside = (p.x - seam.x).abs() < 1.2 * 0.5 * (corners[0].x - corners[1].x)
                && p.z < seam.z
                && (p.y - seam.y).abs() < 0.35 * height;
            if is_inside {
                inside.push(*vertex);
            } else if let Some(row) = nearest(vertices.iter().map(|v| at(*v)), p) {
                near.push((*vertex, row, at(vertices[row]).distance(p) / height));
            }
        }
        let followers = Self::attached(surface, points, &near, mirror);
        let spans = spans(surface, &points.parts.joined, &inside);
        let turned = |vertex: u32| {
            let (low, high) = spans[points.parts.joined[vertex as usize] as usize];
            // A tooth is of one jaw, though it may reach to the other; gums may be of both.
            let y = match high - low < TOOTH * height {
                true => 0.5 * (low + high),
                false => at(vertex).y,
            };
            // What is below turns with the jaw, what is above rests.
            (vertex, smooth(0.5 - (y - seam.y) / (0.04 * height)))
        };
        let jaw = inside.into_iter().map(turned).collect();
        Some(Self { followers, jaw })
    }

    /// The rows that vertices follow: near the skin the nearest one, and beyond it, as at the tips of lashes,
    /// that of the place where their part is attached to the skin. `near` has the nearest row of each vertex
    /// and its distance by the height of the face.
    fn attached(
        surface: &FaceSurface,
        points: &FacePoints,
        near: &[(u32, usize, f32)],
        mirror: &Mirror,
    ) -> Vec<(u32, usize)> {
        let beside: Vec<u32> = near.iter().map(|(v, ..)| *v).collect();
        let triangles = surface.triangles_among(&beside);
        let joined = &points.parts.joined;
        let graph = SurfaceGraph::of(&surface.positions, joined, &triangles, mirror);
        let roots = near.iter().filter(|(.., away)| *away < ROOT);
        let (roots, rows): (Vec<u32>, Vec<usize>) = roots.map(|(v, row, _)| (*v, *row)).unzip();
        let root = graph.nearest(&roots);
        let row = |(vertex, row, away): &(u32, usize, f32)| {
            let (along, root) = root[*vertex as usize];
            if along < ATTACHED * points.height() {
                return Some((*vertex, rows[root]));
            }
            (*away < BESIDE).then_some((*vertex, *row))
        };
        near.iter().filter_map(row).collect()
    }
}

/// Lowest and highest place of the piece that each vertex of some is of, by the first vertex of its place.
fn spans(surface: &FaceSurface, joined: &[u32], of: &[u32]) -> Vec<(f32, f32)> {
    let heights = surface.positions.iter().map(|p| (p.y, p.y));
    let mut spans: Vec<(f32, f32)> = heights.collect();
    let triangles = surface.triangles_among(of).into_iter();
    let triangles: Vec<[u32; 3]> = triangles.map(|t| t.map(|v| joined[v as usize])).collect();
    // A piece is as high as its triangles, which hand on what their neighbours know.
    let mut changed = true;
    while changed {
        changed = false;
        for triangle in triangles.iter().chain(triangles.iter().rev()) {
            let of = triangle.map(|v| spans[v as usize]);
            let low = of.iter().fold(f32::INFINITY, |low, s| low.min(s.0));
            let high = of.iter().fold(f32::NEG_INFINITY, |high, s| high.max(s.1));
            changed |= of.iter().any(|s| *s != (low, high));
            triangle
                .iter()
                .for_each(|v| spans[*v as usize] = (low, high));
        }
    }
    spans
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn pieces_have_one_span() {
        // Two triangles of one piece, given apart, and one of another.
        let at = |y: f32| Vec3::new(0.0, y, 0.0);
        let surface = FaceSurface {
            positions: [0.0, 1.0, 2.0, 3.0, 7.0, 8.0, 9.0].map(at).to_vec(),
            triangles: vec![[4, 5, 6], [1, 2, 3], [0, 1, 2]],
            ..FaceSurface::default()
        };
        let joined: Vec<u32> = (0..7).collect();
        let found = spans(&surface, &joined, &[0, 1, 2, 3, 4, 5]);
        assert_eq!(found[..4], [(0.0, 3.0); 4]);
        // One vertex of the other piece is not of those asked for.
        assert_eq!(found[4..], [(7.0, 7.0), (8.0, 8.0), (9.0, 9.0)]);
    }
}
