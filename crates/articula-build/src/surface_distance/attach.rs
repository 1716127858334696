//! Which point of a coarser surface stands for which vertex of the original.
//!
//! The closest point at rest may lie on another part of the body: on the other lip, on the arm
//! that hangs beside the hip. So the closest points in several poses are tried, and the one whose
//! distance, over all of these poses, stays smallest is taken.

use super::tree::SurfaceTree;
use glam::Vec3;

/// A point of the skin: a mean of three vertices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkinPoint {
    /// The vertices.
    pub corners: [u32; 3],
    /// How much each counts; they sum to 1.
    pub weights: [f32; 3],
}

impl SkinPoint {
    /// A vertex itself.
    pub fn at(vertex: u32) -> Self {
        Self {
            corners: [vertex; 3],
            weights: [1.0, 0.0, 0.0],
        }
    }

    /// The same point, its corners named by their places among some vertices, which rise and hold
    /// them.
    #[must_use]
    pub fn among(&self, vertices: &[u32]) -> Self {
        Self {
            corners: self
                .corners
                .map(|v| vertices.partition_point(|u| *u < v) as u32),
            weights: self.weights,
        }
    }

    /// Where it is, given where all vertices are.
    ///
    /// # Panics
    /// If there are too few vertices.
    #[inline]
    pub fn posed(&self, positions: &[Vec3]) -> Vec3 {
        let [a, b, c] = self.corners.map(|v| positions[v as usize]);
        let [u, v, w] = self.weights;
        if v == 0.0 && w == 0.0 {
            return a;
        }
        a * u + b * v + c * w
    }
}

/// All corners of some points, rising.
pub fn corners(points: &[SkinPoint]) -> Vec<u32> {
    let mut vertices: Vec<u32> = points.iter().flat_map(|p| p.corners).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

/// The point of a level's surface that stands for each of some vertices of the original; a vertex
/// without any finite distance to the level stands for itself. `poses` are positions of all
/// vertices; at least one is needed. O(poses² · vertices + poses · vertices · log(triangles)).
///
/// # Panics
/// If a vertex or triangle is not in the poses.
pub fn attach(triangles: &[[u32; 3]], vertices: &[u32], poses: &[Vec<Vec3>]) -> Vec<SkinPoint> {
    let mut best: Vec<(f32, SkinPoint)> = vertices
        .iter()
        .map(|v| (f32::INFINITY, SkinPoint::at(*v)))
        .collect();
    let Some(rest) = poses.first() else {
        return best.into_iter().map(|b| b.1).collect();
    };
    let mut tree = SurfaceTree::new(triangles, rest);
    for pose in poses {
        tree.refit(pose);
        for (v, (least, point)) in vertices.iter().zip(&mut best) {
            let position = pose[*v as usize];
            if *least == 0.0 || !position.is_finite() {
                continue;
            }
            let Some(found) = tree.closest_point(position) else {
                continue;
            };
            let apart = |p: &Vec<Vec3>| {
                let distance = found.posed(p).distance(p[*v as usize]);
                if distance.is_finite() { distance } else { 0.0 }
            };
            let worst = poses.iter().map(apart).fold(0.0, f32::max);
            if worst < *least {
                (*least, *point) = (worst, found);
            }
        }
    }
    best.into_iter().map(|b| b.1).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_other_lip_is_closer_at_rest_but_not_for_long() {
        // Two sheets a millimetre apart; the upper one's middle vertex 3 is gone at the level.
        let mut rest: Vec<Vec3> = [[0, 0], [2, 0], [0, 2]]
            .iter()
            .map(|[x, z]| Vec3::new(*x as f32, 0.010, *z as f32))
            .collect();
        rest.push(Vec3::new(0.5, 0.002, 0.5));
        rest.extend([[0, 0], [2, 0], [0, 2]].map(|[x, z]| Vec3::new(x as f32, 0.0, z as f32)));
        let level = [[0, 1, 2], [4, 5, 6]];
        let mut open = rest.clone();
        for upper in &mut open[..4] {
            upper.y += 0.1;
        }
        let alone = attach(&level, &[3, 0], std::slice::from_ref(&rest));
        assert_eq!(
            alone[0].corners,
            [4, 5, 6],
            "2 mm to the lower sheet, 8 mm to its own"
        );
        assert_eq!(
            alone[1].posed(&rest),
            rest[0],
            "a corner of the level is itself"
        );
        let both = attach(&level, &[3], &[rest.clone(), open.clone()]);
        assert_eq!(both[0].corners, [0, 1, 2]);
        let few = corners(&alone);
        assert_eq!(few, [0, 4, 5, 6]);
        assert_eq!(alone[0].among(&few).corners, [1, 2, 3]);
        let sum: f32 = both[0].weights.iter().sum();
        assert!((sum - 1.0).abs() < 1e-6);
        assert!((both[0].posed(&open) - Vec3::new(0.5, 0.11, 0.5)).length() < 1e-6);
    }

    #[test]
    fn nothing_to_stand_on() {
        let points = vec![Vec3::ZERO, Vec3::NAN];
        assert_eq!(
            attach(&[], &[0], std::slice::from_ref(&points)),
            [SkinPoint::at(0)]
        );
        assert_eq!(attach(&[[0, 0, 0]], &[1], &[points]), [SkinPoint::at(1)]);
        assert_eq!(attach(&[], &[7], &[]), [SkinPoint::at(7)]);
    }
}
