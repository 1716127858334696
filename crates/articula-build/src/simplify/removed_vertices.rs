//! Removed vertices, each attached to a near face, and their distance from the surface after a
//! collapse, in every pose.
//!
//! Source: Klein, Liebich and Strasser, *Mesh reduction with error control* (1996), who bound the
//! distance of removed vertices. Here it is part of the cost and the maximum over all poses, and it
//! may be too large, since only the faces of one ring are searched.

use super::cost::Costs;
use super::ring::Ring;
use glam::Vec3;

/// No vertex.
const NONE: u32 = u32::MAX;

/// Linked lists of the removed vertices of each face.
#[derive(Debug, Default)]
pub(super) struct RemovedVertices {
    /// First removed vertex of each face.
    head: Vec<u32>,
    next: Vec<u32>,
    /// Removed vertices of the current ring, with the index of their face in `fans`.
    found: Vec<(u32, u32)>,
    /// Remaining faces of the ring, without their moved corner.
    fans: Vec<(u32, [u32; 2])>,
    /// Index in `fans` of the closest face to each of `found`.
    closest: Vec<u32>,
}

impl RemovedVertices {
    pub(super) fn new(faces: usize, classes: usize) -> Self {
        Self {
            head: vec![NONE; faces],
            next: vec![NONE; classes],
            ..Self::default()
        }
    }

    /// Maximum over poses of the weighted squared distance from the removed vertices of a ring, and
    /// its centre, to the faces that remain once the centre has moved to `to`.
    ///
    /// If no face remains, the distance to the new position of the centre is taken.
    pub(super) fn distance_squared(
        &mut self,
        costs: &Costs,
        ring: &Ring,
        (from, to): (u32, u32),
    ) -> f32 {
        self.gather(ring, (from, to));
        let mut most = 0.0f32;
        self.closest.clear();
        for (vertex, start) in &self.found {
            let factor = costs.factor(*vertex);
            let mut hint = *start as usize;
            let mut chosen = hint;
            for (pose, point) in costs.points(*vertex).iter().enumerate() {
                let mut best = f32::INFINITY;
                for at in 0..self.fans.len().max(1) {
                    // Start with the face that was closest last.
                    let at = match at {
                        0 => hint,
                        at if at <= hint => at - 1,
                        at => at,
                    };
                    let distance = match self.fans.get(at) {
                        Some((_, [a, b])) => {
                            let corners = [to, *a, *b].map(|c| costs.points(c)[pose]);
                            squared_distance(*point, corners)
                        }
                        None => point.distance_squared(costs.points(to)[pose]),
                    };
                    if distance < best {
                        best = distance;
                        hint = at;
                    }
                    if best * factor <= most {
                        break;
                    }
                }
                most = most.max(best * factor);
                if pose == 0 {
                    chosen = hint;
                }
            }
            self.closest.push(chosen as u32);
        }
        if most.is_nan() { f32::INFINITY } else { most }
    }

    fn gather(&mut self, ring: &Ring, (from, to): (u32, u32)) {
        self.found.clear();
        self.fans.clear();
        for (face, _, a, b) in &ring.faces {
            let stays = *a != to && *b != to;
            let start = if stays { self.fans.len() } else { 0 } as u32;
            let mut at = self.head[*face];
            while at != NONE {
                self.found.push((at, start));
                at = self.next[at as usize];
            }
            if stays {
                self.fans.push((*face as u32, [*a, *b]));
            }
        }
        self.found.push((from, 0));
    }

    /// Attaches the removed vertices to their closest faces, after the collapse that
    /// [`Self::distance_squared`] was last called for.
    pub(super) fn apply(&mut self, ring: &Ring) {
        for (face, ..) in &ring.faces {
            self.head[*face] = NONE;
        }
        for ((vertex, _), closest) in self.found.iter().zip(&self.closest) {
            if let Some((face, _)) = self.fans.get(*closest as usize) {
                self.next[*vertex as usize] = self.head[*face as usize];
                self.head[*face as usize] = *vertex;
            }
        }
    }
}

/// Squared distance of a point to a triangle (Ericson, *Real-Time Collision Detection*, 5.1.5).
///
/// [`articula_core::triangle_distance_squared`] is also accurate for thin triangles, where this one
/// may be off by the length of a side. It is kept because the order of collapses depends on its
/// rounding; it ranks candidates and is not used for reported errors.
fn squared_distance(p: Vec3, [a, b, c]: [Vec3; 3]) -> f32 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return ap.length_squared();
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return bp.length_squared();
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (ap - ab * (d1 / (d1 - d3))).length_squared();
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return cp.length_squared();
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (ap - ac * (d2 / (d2 - d6))).length_squared();
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let along = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return (bp - (c - b) * along).length_squared();
    }
    let sum = va + vb + vc;
    if sum == 0.0 {
        return ap.length_squared();
    }
    (ap - ab * (vb / sum) - ac * (vc / sum)).length_squared()
}

#[cfg(test)]
mod tests {
    use super::super::SimplifyOptions;
    use super::super::shapes::sheet;
    use super::super::test_surface::{TestSurface, shaken};
    use super::*;
    use articula_core::triangle_distance_squared;
    use std::collections::BTreeSet;

    #[test]
    fn distances_to_triangles_are_those_of_the_accurate_routine() {
        let shift = Vec3::new(0.5, -1.0, 2.0);
        let sharp = [
            Vec3::ZERO,
            Vec3::new(4.0, 0.0, 1.0),
            Vec3::new(1.0, 3.0, -1.0),
        ];
        let blunt = [
            Vec3::ZERO,
            Vec3::new(2.0, 1.0, 0.0),
            Vec3::new(5.0, -0.5, 1.0),
        ];
        for corners in [sharp, blunt].map(|t| t.map(|p| p + shift)) {
            for i in 0..10 * 10 * 7 {
                let [x, y, z] = [i % 10, i / 10 % 10, i / 100].map(|k| k as f32);
                let point = Vec3::new(x - 3.25, y - 4.75, z - 1.0);
                let expected = triangle_distance_squared(point, corners);
                let found = squared_distance(point, corners);
                assert!(
                    (found - expected).abs() < 1e-4 * expected.max(1.0),
                    "{point}"
                );
            }
        }
        // Three corners at one place.
        let nowhere = squared_distance(shift + Vec3::X * 2.0, [shift; 3]);
        assert_eq!(nowhere, 4.0);
    }

    /// Squared distance to the remaining faces over all poses, by trying all of them.
    fn slow(costs: &Costs, ring: &Ring, vertices: &[u32], to: u32) -> f32 {
        let stay = || ring.faces.iter().filter(|f| f.2 != to && f.3 != to);
        let mut most = 0.0f32;
        for v in vertices {
            for (pose, point) in costs.points(*v).iter().enumerate() {
                let at = |c: u32| costs.points(c)[pose];
                let near = stay().map(|f| squared_distance(*point, [to, f.2, f.3].map(at)));
                let near = near.reduce(f32::min);
                let near = near.unwrap_or_else(|| point.distance_squared(at(to)));
                most = most.max(near * costs.factor(*v));
            }
        }
        most
    }

    fn attached(removed: &RemovedVertices, face: usize) -> Vec<u32> {
        let start = Some(removed.head[face]).filter(|v| *v != NONE);
        let next = |v: &u32| Some(removed.next[*v as usize]).filter(|v| *v != NONE);
        std::iter::successors(start, next).collect()
    }

    #[test]
    fn removed_vertices_stay_attached_to_the_faces_that_count_their_distance() {
        let flat = sheet(6);
        let mut mesh = flat.clone();
        mesh.positions = shaken(&flat.positions, 0.3);
        let pose = shaken(&mesh.positions, 0.4).into_iter().rev().collect();
        let mut of = TestSurface::new(mesh, &[pose]);
        let weights = (0..of.mesh.len()).map(|v| 1.0 + (v % 3) as f32);
        let options = SimplifyOptions {
            vertex_weights: weights.collect(),
            ..SimplifyOptions::default()
        };
        let costs = of.costs(&options);
        let mut removed = RemovedVertices::new(of.surface.faces.len(), of.classes.len());
        let mut ring = Ring::default();
        let mut gone = BTreeSet::new();
        // Each vertex goes to the first of its neighbours that no other was moved to last.
        for step in 0..of.classes.len() - 4 {
            let from = (step * 31 % of.classes.len()) as u32;
            ring.look(&of.surface, from);
            let Some(to) = ring.neighbours.get(step % 2).copied() else {
                continue;
            };
            let mut vertices = vec![from];
            for (face, ..) in &ring.faces {
                vertices.extend(attached(&removed, *face));
            }
            let found = removed.distance_squared(&costs, &ring, (from, to));
            let expected = slow(&costs, &ring, &vertices, to);
            assert!(
                (found - expected).abs() <= 1e-6 * expected,
                "{found}, {expected}"
            );
            let fans: Vec<usize> = ring
                .faces
                .iter()
                .filter(|f| f.2 != to && f.3 != to)
                .map(|f| f.0)
                .collect();
            removed.apply(&ring);
            of.surface.collapse(from, to, &vec![0; fans.len()]);
            gone.extend(vertices.iter().copied().filter(|_| !fans.is_empty()));
            let mut now: Vec<u32> = fans.iter().flat_map(|f| attached(&removed, *f)).collect();
            now.sort_unstable();
            vertices.sort_unstable();
            if fans.is_empty() {
                assert!(now.is_empty());
            } else {
                assert_eq!(now, vertices, "each is attached to one remaining face");
            }
        }
        assert!(gone.len() > 20);
    }
}
