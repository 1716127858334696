//! Distances of a point to four triangles at once.
//!
//! The same bits as [`articula_core::triangle_distance_squared`] for each of them: the same
//! operations in the same order, of which each region of the triangle selects one result.

use glam::{BVec4A, Vec3, Vec4};

/// Number of triangles.
pub(super) const LANES: usize = 4;

/// As in [`articula_core::triangle_distance_squared`].
const NO_AREA: f32 = 1e-5;

/// Four vectors, one in each lane.
#[derive(Debug, Clone, Copy)]
struct Four {
    x: Vec4,
    y: Vec4,
    z: Vec4,
}

impl Four {
    fn of(vectors: [Vec3; LANES]) -> Self {
        Self {
            x: Vec4::from_array(vectors.map(|v| v.x)),
            y: Vec4::from_array(vectors.map(|v| v.y)),
            z: Vec4::from_array(vectors.map(|v| v.z)),
        }
    }

    #[inline(always)]
    fn all(vector: Vec3) -> Self {
        Self {
            x: Vec4::splat(vector.x),
            y: Vec4::splat(vector.y),
            z: Vec4::splat(vector.z),
        }
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        Self {
            x: self.x - other.x,
            y: self.y - other.y,
            z: self.z - other.z,
        }
    }

    #[inline(always)]
    fn times(self, factor: Vec4) -> Self {
        Self {
            x: self.x * factor,
            y: self.y * factor,
            z: self.z * factor,
        }
    }

    #[inline(always)]
    fn dot(self, other: Self) -> Vec4 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    fn length_squared(self) -> Vec4 {
        self.dot(self)
    }

    fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }
}

/// Four triangles in a pose.
#[derive(Debug, Clone, Copy)]
pub(super) struct FourTriangles {
    corners: [Four; 3],
    ab: Four,
    ac: Four,
    bc: Four,
    normal: Four,
    /// Squared length of the normal.
    area: Vec4,
    /// Whether there is (nearly) no area.
    is_flat: BVec4A,
    lengths_squared: [Vec4; 3],
}

impl FourTriangles {
    pub(super) fn new(corners: [[Vec3; 3]; LANES]) -> Self {
        let [a, b, c] = [0, 1, 2].map(|k| Four::of(corners.map(|t| t[k])));
        let (ab, ac, bc) = (b.minus(a), c.minus(a), c.minus(b));
        let normal = ab.cross(ac);
        let area = normal.length_squared();
        let lengths_squared = [ab, ac, bc].map(Four::length_squared);
        let [of_ab, of_ac, _] = lengths_squared;
        Self {
            corners: [a, b, c],
            ab,
            ac,
            bc,
            normal,
            area,
            is_flat: area.cmple(Vec4::splat(NO_AREA) * of_ab * of_ac),
            lengths_squared,
        }
    }

    /// Squared distances of a point in metres²; NaN for a triangle with a corner that is not finite.
    #[inline(always)]
    pub(super) fn distances_squared(&self, point: Vec3) -> [f32; LANES] {
        let point = Four::all(point);
        let [ap, bp, cp] = self.corners.map(|corner| point.minus(corner));
        let (d1, d2) = (self.ab.dot(ap), self.ac.dot(ap));
        let (d3, d4) = (self.ab.dot(bp), self.ac.dot(bp));
        let (d5, d6) = (self.ab.dot(cp), self.ac.dot(cp));
        let zero = Vec4::ZERO;
        let [of_ab, of_ac, of_bc] = self.lengths_squared;
        let ab = segment(ap, self.ab, d1, of_ab);
        let bc = segment(bp, self.bc, self.bc.dot(bp), of_bc);
        // From c to a, the direction in which the other function goes.
        let ca = segment(cp, self.ac.times(-Vec4::ONE), -d6, of_ac);
        let sides = ab.min(bc).min(ca);

        let beside = |side: Vec4, first: BVec4A, last: BVec4A| side.cmple(zero) & first & last;
        let beside_ab = beside(d1 * d4 - d3 * d2, d1.cmpge(zero), d3.cmple(zero));
        let beside_ac = beside(d5 * d2 - d1 * d6, d2.cmpge(zero), d6.cmple(zero));
        let beside_bc = beside(d3 * d6 - d5 * d4, d4.cmpge(d3), d5.cmpge(d6));
        let by_sides = self.is_flat | beside_ab | beside_ac | beside_bc;
        let height = self.normal.dot(ap);
        let found = Vec4::select(by_sides, sides, height * height / self.area);

        let at_c = d6.cmpge(zero) & d5.cmple(d6);
        let found = Vec4::select(at_c, cp.length_squared(), found);
        let at_b = d3.cmpge(zero) & d4.cmple(d3);
        let found = Vec4::select(at_b, bp.length_squared(), found);
        let at_a = d1.cmple(zero) & d2.cmple(zero);
        Vec4::select(at_a, ap.length_squared(), found).to_array()
    }
}

/// Squared distances to segments: `from` leads from their starts to the point, `along` is the
/// product of it and their direction.
#[inline(always)]
fn segment(from: Four, direction: Four, along: Vec4, length_squared: Vec4) -> Vec4 {
    let share = (along / length_squared).max(Vec4::ZERO).min(Vec4::ONE);
    let has_length = length_squared.cmpgt(Vec4::ZERO);
    let share = Vec4::select(has_length, share, Vec4::ZERO);
    from.minus(direction.times(share)).length_squared()
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::triangle_distance_squared;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn each_lane_has_the_bits_of_one_triangle(
            corners in prop::array::uniform12(prop::array::uniform3(-1.0f32..1.0)),
            shapes in prop::array::uniform4(0..5),
            thin in prop::array::uniform4(0.0f32..0.01),
            asked in prop::collection::vec(prop::array::uniform3(-2.0f32..2.0), 20),
        ) {
            let corner = |i: usize| Vec3::from_array(corners[i]);
            let triangle = |lane: usize| {
                let [a, b, c] = [0, 1, 2].map(|k| corner(3 * lane + k));
                match shapes[lane] {
                    0 => [a, a, b],
                    1 => [a, a, a],
                    // Around the least area that counts.
                    2 => [a, b, a.lerp(b, c.x) + c * thin[lane]],
                    _ => [a, b, c],
                }
            };
            let triangles = [0, 1, 2, 3].map(triangle);
            let four = FourTriangles::new(triangles);
            let asked = asked.into_iter().map(Vec3::from_array);
            // Corners and points on sides and faces too.
            let [a, b, c] = triangles[3];
            for point in asked.chain([a, b, c, a.lerp(b, 0.3), (a + b + c) / 3.0]) {
                let wanted = triangles.map(|t| triangle_distance_squared(point, t));
                let found = four.distances_squared(point);
                prop_assert_eq!(found.map(f32::to_bits), wanted.map(f32::to_bits), "{:?}", point);
            }
        }
    }

    #[test]
    fn a_corner_that_is_not_finite() {
        let right = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let four = FourTriangles::new([right, [Vec3::NAN; 3], right, right]);
        let [first, lost, _, last] = four.distances_squared(Vec3::new(0.25, 0.25, 2.0));
        assert_eq!([first, last], [4.0; 2]);
        assert!(lost.is_nan());
    }
}
