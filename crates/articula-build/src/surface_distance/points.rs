//! The points of a surface at which distances are measured.

use super::DistanceOptions;
use crate::points::draw_vertices;
use glam::Vec3;

/// Points on a surface: vertices, and means of two or three of them.
#[derive(Debug, Clone, Default)]
pub(super) struct Points {
    pub(super) vertices: Vec<u32>,
    edges: Vec<[u32; 2]>,
    centres: Vec<[u32; 3]>,
}

impl Points {
    /// Vertices that triangles use, and face centres.
    pub(super) fn of(triangles: &[[u32; 3]], vertices: usize, opts: &DistanceOptions) -> Self {
        let mut is_used = vec![false; vertices];
        for v in triangles.iter().flatten() {
            is_used[*v as usize] = true;
        }
        let used: Vec<u32> = (0..vertices as u32)
            .filter(|v| is_used[*v as usize])
            .collect();
        let some = |total, count| draw_vertices(total, count, opts.seed);
        let vertices = some(used.len(), opts.vertices);
        let centres = some(triangles.len(), opts.face_centres);
        Self {
            vertices: vertices.iter().map(|i| used[*i as usize]).collect(),
            edges: Vec::new(),
            centres: centres.iter().map(|t| triangles[*t as usize]).collect(),
        }
    }

    /// Adds the vertices of triangles, each once.
    pub(super) fn add_corners(&mut self, triangles: &[[u32; 3]]) {
        self.vertices.extend(triangles.as_flattened());
        self.vertices.sort_unstable();
        self.vertices.dedup();
    }

    /// Adds face centres and edge midpoints.
    pub(super) fn add_triangles(&mut self, triangles: &[[u32; 3]]) {
        self.centres.extend(triangles);
        for [a, b, c] in triangles {
            self.edges.extend([[*a, *b], [*b, *c], [*c, *a]]);
        }
    }

    pub(super) fn len(&self) -> usize {
        self.vertices.len() + self.edges.len() + self.centres.len()
    }

    /// Positions of the points in a pose.
    pub(super) fn posed<'a>(&'a self, pose: &'a [Vec3]) -> impl Iterator<Item = Vec3> + 'a {
        let at = |v: &u32| pose[*v as usize];
        let vertices = self.vertices.iter().map(at);
        let edges = self.edges.iter().map(move |[a, b]| 0.5 * (at(a) + at(b)));
        let third = 1.0 / 3.0;
        let centres = self.centres.iter();
        let centres = centres.map(move |[a, b, c]| third * (at(a) + at(b) + at(c)));
        vertices.chain(edges).chain(centres)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_the_vertices_in_use_and_the_centres() {
        let pose = [0.0, 1.0, 2.0, 100.0, 5.0].map(|x| Vec3::X * x);
        let triangles = [[0, 1, 4], [1, 2, 4]];
        let opts = DistanceOptions::default();
        let mut points = Points::of(&triangles, pose.len(), &opts);
        let at = |points: &Points| -> Vec<f32> { points.posed(&pose).map(|p| p.x).collect() };
        let near = |found: Vec<f32>, expected: &[f32]| {
            assert_eq!(found.len(), expected.len());
            let pairs = found.iter().zip(expected);
            assert!(
                pairs.clone().all(|(a, b)| (a - b).abs() < 1e-5),
                "{found:?}"
            );
        };
        assert_eq!(points.len(), 6);
        near(at(&points), &[0.0, 1.0, 2.0, 5.0, 2.0, 8.0 / 3.0]);
        points.add_triangles(&[[0, 2, 4]]);
        assert_eq!(points.len(), 10);
        let edges = [1.0, 3.5, 2.5];
        let centres = [2.0, 8.0 / 3.0, 7.0 / 3.0];
        near(
            at(&points),
            &[&[0.0, 1.0, 2.0, 5.0], &edges[..], &centres].concat(),
        );
        let few = DistanceOptions {
            vertices: 2,
            face_centres: 1,
            ..opts
        };
        assert_eq!(Points::of(&triangles, pose.len(), &few).len(), 3);
    }
}
