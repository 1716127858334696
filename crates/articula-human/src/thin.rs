//! Simplification of a surface to a given number of triangles.
//!
//! It uses [`simplify`], so vertices of the finer surface stay where the distance field put them.
//! This module adds the importance of errors by position, and makes the tones parts of one
//! mesh, so that their borders are kept as seams. The open rim of a half surface stays in its plane.

use crate::polygonise::Surface;
use articula_build::{ErrorWeighting, SimplifyOptions, simplify};
use articula_core::{Mesh, Part};
use glam::{Vec2, Vec3, Vec4};

/// Options of [`thinned`].
pub(crate) struct Options<'a> {
    /// Number of triangles to keep.
    pub(crate) target: usize,
    /// Whether the open rim lies in the plane x = 0, where the surface is mirrored.
    pub(crate) mirrored: bool,
    /// Weight of squared errors at a point; 1 is normal.
    pub(crate) importance: &'a dyn Fn(Vec3) -> f32,
}

/// Simplifies a surface until the target is met or no further collapse is allowed.
pub(crate) fn thinned(surface: &Surface, options: &Options<'_>) -> Surface {
    let count = surface.triangles.len();
    if options.target >= count {
        return surface.clone();
    }
    let (mesh, originals) = mesh(surface);
    let simplified = simplify(
        &mesh,
        std::slice::from_ref(&mesh.positions),
        &SimplifyOptions {
            targets: vec![1.0, options.target as f64 / count as f64],
            weighting: ErrorWeighting::Rest,
            vertex_weights: mesh
                .positions
                .iter()
                .map(|p| (options.importance)(*p))
                .collect(),
            mirrored: options.mirrored,
            measured: false,
            ..SimplifyOptions::default()
        },
    );
    let level = simplified.map(|s| s.levels.into_iter().next_back().unwrap_or_default());
    let level =
        level.expect("the lengths match the generated mesh, and the targets begin at 1 and fall");
    let mut out = Surface::default();
    let mut renamed = vec![u32::MAX; surface.positions.len()];
    for (tone, part) in (0..=u8::MAX).zip(&level.parts) {
        for t in &level.triangles[part.clone()] {
            out.triangles.push(t.map(|v| {
                let v = originals[v as usize] as usize;
                if renamed[v] == u32::MAX {
                    renamed[v] = out.positions.len() as u32;
                    out.positions.push(surface.positions[v]);
                }
                renamed[v]
            }));
            if !surface.tones.is_empty() {
                out.tones.push(tone);
            }
        }
    }
    out
}

/// The surface as a mesh with a part for each tone, and the original of each of its vertices.
/// Vertices on the border of the tones are in both parts.
fn mesh(surface: &Surface) -> (Mesh, Vec<u32>) {
    let normals = normals(surface);
    let mut mesh = Mesh::default();
    let mut originals = Vec::new();
    let last = surface.tones.iter().max().copied().unwrap_or(1);
    for tone in 0..=last.max(1) {
        let (first_vertex, first_triangle) = (originals.len(), mesh.triangles.len());
        let mut renamed = vec![u32::MAX; surface.positions.len()];
        for (t, triangle) in surface.triangles.iter().enumerate() {
            if surface.tones.get(t).copied().unwrap_or(0) != tone {
                continue;
            }
            mesh.triangles.push(triangle.map(|v| {
                let new = &mut renamed[v as usize];
                if *new == u32::MAX {
                    *new = originals.len() as u32;
                    originals.push(v);
                }
                *new
            }));
        }
        mesh.parts.push(Part {
            name: String::new(),
            mesh: 0,
            material: None,
            draw_material: None,
            vertices: first_vertex..originals.len(),
            triangles: first_triangle..mesh.triangles.len(),
        });
    }
    let of = |values: &[Vec3]| originals.iter().map(|v| values[*v as usize]).collect();
    mesh.positions = of(&surface.positions);
    mesh.normals = of(&normals);
    mesh.texcoords = vec![Vec2::ZERO; originals.len()];
    mesh.colors = vec![Vec4::ONE; originals.len()];
    (mesh, originals)
}

/// Area-weighted vertex normals.
fn normals(surface: &Surface) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; surface.positions.len()];
    for t in &surface.triangles {
        let [a, b, c] = t.map(|v| surface.positions[v as usize]);
        for v in t {
            sums[*v as usize] += (b - a).cross(c - a);
        }
    }
    sums.into_iter().map(Vec3::normalize_or_zero).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polygonise::tests::{ball, edge_uses};

    fn thin(half: bool, target: usize) -> Surface {
        let options = Options {
            target,
            mirrored: half,
            importance: &|_| 1.0,
        };
        thinned(&ball(half), &options)
    }

    #[test]
    fn a_thinned_ball_is_still_a_ball() {
        let thin = thin(false, 200);
        assert!((198..=200).contains(&thin.triangles.len()));
        assert!(edge_uses(&thin).values().all(|n| *n == 2));
        let fine = ball(false);
        assert!(thin.positions.iter().all(|p| fine.positions.contains(p)));
    }

    #[test]
    fn a_thinned_half_keeps_its_rim_in_the_plane() {
        let thin = thin(true, 120);
        assert!((118..=120).contains(&thin.triangles.len()));
        for ((a, b), uses) in edge_uses(&thin) {
            let in_plane = [a, b].iter().all(|v| thin.positions[*v as usize].x == 0.0);
            assert_eq!(uses, if in_plane { 1 } else { 2 });
        }
    }

    #[test]
    fn a_target_out_of_reach_ends_with_a_closed_surface() {
        let least = thin(false, 0);
        assert!(edge_uses(&least).values().all(|n| *n == 2));
    }
}
