//! The triangle count of a conversion, and the weights of face and hands, judged by the largest
//! local difference from the character itself.
//!
//! Source: `docs/methods/vector.md` 9. Similarity of the whole picture hides a lost mouth or finger,
//! which are few pixels.

use articula_flat::flatten::{JudgedRegion, LocalDifferences, WorstDifference};

/// Largest local difference of the face that a triangle count may have, units of CIELAB.
pub const FACE_DELTA_E: f64 = 24.0;
/// Largest local difference of everything else that a triangle count may have, units of CIELAB.
pub const REST_DELTA_E: f64 = 36.0;
/// Largest local difference by which vertex colours may differ from a texture before the detail
/// counts as dropped, units of CIELAB.
pub const DETAIL_DELTA_E: f64 = 15.0;
/// Triangle counts, as multiples of the least.
pub(super) const COUNTS: [f64; 8] = [1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0, 4.0];
/// Least weight of errors on the face.
const FACE_WEIGHT: f32 = 3.0;
/// Factor by which the weight of a region is raised.
const RAISE: f32 = 2.0;
/// Maximum number of raises of one region.
const RAISES: u32 = 2;
/// A smaller count is as good as the best one if its excess is at most this factor of the best.
const AS_GOOD: f64 = 1.1;

/// Weights of errors on face and hands when a figure is simplified; 1 elsewhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RegionWeights {
    /// Weight of an error on the face.
    pub face: f32,
    /// Weight of an error on the hands.
    pub hands: f32,
}

impl Default for RegionWeights {
    /// Three for the face, since viewers look at faces.
    fn default() -> Self {
        Self {
            face: FACE_WEIGHT,
            hands: 1.0,
        }
    }
}

impl RegionWeights {
    /// The weight of a region, for change; `None` for the body, to which the others relate.
    fn of(&mut self, region: JudgedRegion) -> Option<&mut f32> {
        match region {
            JudgedRegion::Face => Some(&mut self.face),
            JudgedRegion::Hands => Some(&mut self.hands),
            JudgedRegion::Body => None,
        }
    }

    /// These weights with that of one region raised; `None` if it cannot be raised further.
    pub(super) fn raised(mut self, region: JudgedRegion) -> Option<Self> {
        let least = *Self::default().of(region)?;
        let weight = self.of(region)?;
        *weight *= RAISE;
        (*weight <= least * RAISE.powi(RAISES as i32)).then_some(self)
    }
}

/// A triangle count and weights that were tried, with the differences from the character itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriedTriangles {
    /// Target number of triangles.
    pub count: usize,
    /// Number of triangles after simplification.
    pub triangles: usize,
    /// Weights of face and hands.
    pub weights: RegionWeights,
    /// Largest local differences.
    pub local: LocalDifferences,
}

impl TriedTriangles {
    /// Region whose difference is the greatest multiple of its bound, and that multiple.
    pub(super) fn excess(&self) -> (JudgedRegion, f64) {
        let all = [JudgedRegion::Body, JudgedRegion::Hands, JudgedRegion::Face];
        let of = |region| self.local.of(region).map(|worst| (region, excess(&worst)));
        let most = |a: (JudgedRegion, f64), b: (JudgedRegion, f64)| if b.1 > a.1 { b } else { a };
        let shown = all.into_iter().filter_map(of);
        shown.reduce(most).unwrap_or_default()
    }
}

/// A difference as a multiple of its bound.
fn excess(worst: &WorstDifference) -> f64 {
    worst.delta_e / bound_delta_e(worst.region)
}

/// Largest local difference that a triangle count may have in a region, units of CIELAB.
fn bound_delta_e(region: JudgedRegion) -> f64 {
    match region {
        JudgedRegion::Face => FACE_DELTA_E,
        JudgedRegion::Hands | JudgedRegion::Body => REST_DELTA_E,
    }
}

/// Index of the chosen one of what was tried: the fewest triangles within the bounds, or about as
/// good as the best.
pub(super) fn chosen(tried: &[TriedTriangles]) -> Option<usize> {
    let of = |t: &TriedTriangles| t.excess().1;
    let best = tried.iter().map(of).fold(f64::INFINITY, f64::min);
    let enough = (best * AS_GOOD).max(1.0);
    let good = tried.iter().enumerate().filter(|(_, t)| of(t) <= enough);
    // Of equal counts the better one.
    let key = |t: &TriedTriangles| (t.count, of(t));
    let before = |a: &TriedTriangles, b: &TriedTriangles| {
        let (p, q) = (key(a), key(b));
        p.0 < q.0 || p.0 == q.0 && p.1 <= q.1
    };
    let fewer = good.reduce(|a, b| if before(a.1, b.1) { a } else { b });
    fewer.map(|(i, _)| i)
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_flat::flatten::LocalDifferences;

    fn tried(count: usize, face: f64, rest: f64) -> TriedTriangles {
        let worst = |region, delta_e| WorstDifference {
            region,
            delta_e,
            x: 0,
            y: 0,
            frame: 0.0,
        };
        TriedTriangles {
            count,
            triangles: count,
            weights: RegionWeights::default(),
            local: LocalDifferences::from_iter([
                worst(JudgedRegion::Face, face),
                worst(JudgedRegion::Hands, rest),
            ]),
        }
    }

    #[test]
    fn the_fewest_triangles_within_the_bounds_are_chosen() {
        let (face, rest) = (FACE_DELTA_E, REST_DELTA_E);
        let all = [
            tried(600, 2.0 * face, 0.5 * rest),
            tried(600, 0.9 * face, 1.2 * rest),
            tried(900, 0.9 * face, 0.9 * rest),
            tried(1200, 0.1 * face, 0.1 * rest),
        ];
        assert_eq!(chosen(&all), Some(2));
        assert_eq!(all[0].excess(), (JudgedRegion::Face, 2.0));
        assert!(all[1].excess().0 == JudgedRegion::Hands);
        // Beyond the bounds, more triangles that change little are not taken.
        let lost = [
            tried(600, 3.0 * face, 0.0),
            tried(900, 2.1 * face, 0.0),
            tried(1200, 2.0 * face, 0.0),
        ];
        assert_eq!(chosen(&lost), Some(1));
        assert_eq!(chosen(&[]), None);
    }

    #[test]
    fn weights_are_raised_up_to_a_limit_and_the_body_has_none() {
        let start = RegionWeights::default();
        let once = start.raised(JudgedRegion::Hands).unwrap();
        assert_eq!((once.face, once.hands), (3.0, 2.0));
        let twice = once.raised(JudgedRegion::Hands).unwrap();
        assert_eq!(twice.raised(JudgedRegion::Hands), None);
        assert_eq!(twice.raised(JudgedRegion::Face).unwrap().face, 6.0);
        assert_eq!(start.raised(JudgedRegion::Body), None);
    }
}
