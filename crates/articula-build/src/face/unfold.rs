//! Displacements of skin that turn no triangle over.

use super::points::{FacePoints, FaceSurface};
use glam::Vec3;
use std::collections::{BTreeMap, BTreeSet};

/// Most rounds of smoothing.
const ROUNDS: usize = 30;

/// The triangles of the skin of a head, to find and smooth those that displacements turn over.
#[derive(Debug, Clone, PartialEq)]
pub struct SkinFolds {
    // All are by the first vertex of each place.
    positions: Vec<Vec3>,
    joined: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    /// Triangles across the edges of each, and their normals at rest.
    beside: Vec<Vec<usize>>,
    normals: Vec<Vec3>,
    /// Vertices at the other ends of the edges of each.
    neighbours: BTreeMap<u32, BTreeSet<u32>>,
}

impl SkinFolds {
    /// The skin of a head; its feature points say what of it is skin.
    pub fn of(surface: &FaceSurface, points: &FacePoints) -> Self {
        let parts = &points.parts;
        Self::of_triangles(surface.positions.clone(), parts.joined.clone(), &parts.skin)
    }

    /// The same of some triangles; `joined` has the first vertex of the same place for each vertex.
    pub(in crate::face) fn of_triangles(
        positions: Vec<Vec3>,
        joined: Vec<u32>,
        skin: &[[u32; 3]],
    ) -> Self {
        let skin = skin.iter();
        let triangles: Vec<[u32; 3]> = skin.map(|t| t.map(|v| joined[v as usize])).collect();
        let mut of_edge: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
        let mut neighbours: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
        for (index, triangle) in triangles.iter().enumerate() {
            for i in 0..3 {
                let (a, b) = (triangle[i], triangle[(i + 1) % 3]);
                of_edge.entry([a.min(b), a.max(b)]).or_default().push(index);
                neighbours.entry(a).or_default().insert(b);
                neighbours.entry(b).or_default().insert(a);
            }
        }
        let mut beside = vec![Vec::new(); triangles.len()];
        for pair in of_edge.into_values().filter(|of| of.len() == 2) {
            beside[pair[0]].push(pair[1]);
            beside[pair[1]].push(pair[0]);
        }
        let mut folds = Self {
            normals: Vec::new(),
            positions,
            joined,
            triangles,
            beside,
            neighbours,
        };
        let still = vec![Vec3::ZERO; folds.positions.len()];
        folds.normals = (0..folds.triangles.len())
            .map(|t| folds.normal(t, &still))
            .collect();
        folds
    }

    /// Smooths displacements where triangles would face another way than at rest and than those beside them: their
    /// corners go as their neighbours do. `moved` has one for each vertex of the head, in metres.
    pub fn unfold(&self, moved: &mut [Vec3]) {
        let moves = |t: &usize| {
            self.triangles[*t]
                .iter()
                .any(|v| moved[*v as usize] != Vec3::ZERO)
        };
        let moving: Vec<usize> = (0..self.triangles.len()).filter(moves).collect();
        let mut smoothed = false;
        for _ in 0..ROUNDS {
            let folded = moving.iter().filter(|t| self.is_folded(**t, moved));
            let corners: BTreeSet<u32> = folded.flat_map(|t| self.triangles[*t]).collect();
            if corners.is_empty() {
                break;
            }
            let means: Vec<(u32, Vec3)> =
                corners.iter().map(|v| (*v, self.mean(*v, moved))).collect();
            means
                .into_iter()
                .for_each(|(v, mean)| moved[v as usize] = mean);
            smoothed = true;
        }
        if smoothed {
            for (vertex, first) in self.joined.iter().enumerate() {
                moved[vertex] = moved[*first as usize];
            }
        }
    }

    fn is_folded(&self, triangle: usize, moved: &[Vec3]) -> bool {
        let normal = self.normal(triangle, moved);
        if normal.dot(self.normals[triangle]) >= 0.0 {
            return false;
        }
        let beside = || self.beside[triangle].iter();
        let now: Vec3 = beside().map(|t| self.normal(*t, moved)).sum();
        let rest: Vec3 = beside().map(|t| self.normals[*t]).sum();
        normal.dot(now) < 0.0 && self.normals[triangle].dot(rest) >= 0.0
    }

    fn normal(&self, triangle: usize, moved: &[Vec3]) -> Vec3 {
        let at = |v: u32| self.positions[v as usize] + moved[v as usize];
        let [a, b, c] = self.triangles[triangle].map(at);
        (b - a).cross(c - a).normalize_or_zero()
    }

    /// Mean of a vertex and of its neighbours.
    fn mean(&self, vertex: u32, moved: &[Vec3]) -> Vec3 {
        let beside = self.neighbours.get(&vertex);
        let all = || beside.into_iter().flatten().map(|v| moved[*v as usize]);
        let count = all().count() as f32;
        0.5 * (moved[vertex as usize] + all().sum::<Vec3>() / count.max(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of 5 by 5 vertices.
    fn square() -> SkinFolds {
        let at = |i: u32| Vec3::new((i % 5) as f32, (i / 5) as f32, 0.0);
        let cells = (0..16).map(|i| i / 4 * 5 + i % 4);
        let triangles: Vec<[u32; 3]> = cells
            .flat_map(|v| [[v, v + 1, v + 6], [v, v + 6, v + 5]])
            .collect();
        SkinFolds::of_triangles((0..25).map(at).collect(), (0..25).collect(), &triangles)
    }

    #[test]
    fn a_fold_is_smoothed_and_what_is_flat_stays() {
        let folds = square();
        let mut moved = vec![Vec3::ZERO; 25];
        moved[12] = Vec3::new(1.5, 0.2, 0.0);
        let all = 0..folds.triangles.len();
        assert!(all.clone().any(|t| folds.is_folded(t, &moved)));
        folds.unfold(&mut moved);
        assert!(!all.clone().any(|t| folds.is_folded(t, &moved)));
        assert!(moved[12].x > 0.3, "{}", moved[12]);
        let mut bent: Vec<Vec3> = (0..25).map(|i| 0.2 * (i % 5) as f32 * Vec3::Z).collect();
        let before = bent.clone();
        folds.unfold(&mut bent);
        assert_eq!(bent, before);
    }
}
