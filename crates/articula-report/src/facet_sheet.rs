//! A mesh at several choices of levels, with every triangle visible.
//!
//! Triangles are flat, in the colour of their region of the body, lighter and darker by turns, so
//! that their number and size show in every part.

use crate::artist::Artist;
use crate::contact_sheet::{ContactSheet, SheetCell, SheetRow};
use articula::core::{LocalPose, Mesh, Part, Region, Rig};
use articula::flat::{Appearance, Picture, PictureError};
use glam::{Vec2, Vec3, Vec4};

/// Width and height of a tile, pixels.
const TILE: (u32, u32) = (420, 560);

/// Linear colours of regions, in turn.
const COLORS: [Vec3; 6] = [
    Vec3::new(0.80, 0.42, 0.20),
    Vec3::new(0.18, 0.42, 0.75),
    Vec3::new(0.30, 0.62, 0.28),
    Vec3::new(0.62, 0.30, 0.62),
    Vec3::new(0.70, 0.62, 0.18),
    Vec3::new(0.25, 0.60, 0.62),
];

/// Triangles of one choice of levels.
#[derive(Debug, Clone, Copy)]
pub struct FacetRow<'a> {
    /// Label of the row.
    pub label: &'a str,
    /// Triangles with the index of their region, over the vertices of the mesh.
    pub triangles: &'a [(u16, [u32; 3])],
}

/// Where levels are used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UsedAt {
    /// Distance from the camera, metres.
    pub distance_m: f32,
    /// Pixels of a metre at that distance.
    pub pixels_per_metre: f32,
}

/// Draws each choice of triangles in a pose: the whole figure, its face and a hand; and the figure as
/// large as it is on the screen at the distance where the levels are used, if there is one. Morph targets
/// stay at rest. `facing_radians` is the direction in which the figure faces at rest, from +Z to
/// its left.
///
/// # Errors
/// [`PictureError`] if the page would be too large.
///
/// # Panics
/// If the mesh or the pose belongs to another rig, or a triangle to another mesh.
pub fn facet_sheet(
    (rig, mesh): (&Rig, &Mesh),
    (pose, facing_radians): (&LocalPose, f32),
    (rows, used_at): (&[FacetRow<'_>], Option<UsedAt>),
    (title, notes): (&str, Vec<String>),
) -> Result<Picture, PictureError> {
    let mut drawn = Vec::with_capacity(rows.len());
    for row in rows {
        let facets = facets(mesh, row.triangles);
        let still = facets.morph_weights.clone();
        let look = Appearance::default();
        let mut artist = Artist::new(rig, &facets, look, facing_radians, TILE);
        artist.frame_pose(pose, &still);
        let mut cells = vec![SheetCell::of(artist.figure(pose, still.clone())?, "")];
        let true_size = used_at.map(|at| artist.at_scale(pose, &still, at.pixels_per_metre));
        let true_size = true_size.transpose()?;
        for (region, azimuth) in [(Region::Face, 0.4), (Region::Hands, 1.2)] {
            artist.azimuth = azimuth;
            artist.frame_region(pose, region);
            cells.push(SheetCell::of(artist.figure(pose, still.clone())?, ""));
        }
        cells.extend(true_size.map(|picture| SheetCell::of(picture, "")));
        drawn.push(SheetRow {
            label: row.label.to_owned(),
            cells,
        });
    }
    let mut columns = ["figure", "face", "hand"].map(str::to_owned).to_vec();
    columns.extend(used_at.map(|at| format!("true size at {:.1} m", at.distance_m)));
    let sheet = ContactSheet {
        title: title.to_owned(),
        notes,
        columns,
        rows: drawn,
        explains_joints: false,
    };
    sheet.draw()
}

/// A mesh of separate flat triangles over the vertices of another, coloured by region.
fn facets(mesh: &Mesh, triangles: &[(u16, [u32; 3])]) -> Mesh {
    let corners = || triangles.iter().flat_map(|(_, t)| t.map(|v| v as usize));
    let each = mesh.influences;
    let flat = |t: [u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        (b - a).cross(c - a).normalize_or(Vec3::Z)
    };
    let count = 3 * triangles.len();
    let color = |(i, (region, _)): (usize, &(u16, [u32; 3]))| {
        // A multiplicative hash, so that neighbours in the list differ.
        let share = ((i as u32).wrapping_mul(0x9E37_79B9) >> 24) as f32 / 255.0;
        let base = COLORS[usize::from(*region) % COLORS.len()];
        (base * (0.55 + 0.6 * share)).min(Vec3::ONE).extend(1.0)
    };
    let colors: Vec<Vec4> = triangles.iter().enumerate().map(color).collect();
    Mesh {
        positions: corners().map(|v| mesh.positions[v]).collect(),
        normals: triangles.iter().flat_map(|(_, t)| [flat(*t); 3]).collect(),
        texcoords: vec![Vec2::ZERO; count],
        colors: colors.iter().flat_map(|c| [*c; 3]).collect(),
        influences: each,
        binding_indices: corners()
            .flat_map(|v| {
                mesh.binding_indices[v * each..(v + 1) * each]
                    .iter()
                    .copied()
            })
            .collect(),
        weights: corners()
            .flat_map(|v| mesh.weights[v * each..(v + 1) * each].iter().copied())
            .collect(),
        bindings: mesh.bindings.clone(),
        triangles: (0..triangles.len() as u32)
            .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
            .collect(),
        parts: vec![Part {
            name: String::new(),
            mesh: 0,
            material: None,
            draw_material: None,
            vertices: 0..count,
            triangles: 0..triangles.len(),
        }],
        morphs: Vec::new(),
        morph_weights: mesh.morph_weights.clone(),
        morph_slots: mesh.morph_slots.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn facets_are_flat_separate_and_coloured_by_region() {
        let mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ONE],
            normals: vec![Vec3::Z; 4],
            influences: 1,
            binding_indices: vec![0, 1, 2, 3],
            weights: vec![1.0; 4],
            ..Mesh::default()
        };
        let made = facets(&mesh, &[(0, [0, 1, 2]), (1, [2, 1, 3])]);
        assert_eq!(made.triangles, [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(made.binding_indices, [0, 1, 2, 2, 1, 3]);
        assert_eq!(made.normals[..3], [Vec3::Z; 3]);
        assert_eq!(made.positions[5], Vec3::ONE);
        let [first, second] = [made.colors[0], made.colors[3]];
        assert!(first.x > first.z && second.z > second.x);
    }
}
