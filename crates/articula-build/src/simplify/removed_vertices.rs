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
