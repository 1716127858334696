//! Bounding boxes, one or four at once.

use super::four_triangles::LANES;
use glam::{Vec3, Vec4};

/// A bounding box; the empty one is upside down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds {
    pub(super) lo: Vec3,
    pub(super) hi: Vec3,
}

impl Bounds {
    /// The empty box, at infinite distance from every point.
    pub(super) const EMPTY: Self = Self {
        lo: Vec3::INFINITY,
        hi: Vec3::NEG_INFINITY,
    };

    /// Box of the triangles whose corners are finite.
    pub(super) fn around(triangles: &[[Vec3; 3]]) -> Self {
        let mut bounds = Self::EMPTY;
        for corner in triangles.iter().filter(|t| t[0].is_finite()).flatten() {
            bounds.lo = bounds.lo.min(*corner);
            bounds.hi = bounds.hi.max(*corner);
        }
        bounds
    }

    /// Squared distance of a point to the box; infinite if it is empty.
    pub(super) fn squared_distance(&self, point: Vec3) -> f32 {
        let out = (self.lo - point).max(point - self.hi).max(Vec3::ZERO);
        out.length_squared()
    }
}

/// Four boxes, one in each lane.
#[derive(Debug, Clone, Copy)]
pub(super) struct FourBounds {
    lo: [Vec4; 3],
    hi: [Vec4; 3],
}

impl FourBounds {
    pub(super) const EMPTY: Self = Self {
        lo: [Vec4::INFINITY; 3],
        hi: [Vec4::NEG_INFINITY; 3],
    };

    pub(super) fn set(&mut self, lane: usize, bounds: Bounds) {
        for axis in 0..3 {
            self.lo[axis][lane] = bounds.lo[axis];
            self.hi[axis][lane] = bounds.hi[axis];
        }
    }

    /// The box around all four.
    pub(super) fn all(&self) -> Bounds {
        Bounds {
            lo: Vec3::from_array(self.lo.map(Vec4::min_element)),
            hi: Vec3::from_array(self.hi.map(Vec4::max_element)),
        }
    }

    /// Squared distances of a point to the boxes; infinite to empty ones.
    #[inline(always)]
    pub(super) fn squared_distances(&self, point: Vec3) -> [f32; LANES] {
        let [x, y, z] = [0, 1, 2].map(|axis| {
            let at = Vec4::splat(point[axis]);
            (self.lo[axis] - at).max(at - self.hi[axis]).max(Vec4::ZERO)
        });
        (x * x + y * y + z * z).to_array()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_to_a_box_by_hand() {
        let bounds = Bounds {
            lo: Vec3::new(1.0, 2.0, 3.0),
            hi: Vec3::new(2.0, 4.0, 6.0),
        };
        let mut four = FourBounds::EMPTY;
        four.set(2, bounds);
        assert_eq!(four.all(), bounds);
        for (point, squared) in [
            ([1.5, 3.0, 4.0], 0.0),
            ([2.0, 4.0, 6.0], 0.0),
            ([-1.0, 3.0, 4.0], 4.0),
            ([5.0, 8.0, 4.0], 25.0),
            ([0.0, 0.0, 1.0], 9.0),
        ] {
            let point = Vec3::from_array(point);
            assert_eq!(bounds.squared_distance(point), squared);
            let of_four = four.squared_distances(point);
            assert_eq!(
                of_four,
                [f32::INFINITY, f32::INFINITY, squared, f32::INFINITY]
            );
        }
        assert_eq!(Bounds::EMPTY.squared_distance(Vec3::ONE), f32::INFINITY);
    }

    #[test]
    fn triangles_that_are_not_finite_have_no_box() {
        let right = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let found = Bounds::around(&[[Vec3::NAN; 3], right]);
        assert_eq!((found.lo, found.hi), (Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0)));
        assert_eq!(Bounds::around(&[[Vec3::NAN; 3]]), Bounds::EMPTY);
    }
}
