//! Borders of materials: the edges at which a surface of one colour ends.

use super::tree::{NO_TRIANGLE, SurfaceTree};
use articula_core::Mesh;
use foldhash::{HashMap, HashMapExt};
use glam::Vec3;

/// Vertices on the borders of each material of a mesh, as the points that they are at rest.
#[derive(Debug, Clone, Default)]
pub struct Borders {
    of_material: HashMap<Option<usize>, SurfaceTree>,
}

impl Borders {
    /// Finds the edges that belong to one triangle of their material alone. `rest` are positions of all vertices of the
    /// mesh; vertices at one place are one corner, so that seams and flat shading make no borders.
    ///
    /// # Panics
    /// If `rest` has fewer positions than the mesh has vertices.
    pub fn of(mesh: &Mesh, rest: &[Vec3]) -> Self {
        let corners = first_at_each_place(&rest[..mesh.len()]);
        let mut edges: HashMap<(Option<usize>, [u32; 2]), u32> = HashMap::new();
        for part in &mesh.parts {
            for [a, b, c] in &mesh.triangles[part.triangles.clone()] {
                for edge in [[a, b], [b, c], [c, a]] {
                    let mut edge = edge.map(|v| corners[*v as usize]);
                    edge.sort_unstable();
                    *edges.entry((part.material, edge)).or_default() += 1;
                }
            }
        }
        let mut of_material: HashMap<Option<usize>, Vec<u32>> = HashMap::new();
        for ((material, edge), triangles) in edges {
            if triangles == 1 {
                of_material.entry(material).or_default().extend(edge);
            }
        }
        let points = |mut vertices: Vec<u32>| {
            vertices.sort_unstable();
            vertices.dedup();
            let points: Vec<[u32; 3]> = vertices.into_iter().map(|v| [v; 3]).collect();
            SurfaceTree::new(&points, rest)
        };
        let of_material = of_material.into_iter();
        Self {
            of_material: of_material.map(|(m, v)| (m, points(v))).collect(),
        }
    }

    /// The vertex on a border of a material that is nearest to a finite position at rest; `None` if none is nearer
    /// than the squared distance `limit`.
    pub(super) fn nearest(&self, material: Option<usize>, at: Vec3, limit: f32) -> Option<u32> {
        let points = self.of_material.get(&material)?;
        let (_, place) = points.closest(at, NO_TRIANGLE, limit, 0.0)?;
        Some(points.corners(place)[0])
    }
}

/// The first vertex at the place of each.
fn first_at_each_place(positions: &[Vec3]) -> Vec<u32> {
    let mut first: HashMap<[u32; 3], u32> = HashMap::with_capacity(positions.len());
    // Both zeros are one place.
    let key = |p: &Vec3| (*p + Vec3::ZERO).to_array().map(f32::to_bits);
    let of = |(v, p): (usize, &Vec3)| *first.entry(key(p)).or_insert(v as u32);
    positions.iter().enumerate().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::Part;

    /// Four squares around a corner, each of two triangles and four vertices of its own.
    fn squares(materials: [usize; 4]) -> (Mesh, Vec<Vec3>) {
        let square = |i: usize| {
            let low = Vec3::new((i % 2) as f32, (i / 2) as f32, 0.0);
            [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y].map(|corner| low + corner)
        };
        let rest: Vec<Vec3> = (0..4).flat_map(square).collect();
        let part = |i: usize| Part {
            name: String::new(),
            mesh: 0,
            material: Some(materials[i]),
            draw_material: Some(materials[i]),
            vertices: 4 * i..4 * i + 4,
            triangles: 2 * i..2 * i + 2,
        };
        let halves = |i: u32| [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|v: u32| 4 * i + v));
        let mesh = Mesh {
            positions: rest.clone(),
            triangles: (0..4).flat_map(halves).collect(),
            parts: (0..4).map(part).collect(),
            ..Mesh::default()
        };
        (mesh, rest)
    }

    #[test]
    fn seams_are_no_borders_and_other_materials_are() {
        let nearest = |materials, material| {
            let (mesh, rest) = squares(materials);
            let borders = Borders::of(&mesh, &rest);
            let at = Vec3::new(1.0, 0.9, 0.0);
            let found = borders.nearest(Some(material), at, f32::INFINITY);
            found.map(|v| rest[v as usize])
        };
        let middle = Vec3::new(1.0, 1.0, 0.0);
        assert_eq!(nearest([3; 4], 3), Some(Vec3::X), "the middle is inside");
        assert_eq!(nearest([3, 3, 3, 4], 3), Some(middle));
        assert_eq!(nearest([3, 3, 3, 4], 4), Some(middle));
        assert_eq!(nearest([3; 4], 4), None);
        let (mesh, rest) = squares([3; 4]);
        let borders = Borders::of(&mesh, &rest);
        let within = |limit| borders.nearest(Some(3), Vec3::new(1.0, 0.5, 0.0), limit);
        assert!(within(0.26).is_some() && within(0.25).is_none());
    }
}
