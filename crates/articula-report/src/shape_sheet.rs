//! The shapes of a face, one picture each.

use crate::contact_sheet::{ContactSheet, SheetCell, SheetRow};
use articula::core::{LocalPose, Mesh, PosedMesh, Rig, Viewport};
use articula::flat::{Appearance, Bounds, PictureError, RenderOptions, orbit_view, render};

/// Width and height of a tile, pixels.
const TILE: (u32, u32) = (220, 250);
/// Vertical field of view, radians.
const FOV_Y_RADIANS: f32 = 0.25;
const COLUMNS: usize = 7;

/// A face as one picture shows it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FaceShape {
    /// What is written below it.
    pub(crate) label: String,
    /// Pose of the rig.
    pub(crate) pose: LocalPose,
    /// Weights of the morph targets of the mesh.
    pub(crate) weights: Vec<f32>,
}

/// Draws a figure inside a box in each of some shapes. `facing_radians` is the direction in which the
/// figure faces at rest, from +Z to its left.
pub(crate) fn shape_sheet(
    (rig, mesh): (&Rig, &Mesh),
    look: &Appearance,
    (bounds, facing_radians): (&Bounds, f32),
    shapes: &[FaceShape],
    title: &str,
) -> Result<articula::flat::Picture, PictureError> {
    let viewport = Viewport {
        width_px: TILE.0 as f32,
        height_px: TILE.1 as f32,
        fov_y_radians: FOV_Y_RADIANS,
    };
    let camera = orbit_view(bounds, facing_radians + 0.25, 0.0, viewport);
    let mut posed = PosedMesh::new(rig, mesh);
    let mut cells = Vec::with_capacity(shapes.len());
    for shape in shapes {
        let skinned = posed.pose(&shape.pose).skinned(&shape.weights);
        let picture = render(mesh, &skinned, look, &camera, &RenderOptions::default())?;
        cells.push(SheetCell::of(picture, &shape.label));
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
