//! Vertices and what moves them, without influences of no weight.

use articula_core::Mesh;
use glam::{Affine3A, Vec3, Vec3A};

/// Vertices before they are skinned, with their influences one after another.
#[derive(Debug, Clone)]
pub(super) struct Skin {
    points: Vec<Vec3A>,
    /// Where the influences of each vertex start, and the end of the last.
    starts: Vec<u32>,
    /// Bindings and weights.
    influences: Vec<(u16, f32)>,
}

impl Skin {
    pub(super) fn new(mesh: &Mesh, points: &[Vec3]) -> Self {
        let mut skin = Self {
            points: points.iter().map(|point| Vec3A::from(*point)).collect(),
            starts: vec![0],
            influences: Vec::with_capacity(points.len()),
        };
        for vertex in 0..points.len() {
            let of_vertex = vertex * mesh.influences..(vertex + 1) * mesh.influences;
            let bindings = mesh.binding_indices[of_vertex.clone()].iter();
            let pairs = bindings
                .copied()
                .zip(mesh.weights[of_vertex].iter().copied());
            skin.influences
                .extend(pairs.filter(|(_, weight)| *weight > 0.0));
            skin.starts.push(skin.influences.len() as u32);
        }
        skin
    }

    /// The points before they are skinned.
    pub(super) fn points(&self) -> &[Vec3A] {
        &self.points
    }

    /// Bindings and weights of a vertex.
    pub(super) fn influences(&self, vertex: usize) -> &[(u16, f32)] {
        let [start, end] = [self.starts[vertex], self.starts[vertex + 1]];
        &self.influences[start as usize..end as usize]
    }

    /// A vertex by the matrices of all bindings.
    pub(super) fn at(&self, vertex: usize, palette: &[Affine3A]) -> Vec3A {
        let point = self.points[vertex];
        let moved = |(binding, weight): &(u16, f32)| {
            *weight * palette[usize::from(*binding)].transform_point3a(point)
        };
        let influences = self.influences(vertex).iter();
        influences.fold(Vec3A::ZERO, |sum, influence| sum + moved(influence))
    }
}
