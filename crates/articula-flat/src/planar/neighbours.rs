//! Triangles across the edges of a triangle.

use super::clip::PlanarClip;
use glam::Vec2;

/// Edges with more triangles than this on the other side have no neighbours.
const MAX_NEIGHBOURS: usize = 8;

/// A triangle across an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Neighbour {
    /// The triangle.
    pub(crate) triangle: u32,
    /// Index of the corner that is not on the edge.
    pub(crate) apex: u32,
}

/// Triangles across each edge of a triangle; edge `e` runs from corner `e` to the next. Vertices
/// are joined by position class, and the two triangles must have the same winding.
#[derive(Debug, Clone)]
pub(crate) struct Neighbours {
    /// Position class of each vertex.
    pub(crate) class: Vec<u32>,
    /// Index of the first entry of each edge `3 t + e`, and the end.
    first: Vec<u32>,
    entries: Vec<Neighbour>,
}

impl Neighbours {
    pub(crate) fn new(clip: &PlanarClip) -> Self {
        let class = clip.position_classes();
        let ends = |t: usize, e: usize| {
            let corners = clip.triangles[t];
            (
                class[corners[e] as usize],
                class[corners[(e + 1) % 3] as usize],
            )
        };
        let all = || (0..clip.triangles.len()).flat_map(|t| (0..3).map(move |e| (t, e)));
        let mut edges: Vec<((u32, u32), Neighbour)> = all()
            .map(|(t, e)| {
                let triangle = t as u32;
                let apex = (e as u32 + 2) % 3;
                (ends(t, e), Neighbour { triangle, apex })
            })
            .collect();
        edges.sort_by_key(|(ends, n)| (*ends, n.triangle));
        let (mut first, mut entries) = (vec![0], Vec::new());
        for (t, e) in all() {
            let (a, b) = ends(t, e);
            let from = edges.partition_point(|(ends, _)| *ends < (b, a));
            let to = edges.partition_point(|(ends, _)| *ends <= (b, a));
            if a != b && to - from <= MAX_NEIGHBOURS {
                entries.extend(edges[from..to].iter().map(|(_, n)| *n));
            }
            first.push(entries.len() as u32);
        }
        Self {
            class,
            first,
            entries,
        }
    }

    pub(crate) fn across(&self, triangle: usize, edge: usize) -> &[Neighbour] {
        let i = 3 * triangle + edge;
        &self.entries[self.first[i] as usize..self.first[i + 1] as usize]
    }
}

impl Neighbour {
    /// How far the triangle reaches beyond an edge, a triangle and the corner at which it starts;
    /// pixels, 0 if it does not face the viewer.
    pub(super) fn height(
        self,
        clip: &PlanarClip,
        frame: usize,
        (triangle, edge): (usize, usize),
    ) -> f32 {
        let places = clip.places(frame, self.triangle as usize);
        if !faces_viewer(&places) {
            return 0.0;
        }
        let corners = clip.places(frame, triangle);
        let apex = places[self.apex as usize];
        outward(&corners, edge).dot(apex - corners[edge]).max(0.0)
    }
}

/// Whether corners run counter-clockwise to the viewer (y points down).
pub(crate) fn faces_viewer([a, b, c]: &[Vec2; 3]) -> bool {
    (*b - *a).perp_dot(*c - *a) < 0.0
}

/// Outward unit normal of an edge; zero if the edge has no length.
pub(super) fn outward(corners: &[Vec2; 3], edge: usize) -> Vec2 {
    let along = corners[(edge + 1) % 3] - corners[edge];
    Vec2::new(-along.y, along.x).normalize_or_zero()
}
