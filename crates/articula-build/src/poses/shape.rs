//! Shape of the skin in a pose, and the distance of two shapes.
//!
//! Source: Horn, Closed-form solution of absolute orientation using unit quaternions (1987): the
//! best rotation is the principal eigenvector of a symmetric 4 x 4 matrix.

use super::skin_pose::SkinPose;
use crate::character::Asset;
use crate::joint_lods::principal;
use crate::part_mesh::part_mesh;
use crate::points::draw_vertices;
use articula_core::Mesh;
use glam::{DMat3, DMat4, DVec3, DVec4, Quat};

/// Number of vertices in the sample of the skin.
const WATCHED: usize = 512;

/// The sampled vertices of a mesh, as a mesh.
#[derive(Debug)]
pub(super) struct Sample {
    mesh: Mesh,
}

/// The sampled vertices in one pose, relative to their mean.
#[derive(Debug, Clone)]
pub(super) struct Shape {
    points: Vec<DVec3>,
    /// Sum of squared lengths.
    size: f64,
}

impl Sample {
    /// Draws a random sample of vertices and keeps the finite ones.
    pub(super) fn draw(mesh: &Mesh, seed: u64) -> Self {
        let mut vertices = draw_vertices(mesh.len(), WATCHED, seed);
        vertices.retain(|v| mesh.positions[*v as usize].is_finite());
        let mesh = part_mesh(mesh, &vertices);
        Self { mesh }
    }

    /// Returns the shape in a pose; `None` if there is no vertex or one is not finite.
    pub(super) fn shape(&self, asset: &Asset, pose: &SkinPose) -> Option<Shape> {
        if self.mesh.is_empty() {
            return None;
        }
        let points = pose.positions_of(asset, &self.mesh);
        let points: Vec<DVec3> = points.iter().map(|p| p.as_dvec3()).collect();
        let mean = points.iter().sum::<DVec3>() / points.len() as f64;
        let points: Vec<DVec3> = points.iter().map(|p| *p - mean).collect();
        let size: f64 = points.iter().map(|p| p.length_squared()).sum();
        size.is_finite().then_some(Shape { points, size })
    }
}

impl Shape {
    /// Diagonal of the bounding box. Positions of a mesh itself may have any unit, of which bind matrices make metres.
    pub(super) fn diagonal_metres(&self) -> f32 {
        let points = || self.points.iter().copied();
        let (low, high) = (points().reduce(DVec3::min), points().reduce(DVec3::max));
        low.zip(high)
            .map_or(0.0, |(low, high)| (high - low).length() as f32)
    }

    /// Root mean square distance to another shape of the same sample after the best rotation, in
    /// metres.
    pub(super) fn separation_metres(&self, other: &Self) -> f32 {
        let mut sum = DMat3::ZERO;
        for (a, b) in self.points.iter().zip(&other.points) {
            sum += DMat3::from_cols(*a * b.x, *a * b.y, *a * b.z);
        }
        let horn = horn(&sum);
        // The trace is 0: shifted by its size the matrix has no negative eigenvalue, so that the
        // largest eigenvalue is also the largest in magnitude.
        let shift = self.size + other.size;
        let q = principal(horn + DMat4::IDENTITY * shift, Quat::IDENTITY);
        let q = DVec4::from_array(q.to_array().map(f64::from)).normalize();
        let greatest = q.dot(horn * q);
        let squares = self.size + other.size - 2.0 * greatest;
        (squares.max(0.0) / self.points.len() as f64).sqrt() as f32
    }
}

/// The matrix whose quadratic form is the sum of `a . (q b)` over all pairs, for a unit
/// quaternion (x, y, z, w); `sum` is that of the products `a bᵀ`.
fn horn(sum: &DMat3) -> DMat4 {
    // s(i, j): component i of a times component j of b.
    let s = |i: usize, j: usize| sum.col(j)[i];
    let (yz, zx, xy) = (s(2, 1) - s(1, 2), s(0, 2) - s(2, 0), s(1, 0) - s(0, 1));
    let (x, y, z) = (s(0, 0), s(1, 1), s(2, 2));
    let (pxy, pyz, pzx) = (s(0, 1) + s(1, 0), s(1, 2) + s(2, 1), s(2, 0) + s(0, 2));
    DMat4::from_cols(
        DVec4::new(x - y - z, pxy, pzx, yz),
        DVec4::new(pxy, y - x - z, pyz, zx),
        DVec4::new(pzx, pyz, z - x - y, xy),
        DVec4::new(yz, zx, xy, x + y + z),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Affine3A, Vec3};
    use proptest::prelude::*;
    use std::sync::Arc;

    fn shape(points: &[DVec3]) -> Shape {
        let mean = points.iter().sum::<DVec3>() / points.len() as f64;
        let points: Vec<DVec3> = points.iter().map(|p| *p - mean).collect();
        let size = points.iter().map(|p| p.length_squared()).sum();
        Shape { points, size }
    }

    #[test]
    fn the_unit_of_the_mesh_does_not_count() {
        let asset = crate::joint_lods::test_figures::arm(3);
        let rest = SkinPose::rest(&asset);
        let diagonal = |asset: &Asset| {
            let sample = Sample::draw(&asset.mesh, 1);
            sample.shape(asset, &rest).unwrap().diagonal_metres()
        };
        let mut other = asset.clone();
        let mesh = Arc::make_mut(&mut other.mesh);
        for p in &mut mesh.positions {
            *p *= 1000.0;
        }
        for binding in &mut mesh.bindings {
            binding.inverse_bind *= Affine3A::from_scale(Vec3::splat(1e-3));
        }
        let (one, many) = (diagonal(&asset), diagonal(&other));
        assert!(one > 0.0 && (one - many).abs() < 1e-4 * one, "{one} {many}");
    }

    #[test]
    fn by_hand() {
        let line = |half: f64| shape(&[DVec3::X * half, DVec3::X * -half]);
        assert!((line(1.0).separation_metres(&line(1.5)) - 0.5).abs() < 1e-6);
        let upright = shape(&[DVec3::Y * 1.5, DVec3::Y * -1.5]);
        assert!(
            (line(1.0).separation_metres(&upright) - 0.5).abs() < 1e-6,
            "turned"
        );
        // Mirrored shapes differ: the best rotation leaves the third axis wrong.
        let cross = |z: f64| {
            let ends = [DVec3::X * 3.0, DVec3::Y * 2.0, DVec3::Z * z];
            shape(&[ends[0], ends[1], ends[2], -ends[0] - ends[1] - ends[2]])
        };
        assert!(cross(1.0).separation_metres(&cross(-1.0)) > 0.1);
    }

    proptest! {
        #[test]
        fn a_rigid_motion_is_no_distance_and_a_shift_of_one_point_is(
            points in prop::collection::vec(prop::array::uniform3(-1.0f64..1.0), 8..20),
            turn in prop::array::uniform3(-3.0f64..3.0),
            way in prop::array::uniform3(-50.0f64..50.0),
            push in 0.01f64..0.5,
        ) {
            let points: Vec<DVec3> = points.into_iter().map(DVec3::from_array).collect();
            let q = glam::DQuat::from_scaled_axis(DVec3::from_array(turn));
            let mut moved: Vec<DVec3> = points.iter().map(|p| q * *p + DVec3::from_array(way)).collect();
            let here = shape(&points);
            prop_assert!(here.separation_metres(&shape(&moved)) < 1e-5);
            moved[0].x += push;
            let apart = here.separation_metres(&shape(&moved));
            // The motion that leaves all other points in place is no better than the best one.
            prop_assert!(apart <= (push * push / points.len() as f64).sqrt() as f32 + 1e-5);
            prop_assert!((apart - shape(&moved).separation_metres(&here)).abs() < 1e-5);
        }
    }
}
