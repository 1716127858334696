//! The morph targets of a face, one picture each.

use crate::contact_sheet::{ContactSheet, SheetCell, SheetRow};
use articula_core::{Mesh, PosedMesh, Rig, Viewport};
use articula_flat::{Appearance, Bounds, PictureError, RenderOptions, orbit_view, render};

/// Width and height of a tile, pixels.
const TILE: (u32, u32) = (220, 250);
/// Vertical field of view, radians.
const FOV_Y_RADIANS: f32 = 0.25;
const COLUMNS: usize = 7;

/// Draws a figure at rest inside a box with each of some sets of morph weights, and first without
/// any. `facing_radians` is the direction in which the figure faces at rest, from +Z to its left.
///
/// # Errors
/// [`PictureError`] if the page would be too large.
///
/// # Panics
/// If the mesh belongs to another rig, or a set has another number of weights than the mesh.
pub fn shape_sheet(
    (rig, mesh): (&Rig, &Mesh),
    look: &Appearance,
    (bounds, facing_radians): (&Bounds, f32),
    shapes: &[(String, Vec<f32>)],
    title: &str,
) -> Result<articula_flat::Picture, PictureError> {
    let viewport = Viewport {
        width_px: TILE.0 as f32,
        height_px: TILE.1 as f32,
        fov_y_radians: FOV_Y_RADIANS,
    };
    let camera = orbit_view(bounds, facing_radians + 0.25, 0.0, viewport);
    let mut posed = PosedMesh::new(rig, mesh);
    posed.pose(rig.rest_pose());
    let rest = ("at rest".to_owned(), vec![0.0; mesh.morph_weights.len()]);
    let mut cells = Vec::with_capacity(shapes.len() + 1);
    for (name, weights) in std::iter::once(&rest).chain(shapes) {
        let skinned = posed.skinned(weights);
        let picture = render(mesh, &skinned, look, &camera, &RenderOptions::default())?;
        cells.push(SheetCell::of(picture, name));
    }
    let rows = cells.chunks(COLUMNS).map(|cells| SheetRow {
        label: String::new(),
        cells: cells.to_vec(),
    });
    ContactSheet {
        title: title.to_owned(),
        columns: vec![String::new(); COLUMNS],
        rows: rows.collect(),
        ..ContactSheet::default()
    }
    .draw()
}
