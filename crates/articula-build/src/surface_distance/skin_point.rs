//! A point of the skin that moves with it.

use articula_core::{BLOCK_POSES, PointBlock};
use glam::Vec3;

/// A point of the skin: a weighted mean of three vertices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkinPoint {
    /// Indices of the vertices.
    pub corners: [u32; 3],
    /// Weights of the vertices, which sum to 1.
    pub weights: [f32; 3],
}

impl SkinPoint {
    /// The point at a vertex.
    pub(crate) fn at(vertex: u32) -> Self {
        Self {
            corners: [vertex; 3],
            weights: [1.0, 0.0, 0.0],
        }
    }

    /// The same point with corners as indices into `vertices`, which are ascending and contain
    /// them.
    #[must_use]
    pub(crate) fn among(&self, vertices: &[u32]) -> Self {
        Self {
            corners: self
                .corners
                .map(|v| vertices.partition_point(|u| *u < v) as u32),
            weights: self.weights,
        }
    }

    /// Returns the position of the point, given the positions of all vertices.
    ///
    /// # Panics
    /// If there are too few positions.
    #[inline]
    pub fn posed(&self, positions: &[Vec3]) -> Vec3 {
        let [a, b, c] = self.corners.map(|v| positions[v as usize]);
        let [u, v, w] = self.weights;
        if v == 0.0 && w == 0.0 {
            return a;
        }
        a * u + b * v + c * w
    }

    /// [`posed`](Self::posed) in each pose of a block.
    #[inline]
    pub(crate) fn posed_block(&self, positions: &[PointBlock]) -> PointBlock {
        let [a, b, c] = self.corners.map(|v| &positions[v as usize]);
        let [u, v, w] = self.weights;
        if v == 0.0 && w == 0.0 {
            return *a;
        }
        let [a, b, c] = [a, b, c].map(PointBlock::components);
        let mut out = [[0.0; BLOCK_POSES]; 3];
        for (row, out) in out.iter_mut().enumerate() {
            let corners = a[row].iter().zip(b[row]).zip(c[row]);
            for (out, ((a, b), c)) in out.iter_mut().zip(corners) {
                *out = a * u + b * v + c * w;
            }
        }
        PointBlock::new(out)
    }
}

/// Returns the vertices that the points use, ascending, and the points with corners as indices into
/// these.
pub fn compact(points: &[SkinPoint]) -> (Vec<u32>, Vec<SkinPoint>) {
    let vertices = corners(points);
    let points = points.iter().map(|p| p.among(&vertices)).collect();
    (vertices, points)
}

/// All corners of some points, ascending.
pub(crate) fn corners(points: &[SkinPoint]) -> Vec<u32> {
    let mut vertices: Vec<u32> = points.iter().flat_map(|p| p.corners).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_by_hand() {
        let positions = [Vec3::X, Vec3::Y * 4.0, Vec3::Z * 8.0, Vec3::NAN];
        let posed = |corners, weights| SkinPoint { corners, weights }.posed(&positions);
        assert_eq!(
            posed([0, 1, 2], [0.5, 0.25, 0.25]),
            Vec3::new(0.5, 1.0, 2.0)
        );
        assert!(posed([0, 1, 3], [0.5, 0.5, 0.0]).is_nan());
        assert_eq!(posed([0, 1, 2], [0.5, 0.5, 0.0]), Vec3::new(0.5, 2.0, 0.0));
        assert_eq!(posed([0, 1, 2], [0.5, 0.0, 0.5]), Vec3::new(0.5, 0.0, 4.0));
        // A vertex itself is exact, wherever the other corners are.
        assert_eq!(posed([1, 3, 3], [1.0, 0.0, 0.0]), positions[1]);
    }

    #[test]
    fn compact_points_are_the_same_on_fewer_vertices() {
        let point = |corners, weights| SkinPoint { corners, weights };
        let points = [
            point([9, 2, 5], [0.5, 0.25, 0.25]),
            point([2; 3], [1.0, 0.0, 0.0]),
        ];
        let (vertices, few) = compact(&points);
        assert_eq!(vertices, [2, 5, 9]);
        assert_eq!(
            few,
            [
                point([2, 0, 1], [0.5, 0.25, 0.25]),
                point([0; 3], [1.0, 0.0, 0.0])
            ]
        );
    }
}
