//! Borders of materials: the edges at which a surface of one colour ends.

use articula_core::Mesh;
use foldhash::{HashMap, HashMapExt};
use glam::Vec3;

/// Vertices on the borders of each material of a mesh.
#[derive(Debug, Clone, Default)]
pub struct Borders {
    of_material: HashMap<Option<usize>, Vec<u32>>,
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
        for vertices in of_material.values_mut() {
            vertices.sort_unstable();
            vertices.dedup();
        }
        Self { of_material }
    }

    /// The vertex on a border of a material that is nearest to a position at rest, and the square of its distance;
    /// `None` if the material has no border. O(vertices on borders).
    pub(super) fn nearest(
        &self,
        material: Option<usize>,
        at: Vec3,
        rest: &[Vec3],
    ) -> Option<(u32, f32)> {
        let vertices = self.of_material.get(&material)?;
        let distances = vertices
            .iter()
            .map(|v| (*v, rest[*v as usize].distance_squared(at)));
        distances.min_by(|(_, a), (_, b)| a.total_cmp(b))
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

    /// A strip of two squares, each of two triangles and four vertices of its own.
    fn strip(materials: [usize; 2]) -> (Mesh, Vec<Vec3>) {
        let square = |x: f32| {
            [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[a, b]| Vec3::new(x + a as f32, b as f32, 0.0))
        };
        let rest = [square(0.0), square(1.0)].concat();
        let part = |i: usize| Part {
            name: String::new(),
            mesh: 0,
            material: Some(materials[i]),
            vertices: 4 * i..4 * i + 4,
            triangles: 2 * i..2 * i + 2,
        };
        let mesh = Mesh {
            positions: rest.clone(),
            triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
            parts: vec![part(0), part(1)],
            ..Mesh::default()
        };
        (mesh, rest)
    }

    #[test]
    fn seams_are_no_borders_and_other_materials_are() {
        let (mesh, rest) = strip([3, 3]);
        let borders = Borders::of(&mesh, &rest);
        let at = Vec3::new(0.9, 0.4, 0.0);
        // The whole strip has one border, whose corners lie at the ends and, above and below, in the middle.
        assert_eq!(borders.of_material.len(), 1);
        assert_eq!(borders.nearest(Some(3), at, &rest).map(|n| n.0), Some(1));
        assert_eq!(borders.nearest(Some(4), at, &rest), None);
        let edges =
            |borders: &Borders, material| borders.of_material.get(&Some(material)).map(Vec::len);
        assert_eq!(edges(&borders, 3), Some(6), "two at each of three places");
        let (mesh, rest) = strip([3, 4]);
        let borders = Borders::of(&mesh, &rest);
        assert_eq!((edges(&borders, 3), edges(&borders, 4)), (Some(4), Some(4)));
    }
}
