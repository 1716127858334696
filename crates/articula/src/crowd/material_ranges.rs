//! What a renderer draws in one call: the triangles of a level that have one material.

use articula_core::Mesh;
use std::ops::Range;

/// The triangles of a mesh with one material, whichever parts of the file they come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MaterialRange {
    /// Material of the character, as [`Part::material`](articula_core::Part::material).
    pub material: Option<usize>,
    /// Range of [`Mesh::triangles`].
    pub triangles: Range<usize>,
}

/// Sorts the triangles of a mesh so that those of a material follow each other, and returns the ranges of
/// the materials that have any, in the order of their first parts.
pub(super) fn material_ranges(mesh: &mut Mesh) -> Vec<MaterialRange> {
    let mut materials: Vec<Option<usize>> = Vec::new();
    for part in &mesh.parts {
        if !materials.contains(&part.material) {
            materials.push(part.material);
        }
    }
    let mut sorted = Vec::with_capacity(mesh.triangles.len());
    let mut ranges = Vec::with_capacity(materials.len());
    for material in materials {
        let start = sorted.len();
        for part in mesh.parts.iter_mut().filter(|p| p.material == material) {
            let first = sorted.len();
            sorted.extend_from_slice(&mesh.triangles[part.triangles.clone()]);
            part.triangles = first..sorted.len();
        }
        if sorted.len() > start {
            ranges.push(MaterialRange {
                material,
                triangles: start..sorted.len(),
            });
        }
    }
    // Points on the bones of a character without a mesh have no parts, and no triangles.
    mesh.triangles = sorted;
    ranges
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::Part;

    #[test]
    fn parts_of_one_material_are_one_range() {
        let part = |material, triangles| Part {
            name: String::new(),
            mesh: 0,
            material,
            vertices: 0..9,
            triangles,
        };
        let triangle = |i: u32| [i, i + 1, i + 2];
        let mut mesh = Mesh {
            triangles: (0..7).map(triangle).collect(),
            parts: vec![
                part(Some(4), 0..2),
                part(None, 2..3),
                part(Some(4), 3..6),
                // A level may have lost a whole part.
                part(Some(1), 6..6),
                part(None, 6..7),
            ],
            ..Mesh::default()
        };
        let before = mesh.clone();
        let ranges = material_ranges(&mut mesh);
        let expected = [(Some(4), 0..5), (None, 5..7)];
        let expected = expected.map(|(material, triangles)| MaterialRange {
            material,
            triangles,
        });
        assert_eq!(ranges, expected);
        assert_eq!(mesh.triangles, [0, 1, 3, 4, 5, 2, 6].map(triangle));
        // Every part has its own triangles.
        for (part, was) in mesh.parts.iter().zip(&before.parts) {
            let own = &mesh.triangles[part.triangles.clone()];
            assert_eq!(own, &before.triangles[was.triangles.clone()]);
        }
        assert!(material_ranges(&mut Mesh::default()).is_empty());
    }
}
