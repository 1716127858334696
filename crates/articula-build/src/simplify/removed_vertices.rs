//! Removed vertices, each remembered by a face near it: how far a collapse would leave them from
//! the surface, in every pose.
//!
//! Source: Klein, Liebich and Strasser, *Mesh reduction with error control* (1996), who keep the
//! distance of removed vertices below a bound. Differs: the distance is part of the cost, is the
//! greatest over all poses, and is taken to the faces of one ring only, so it may be too great.

use super::cost::Costs;
use super::ring::Ring;
use glam::Vec3;

/// No vertex.
const NONE: u32 = u32::MAX;

/// The removed vertices of each face, as lists.
#[derive(Debug, Default)]
pub(super) struct RemovedVertices {
    /// First one of each face.
    head: Vec<u32>,
    next: Vec<u32>,
    /// Those of the ring that is looked at, with the place of their face in it.
    found: Vec<(u32, u32)>,
    /// Faces of the ring that stay, their moved corner left out.
    fans: Vec<(u32, [u32; 2])>,
    /// The face of `fans` that each of `found` is closest to.
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

    /// Greatest weighted squared distance over poses that the removed vertices of a ring, and
    /// its centre, have from the faces that are left once the centre is moved to `to`.
    ///
    /// If no face is left, the distance from the place it was moved to.
    pub(super) fn distance_squared(
        &mut self,
        costs: &Costs,
        ring: &Ring,
        (from, to): (u32, u32),
    ) -> f32 {
        self.gather(ring, (from, to));
        let mut most = 0.0f32;
        self.closest.clear();
        for (stray, start) in &self.found {
            let factor = costs.factor(*stray);
            let mut hint = *start as usize;
            let mut chosen = hint;
            for (pose, point) in costs.points(*stray).iter().enumerate() {
                let mut best = f32::INFINITY;
                for at in 0..self.fans.len().max(1) {
                    // The face that was closest last comes first.
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

    /// After a collapse whose distance was just taken: removed vertices go to the faces found.
    pub(super) fn apply(&mut self, ring: &Ring) {
        for (face, ..) in &ring.faces {
            self.head[*face] = NONE;
        }
        for ((stray, _), closest) in self.found.iter().zip(&self.closest) {
            if let Some((face, _)) = self.fans.get(*closest as usize) {
                self.next[*stray as usize] = self.head[*face as usize];
                self.head[*face as usize] = *stray;
            }
        }
    }
}

/// Squared distance of a point to a triangle (Ericson, *Real-Time Collision Detection*, 5.1.5).
///
/// It rounds otherwise than [`articula_core::triangle_distance_squared`], which is right for thin triangles too: there this
/// one may be off by the length of a side. The order of collapses hangs on every bit of it, so it
/// ranks candidates here and measures nothing that is stated.
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
