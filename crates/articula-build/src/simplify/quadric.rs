//! Sums of squared distances to planes: the cost of moving a vertex.
//!
//! Source: Garland and Heckbert, *Surface simplification using quadric error metrics* (1997).

use glam::DVec3;

/// A symmetric quadratic form over points in space.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Quadric {
    /// xx, xy, xz, yy, yz, zz.
    a: [f64; 6],
    b: DVec3,
    c: f64,
    /// Sum of weights.
    pub(super) weight: f64,
}

impl Quadric {
    /// `weight` times the squared distance to the plane through `point` with the unit normal
    /// `normal`.
    pub(super) fn plane(normal: DVec3, point: DVec3, weight: f64) -> Self {
        let (n, d) = (normal, -normal.dot(point));
        Self {
            a: [
                n.x * n.x,
                n.x * n.y,
                n.x * n.z,
                n.y * n.y,
                n.y * n.z,
                n.z * n.z,
            ]
            .map(|v| v * weight),
            b: n * (d * weight),
            c: d * d * weight,
            weight,
        }
    }

    /// Adds another quadric.
    pub(super) fn add(&mut self, o: &Self) {
        for (a, b) in self.a.iter_mut().zip(o.a) {
            *a += b;
        }
        self.b += o.b;
        self.c += o.c;
        self.weight += o.weight;
    }

    /// Value at a point; never below 0.
    pub(super) fn at(&self, p: DVec3) -> f64 {
        let [xx, xy, xz, yy, yz, zz] = self.a;
        let row = DVec3::new(
            xx * p.x + xy * p.y + xz * p.z,
            xy * p.x + yy * p.y + yz * p.z,
            xz * p.x + yz * p.y + zz * p.z,
        );
        (p.dot(row) + 2.0 * self.b.dot(p) + self.c).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_costs_its_weight_times_the_squared_distance() {
        let mut q = Quadric::plane(DVec3::Z, DVec3::new(5.0, -2.0, 1.0), 3.0);
        assert!((q.at(DVec3::new(7.0, 7.0, 3.0)) - 12.0).abs() < 1e-12);
        q.add(&Quadric::plane(DVec3::X, DVec3::ZERO, 2.0));
        // 3 * (3 - 1)^2 + 2 * 7^2.
        assert!((q.at(DVec3::new(7.0, 7.0, 3.0)) - 110.0).abs() < 1e-12);
        assert_eq!(q.at(DVec3::new(0.0, 0.0, 1.0)), 0.0);
    }

    #[test]
    fn a_sum_of_planes_is_the_sum_of_their_squared_distances() {
        let planes = [
            (
                DVec3::new(2.0, 3.0, 6.0) / 7.0,
                DVec3::new(1.0, -2.0, 4.0),
                0.5,
            ),
            (
                DVec3::new(-6.0, 2.0, 3.0) / 7.0,
                DVec3::new(3.0, 5.0, -1.0),
                2.0,
            ),
            (
                DVec3::new(3.0, -6.0, 2.0) / 7.0,
                DVec3::new(-4.0, 0.5, 2.5),
                3.0,
            ),
        ];
        let mut sum = Quadric::default();
        for (normal, point, weight) in planes {
            sum.add(&Quadric::plane(normal, point, weight));
        }
        assert_eq!(sum.weight, 5.5);
        for p in [
            [0.0, 0.0, 0.0],
            [1.0, -2.0, 3.0],
            [-5.0, 4.0, 2.0],
            [2.5, 7.0, -6.0],
        ] {
            let p = DVec3::from_array(p);
            let one = |(n, point, weight): &(DVec3, DVec3, f64)| weight * n.dot(p - point).powi(2);
            let expected: f64 = planes.iter().map(one).sum();
            assert!((sum.at(p) - expected).abs() < 1e-9 * expected.max(1.0));
        }
    }

    #[test]
    fn rounding_makes_no_value_negative() {
        let normal = DVec3::new(0.1, 0.7, 0.3).normalize();
        for i in 0..200 {
            let point = DVec3::new(1e6 + f64::from(i), -3e5, 7e5 / f64::from(i + 1));
            assert!(Quadric::plane(normal, point, 1.0).at(point) >= 0.0);
        }
    }
}
