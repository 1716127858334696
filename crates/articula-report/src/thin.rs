//! Triangles of a figure in the distance, without those that no pixel tells apart.
//!
//! Vertex clustering after Rossignac and Borrel 1993: the vertices within a cell of a grid become the
//! first of them, and triangles of fewer than three cells go.

use glam::Vec3;
use std::collections::{HashMap, HashSet};

/// Thins triangles to a grid of cells in metres, all of them for a cell of 0. Returns the vertices that
/// are used, and the triangles over these.
///
/// # Panics
/// If a triangle has a vertex without a place.
pub(crate) fn thinned(
    places: &[Vec3],
    triangles: &[[u32; 3]],
    cell_m: f32,
) -> (Vec<u32>, Vec<[u32; 3]>) {
    let mut kept: Vec<u32> = Vec::new();
    let mut of_vertex: HashMap<u32, u32> = HashMap::new();
    let mut of_cell: HashMap<[i32; 3], u32> = HashMap::new();
    let mut index = |vertex: u32| {
        *of_vertex.entry(vertex).or_insert_with(|| {
            let new = kept.len() as u32;
            let found = match cell_m > 0.0 {
                true => {
                    let cell = (places[vertex as usize] / cell_m).floor();
                    *of_cell
                        .entry(cell.to_array().map(|v| v as i32))
                        .or_insert(new)
                }
                false => new,
            };
            if found == new {
                kept.push(vertex);
            }
            found
        })
    };
    let moved: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(&mut index)).collect();
    if cell_m <= 0.0 {
        return (kept, moved);
    }
    let mut seen = HashSet::new();
    let is_new = |t: &[u32; 3]| {
        let [a, b, c] = *t;
        let mut sorted = *t;
        sorted.sort_unstable();
        a != b && b != c && c != a && seen.insert(sorted)
    };
    (kept, moved.into_iter().filter(is_new).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of the plane of `n` by `n` steps of 1, of two triangles each.
    fn square(n: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let side = n + 1;
        let place = |i: u32| Vec3::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5, 0.5);
        let corner = |i: u32| i / n * side + i % n;
        let both = |a: u32| [[a, a + 1, a + side], [a + 1, a + side + 1, a + side]];
        (
            (0..side * side).map(place).collect(),
            (0..n * n).flat_map(|i| both(corner(i))).collect(),
        )
    }

    #[test]
    fn a_cell_keeps_one_vertex_and_the_area_stays() {
        let (places, triangles) = square(8);
        let (all, same) = thinned(&places, &triangles, 0.0);
        assert_eq!((all.len(), same.len()), (81, 128));
        // Cells of two steps: 9 vertices a side in cells of 2 are 5.
        let (kept, thin) = thinned(&places, &triangles, 2.0);
        assert_eq!((kept.len(), thin.len()), (25, 32));
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| places[kept[v as usize] as usize]);
            0.5 * (b - a).cross(c - a).length()
        };
        assert_eq!(thin.iter().map(area).sum::<f32>(), 64.0);
        let (_, gone) = thinned(&places, &triangles, 100.0);
        assert!(gone.is_empty());
    }
}
