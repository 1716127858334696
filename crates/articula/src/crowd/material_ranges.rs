//! What a renderer draws in one call: the triangles of a level that have one material, or several that differ in colour
//! alone.

use articula_core::Mesh;
use std::ops::Range;

/// The triangles of a mesh with one material, whichever parts of the file they come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MaterialRange {
    /// Material of the character, as [`Part::material`](articula_core::Part::material).
    pub material: Option<usize>,
    /// Range of [`Mesh::triangles`].
    pub triangles: Range<usize>,
    /// Whether its material differs from that of the range before in the base colour factor alone, so that both can be
    /// drawn in one call with the factor as colour of the vertices. Such ranges count as one draw.
    pub joins_previous: bool,
}

/// Sorts the triangles of a mesh so that those of a material follow each other, and returns the ranges of
/// the materials that have any, in the order of their first parts; those that can be drawn together follow each other.
pub(super) fn material_ranges(mesh: &mut Mesh) -> Vec<MaterialRange> {
    let mut drawn: Vec<Option<usize>> = Vec::new();
    let mut materials: Vec<[Option<usize>; 2]> = Vec::new();
    for part in &mesh.parts {
        let material = [part.draw_material, part.material];
        if !materials.contains(&material) {
            materials.push(material);
            drawn.push(part.draw_material);
        }
    }
    materials.sort_by_key(|[draw, _]| drawn.iter().position(|other| other == draw));
    let mut sorted = Vec::with_capacity(mesh.triangles.len());
    let mut ranges: Vec<MaterialRange> = Vec::with_capacity(materials.len());
    let mut last = None;
    for [draw, material] in materials {
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
                joins_previous: last == Some(draw),
            });
            last = Some(draw);
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
            draw_material: material,
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
            joins_previous: false,
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

    #[test]
    fn materials_that_are_drawn_together_follow_each_other() {
        let part = |[draw, own]: [usize; 2], triangles| Part {
            name: String::new(),
            mesh: 0,
            material: Some(own),
            draw_material: Some(draw),
            vertices: 0..9,
            triangles,
        };
        let mut mesh = Mesh {
            triangles: (0..8).map(|i: u32| [i, i + 1, i + 2]).collect(),
            parts: vec![
                // The material that the two others are drawn by has no triangle at this level.
                part([3, 3], 0..0),
                part([1, 1], 0..2),
                part([3, 5], 2..3),
                part([4, 4], 3..4),
                part([3, 6], 4..6),
                part([1, 7], 6..8),
            ],
            ..Mesh::default()
        };
        let ranges = material_ranges(&mut mesh);
        let told = ranges.iter();
        let told: Vec<_> = told
            .map(|r| (r.material, r.triangles.clone(), r.joins_previous))
            .collect();
        let expected = [
            (5, 0..1, false),
            (6, 1..3, true),
            (1, 3..5, false),
            (7, 5..7, true),
            (4, 7..8, false),
        ];
        assert_eq!(
            told,
            expected.map(|(m, range, joins)| (Some(m), range, joins))
        );
        assert_eq!(
            mesh.triangles.iter().map(|t| t[0]).collect::<Vec<_>>(),
            [2, 4, 5, 0, 1, 6, 7, 3]
        );
    }
}
