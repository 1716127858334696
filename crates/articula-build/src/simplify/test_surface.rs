//! Meshes with what the simplifier derives from them, for tests.

use super::SimplifyOptions;
use super::classes::Classes;
use super::cost::Costs;
use super::levels::{Sources, faces};
use super::shapes::{mesh, sheet};
use super::topology::Surface;
use articula_core::Mesh;
use glam::{Vec2, Vec3};
use proptest::prelude::*;

/// A mesh with its poses and the surface of its classes.
pub(super) struct TestSurface {
    pub(super) mesh: Mesh,
    pub(super) poses: Vec<Vec<Vec3>>,
    pub(super) classes: Classes,
    pub(super) sources: Sources,
    pub(super) surface: Surface,
}

impl TestSurface {
    /// Takes the positions of the mesh as the rest pose.
    pub(super) fn new(mesh: Mesh, others: &[Vec<Vec3>]) -> Self {
        let mut poses = vec![mesh.positions.clone()];
        poses.extend_from_slice(others);
        let classes = Classes::new(&mesh, &poses, &[]);
        let sources = faces(&mesh, &classes);
        let surface = Surface::new(&sources.triangles, &classes);
        Self {
            mesh,
            poses,
            classes,
            sources,
            surface,
        }
    }

    pub(super) fn costs(&self, options: &SimplifyOptions) -> Costs {
        Costs::new(
            &self.mesh,
            &self.poses,
            options,
            &self.classes,
            &self.surface,
        )
    }
}

/// A sheet of `n * n` quads whose faces beyond `x = split` have vertices of their own, with other
/// texture coordinates. The first `(n + 1)²` vertices are those of [`sheet`].
pub(super) fn charted(n: usize, split: f32) -> Mesh {
    let plain = sheet(n);
    let count = plain.len() as u32;
    let beyond = |t: &[u32; 3]| t.iter().any(|v| plain.positions[*v as usize].x > split);
    let own = |t: &[u32; 3]| if beyond(t) { t.map(|v| v + count) } else { *t };
    let triangles = plain.triangles.iter().map(own).collect();
    let mut both = mesh(plain.positions.repeat(2), triangles);
    both.texcoords[count as usize..].fill(Vec2::new(0.25, 0.5));
    both
}

/// Moves points by up to `most` along each axis, differently for each.
pub(super) fn shaken(points: &[Vec3], most: f32) -> Vec<Vec3> {
    let part = |i: usize, k: usize| ((i * 37 + k * 11 + 5) * 7919 % 1000) as f32 / 500.0 - 1.0;
    let moved = |(i, p): (usize, &Vec3)| *p + Vec3::new(part(i, 0), part(i, 1), part(i, 2)) * most;
    points.iter().enumerate().map(moved).collect()
}

/// Random triangles with three different corners over a few classes, one vertex each.
pub(super) fn tangle() -> impl Strategy<Value = (Classes, Vec<[u32; 3]>)> {
    let corner = 0u32..9;
    let triangles = prop::collection::vec(prop::array::uniform3(corner), 1..30);
    triangles.prop_map(|mut triangles| {
        triangles.retain(|[a, b, c]| a != b && b != c && c != a);
        let classes = Classes {
            of_vertex: (0..9).collect(),
            first: (0..9).collect(),
            chart: vec![0; 9],
            ..Classes::default()
        };
        (classes, triangles)
    })
}
