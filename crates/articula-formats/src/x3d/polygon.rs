//! Triangulation of polygons.
//!
//! A convex polygon becomes a fan. One that may be concave is cut ear by ear: an ear is the next
//! corner that is convex and has no other corner in its triangle.
//!
//! Source: Meisters 1975, "Polygons have ears"; ISO/IEC 19775-1, 13.3.5 (field `convex`). Differs:
//! where no ear is found, as in a polygon that crosses itself, the rest becomes a fan.

use glam::{DVec2, DVec3};

/// Maximum number of corner-in-triangle tests for all polygons of one file together; beyond it,
/// polygons become fans.
const MAX_TESTS: u64 = 1 << 30;

/// Triangulator that counts its work.
#[derive(Debug, Default)]
pub(super) struct Cutter {
    tests: u64,
}

impl Cutter {
    /// Returns the triangles of a polygon, as indices of its corners.
    pub(super) fn triangles(&mut self, points: &[DVec3], convex: bool) -> Vec<[usize; 3]> {
        let worst = (points.len() as u64).saturating_pow(2);
        if convex || points.len() < 4 || self.tests.saturating_add(worst) > MAX_TESTS {
            return fan((0..points.len()).collect());
        }
        let Some(flat) = flattened(points) else {
            return fan((0..points.len()).collect());
        };
        self.ears(&flat)
    }

    fn ears(&mut self, points: &[DVec2]) -> Vec<[usize; 3]> {
        let mut left: Vec<usize> = (0..points.len()).collect();
        let mut triangles = Vec::with_capacity(points.len() - 2);
        // Next corner to test, and number of consecutive corners that were not ears.
        let (mut at, mut missed) = (0, 0);
        while left.len() > 3 && missed < left.len() && self.tests < MAX_TESTS {
            let count = left.len();
            let ear = [(at + count - 1) % count, at % count, (at + 1) % count].map(|i| left[i]);
            if self.is_ear(points, &left, ear) {
                triangles.push(ear);
                left.remove(at % count);
                missed = 0;
            } else {
                missed += 1;
                at += 1;
            }
            at %= left.len();
        }
        triangles.extend(fan(left));
        triangles
    }

    fn is_ear(&mut self, points: &[DVec2], left: &[usize], ear: [usize; 3]) -> bool {
        let [a, b, c] = ear.map(|i| points[i]);
        if (b - a).perp_dot(c - b) <= 0.0 {
            return false;
        }
        self.tests += left.len() as u64;
        let inside = |i: &usize| {
            let p = points[*i];
            let corner = ear.contains(i) || p == a || p == b || p == c;
            !corner
                && (b - a).perp_dot(p - a) >= 0.0
                && (c - b).perp_dot(p - b) >= 0.0
                && (a - c).perp_dot(p - c) >= 0.0
        };
        !left.iter().any(inside)
    }
}

fn fan(corners: Vec<usize>) -> Vec<[usize; 3]> {
    let pairs = corners.windows(2).skip(1);
    pairs.map(|pair| [corners[0], pair[0], pair[1]]).collect()
}

/// Returns the normal of a polygon with twice its area as length, by Newell's method.
pub(super) fn newell(points: &[DVec3]) -> DVec3 {
    let next = points.iter().cycle().skip(1);
    let edges = points.iter().zip(next);
    edges
        .map(|(a, b)| (*a - points[0]).cross(*b - points[0]))
        .sum()
}

/// Projects the polygon to the plane in which it is counter-clockwise; `None` if it has no area.
fn flattened(points: &[DVec3]) -> Option<Vec<DVec2>> {
    let normal = newell(points).try_normalize()?;
    let (x, y) = normal.any_orthonormal_pair();
    // The axes and the normal are right-handed, so the orientation is kept.
    Some(
        points
            .iter()
            .map(|p| DVec2::new(p.dot(x), p.dot(y)))
            .collect(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(points: &[DVec3], triangles: &[[usize; 3]]) -> (f64, f64) {
        let whole = newell(points);
        let up = whole.normalize();
        let signed = triangles.iter().map(|t| {
            let [a, b, c] = t.map(|i| points[i]);
            (b - a).cross(c - a).dot(up)
        });
        (signed.clone().sum(), signed.map(f64::abs).sum())
    }

    /// A chevron: corner 3 points inwards, so a fan from corner 0 would leave the polygon.
    fn chevron() -> Vec<DVec3> {
        [(0., 0.), (2., 1.), (4., 0.), (2., 4.)]
            .map(|(x, z)| DVec3::new(x, 0.5, -z))
            .to_vec()
    }

    #[test]
    fn concave_polygons_keep_their_area() {
        let points = chevron();
        let triangles = Cutter::default().triangles(&points, false);
        assert_eq!(triangles.len(), 2);
        let (signed, absolute) = area(&points, &triangles);
        let whole = newell(&points).length();
        assert!((whole - 12.0).abs() < 1e-12, "twice 8 minus 2");
        assert!((signed - whole).abs() < 1e-12 && (absolute - whole).abs() < 1e-12);
        // Declared convex, it is triangulated as a fan, as the format specifies.
        let wrong = Cutter::default().triangles(&points, true);
        assert!(area(&points, &wrong).1 > whole + 1.0);
    }

    #[test]
    fn a_star_is_cut_whole() {
        let points: Vec<DVec3> = (0..20)
            .map(|i| {
                let angle = f64::from(i) * std::f64::consts::TAU / 20.0;
                let radius = if i % 2 == 0 { 3.0 } else { 1.0 };
                DVec3::new(radius * angle.cos(), radius * angle.sin(), 1.0)
            })
            .collect();
        let triangles = Cutter::default().triangles(&points, false);
        assert_eq!(triangles.len(), 18);
        let (signed, absolute) = area(&points, &triangles);
        assert!((signed - absolute).abs() < 1e-9);
        assert!((signed - newell(&points).length()).abs() < 1e-9);
    }

    #[test]
    fn what_is_no_polygon_ends() {
        let mut cutter = Cutter::default();
        let point = vec![DVec3::ONE; 100];
        assert_eq!(cutter.triangles(&point, false).len(), 98);
        let bow = [(0., 0.), (1., 1.), (1., 0.), (0., 1.)].map(|(x, y)| DVec3::new(x, y, 0.));
        assert_eq!(cutter.triangles(&bow, false).len(), 2);
        assert!(cutter.triangles(&point[..2], false).is_empty());
        assert!(cutter.triangles(&[], false).is_empty());
    }
}
