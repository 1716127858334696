//! Distances along a surface, by its edges and the diagonals across them.

use super::mirror::Mirror;
use glam::Vec3;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

/// Vertices and the lengths between neighbours. Vertices of one place are one.
#[derive(Debug, Clone)]
pub(in crate::face) struct SurfaceGraph {
    /// First neighbour of each vertex in `links`, and the end.
    first: Vec<u32>,
    links: Vec<(u32, f32)>,
    joined: Vec<u32>,
}

impl SurfaceGraph {
    /// The graph of triangles, with the first vertex of the same place for each vertex, and with the
    /// edges of the other side.
    pub(in crate::face) fn of(
        positions: &[Vec3],
        joined: &[u32],
        triangles: &[[u32; 3]],
        mirror: &Mirror,
    ) -> Self {
        let at = |v: u32| positions[v as usize];
        let triangles = triangles.iter().map(|t| t.map(|v| joined[v as usize]));
        let triangles: Vec<[u32; 3]> = triangles.collect();
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        let mut opposite: HashMap<(u32, u32), Vec<u32>> = HashMap::new();
        for triangle in &triangles {
            for i in 0..3 {
                let (a, b) = (triangle[i], triangle[(i + 1) % 3]);
                let edge = (a.min(b), a.max(b));
                opposite
                    .entry(edge)
                    .or_default()
                    .push(triangle[(i + 2) % 3]);
            }
        }
        for (edge, corners) in &opposite {
            pairs.push(*edge);
            if let [a, b] = corners[..] {
                pairs.push((a.min(b), a.max(b)));
            }
        }
        let twins: Vec<(u32, u32)> = pairs.iter().filter_map(|p| mirror.edge(*p)).collect();
        pairs.extend(twins.into_iter().map(|(a, b)| (a.min(b), a.max(b))));
        pairs.sort_unstable();
        pairs.dedup();
        pairs.retain(|(a, b)| a != b);
        let mut first = vec![0_u32; positions.len() + 1];
        for (a, b) in &pairs {
            first[*a as usize + 1] += 1;
            first[*b as usize + 1] += 1;
        }
        for v in 1..first.len() {
            first[v] += first[v - 1];
        }
        let mut next = first.clone();
        let mut links = vec![(0, 0.0); 2 * pairs.len()];
        for (a, b) in pairs {
            let length = at(a).distance(at(b));
            for (from, to) in [(a, b), (b, a)] {
                links[next[from as usize] as usize] = (to, length);
                next[from as usize] += 1;
            }
        }
        Self {
            first,
            links,
            joined: joined.to_vec(),
        }
    }

    /// Shortest distance of each vertex to the nearest of some; infinite where no path leads.
    pub(in crate::face) fn distances(&self, from: &[u32]) -> Vec<f32> {
        let nearest = self.nearest(from).into_iter();
        nearest.map(|(distance, _)| distance).collect()
    }

    /// The same to the nearest of some places beside the vertices, each given by a vertex and the distance from it.
    pub(super) fn distances_beyond(&self, from: impl Iterator<Item = (u32, f32)>) -> Vec<f32> {
        let starts = from.map(|(vertex, away)| (vertex, away, 0));
        let nearest = self.nearest_of(starts).into_iter();
        nearest.map(|(distance, _)| distance).collect()
    }

    /// Shortest distance of each vertex to the nearest of some, and this one, as its index among them;
    /// infinite where no path leads.
    pub(super) fn nearest(&self, from: &[u32]) -> Vec<(f32, usize)> {
        let starts = from.iter().enumerate();
        self.nearest_of(starts.map(|(index, vertex)| (*vertex, 0.0, index)))
    }

    fn nearest_of(&self, from: impl Iterator<Item = (u32, f32, usize)>) -> Vec<(f32, usize)> {
        let mut found = vec![(f32::INFINITY, 0); self.first.len() - 1];
        // Lengths are not negative, so that their bits are in their order.
        let mut open: BinaryHeap<Reverse<(u32, u32)>> = BinaryHeap::new();
        for (vertex, away, index) in from {
            let vertex = self.joined[vertex as usize];
            if away < found[vertex as usize].0 {
                found[vertex as usize] = (away, index);
                open.push(Reverse((away.to_bits(), vertex)));
            }
        }
        while let Some(Reverse((bits, vertex))) = open.pop() {
            let here = f32::from_bits(bits);
            let (known, index) = found[vertex as usize];
            if here > known {
                continue;
            }
            let range = self.first[vertex as usize]..self.first[vertex as usize + 1];
            for (to, length) in &self.links[range.start as usize..range.end as usize] {
                let there = here + length;
                if there < found[*to as usize].0 {
                    found[*to as usize] = (there, index);
                    open.push(Reverse((there.to_bits(), *to)));
                }
            }
        }
        for vertex in 0..found.len() {
            found[vertex] = found[self.joined[vertex] as usize];
        }
        found
    }
}

/// Smooth step from 0 at 0 to 1 at 1.
pub(in crate::face) fn smooth(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Index of the place nearest to another.
pub(in crate::face) fn nearest(places: impl Iterator<Item = Vec3>, to: Vec3) -> Option<usize> {
    let all = places.map(|p| p.distance_squared(to)).enumerate();
    all.min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(index, _)| index)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_follow_the_surface_and_cross_squares() {
        // Two squares side by side, of 1 m, and a vertex of the first place again at the end.
        let positions = [
            Vec3::ZERO,
            Vec3::X,
            Vec3::new(1.0, 1.0, 0.0),
            Vec3::Y,
            Vec3::new(2.0, 0.0, 0.0),
            Vec3::new(2.0, 1.0, 0.0),
            Vec3::ZERO,
            Vec3::new(9.0, 9.0, 0.0),
        ];
        let triangles = [[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]];
        let joined = [0, 1, 2, 3, 4, 5, 0, 7];
        // Nothing is at its other side.
        let mirror = Mirror::of(&positions, &joined, 100.0);
        let graph = SurfaceGraph::of(&positions, &joined, &triangles, &mirror);
        let nearest = graph.nearest(&[7, 6, 4]);
        assert_eq!([0, 1, 5, 7].map(|v: usize| nearest[v].1), [1, 1, 2, 0]);
        let found = graph.distances(&[6]);
        let root = 2.0_f32.sqrt();
        // Straight edges, the diagonal that is an edge, and a third square's worth beyond it.
        for (vertex, expected) in [(0, 0.0), (1, 1.0), (2, root), (3, 1.0), (4, 2.0), (6, 0.0)] {
            assert!(
                (found[vertex] - expected).abs() < 1e-6,
                "{vertex}: {found:?}"
            );
        }
        // Across the edge from 1 to 2, whose triangles have the corners 0 and 5.
        assert!((found[5] - 5.0_f32.sqrt()).abs() < 1e-6, "{found:?}");
        assert!(found[7].is_infinite());
        // From 1 to 3 across the diagonal that is no edge.
        assert!((graph.distances(&[1])[3] - root).abs() < 1e-6);
    }

    #[test]
    fn steps_are_smooth() {
        assert_eq!(
            [-1.0, 0.0, 0.5, 1.0, 2.0].map(smooth),
            [0.0, 0.0, 0.5, 1.0, 1.0]
        );
    }
}
