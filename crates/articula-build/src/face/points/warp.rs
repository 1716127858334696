//! A smooth warp of space through pairs of points.
//!
//! Source: radial basis functions with the kernel -|r| and an affine part (Duchon 1977: the
//! biharmonic spline in three dimensions).

use super::super::dense;
use glam::{DVec3, Vec3};

/// Added to the diagonal: allows small misses, in units of the spread of the points.
const SMOOTHING: f64 = 1e-3;

/// The warp that moves each of some points near to its partner.
#[derive(Debug, Clone)]
pub(in crate::face) struct Warp {
    from: Vec<DVec3>,
    /// Unit of lengths, and origin.
    unit: f64,
    middle: DVec3,
    /// Coefficient of each point, then those of 1, x, y and z.
    coefficients: Vec<DVec3>,
}

impl Warp {
    /// Fits the warp. `None` if there are fewer than four points or they lie in a plane.
    pub(super) fn fit(pairs: &[(Vec3, Vec3)]) -> Option<Self> {
        let count = pairs.len();
        if count < 4 {
            return None;
        }
        let middle = pairs.iter().map(|p| p.0.as_dvec3()).sum::<DVec3>() / count as f64;
        let spread = pairs
            .iter()
            .map(|p| (p.0.as_dvec3() - middle).length_squared());
        let unit = (spread.sum::<f64>() / count as f64).sqrt();
        if unit <= 0.0 {
            return None;
        }
        let from: Vec<DVec3> = pairs
            .iter()
            .map(|p| (p.0.as_dvec3() - middle) / unit)
            .collect();
        let n = count + 4;
        let mut matrix = vec![0.0; n * n];
        let mut right = vec![0.0; n * 3];
        for (i, a) in from.iter().enumerate() {
            for (j, b) in from.iter().enumerate() {
                matrix[i * n + j] = -a.distance(*b);
            }
            matrix[i * n + i] = SMOOTHING;
            for (k, x) in [1.0, a.x, a.y, a.z].into_iter().enumerate() {
                matrix[i * n + count + k] = x;
                matrix[(count + k) * n + i] = x;
            }
            right[i * 3..i * 3 + 3].copy_from_slice(&pairs[i].1.as_dvec3().to_array());
        }
        dense::solve(&mut matrix, &mut right, 3)?;
        let coefficients = right.chunks_exact(3).map(DVec3::from_slice).collect();
        Some(Self {
            from,
            unit,
            middle,
            coefficients,
        })
    }

    /// Moves a place.
    pub(in crate::face) fn apply(&self, place: Vec3) -> Vec3 {
        let at = (place.as_dvec3() - self.middle) / self.unit;
        let (radial, affine) = self.coefficients.split_at(self.from.len());
        let basis = [1.0, at.x, at.y, at.z];
        let affine = affine.iter().zip(basis).map(|(c, x)| *c * x);
        let radial = radial.iter().zip(&self.from);
        let radial = radial.map(|(c, from)| *c * -at.distance(*from));
        (affine.sum::<DVec3>() + radial.sum::<DVec3>()).as_vec3()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_affine_map_comes_back_everywhere() {
        let map = |p: Vec3| Vec3::new(1.2 * p.x + 0.1 * p.y, 0.8 * p.y - 0.3, p.z + 0.2 * p.x);
        let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
        let pairs: Vec<(Vec3, Vec3)> = (0..8).map(|i| (corner(i), map(corner(i)))).collect();
        let warp = Warp::fit(&pairs).unwrap();
        for place in [Vec3::new(0.3, 0.4, 0.9), Vec3::new(-2.0, 3.0, 0.5)] {
            assert!(warp.apply(place).distance(map(place)) < 1e-5);
        }
    }

    #[test]
    fn points_are_nearly_met() {
        let from = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE];
        let to = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::splat(1.4)];
        let pairs: Vec<(Vec3, Vec3)> = from.into_iter().zip(to).collect();
        let warp = Warp::fit(&pairs).unwrap();
        for (from, to) in &pairs {
            assert!(warp.apply(*from).distance(*to) < 2e-3);
        }
    }

    #[test]
    fn points_of_a_plane_make_no_warp() {
        let pairs: Vec<(Vec3, Vec3)> = (0..6)
            .map(|i| Vec3::new(i as f32, (i * i) as f32, 0.0))
            .map(|p| (p, p))
            .collect();
        assert!(Warp::fit(&pairs).is_none() && Warp::fit(&pairs[..3]).is_none());
    }
}
