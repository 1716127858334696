//! A face from the front and from its left, and its mouth, with its feature points.

use crate::contact_sheet::{ContactSheet, SheetCell, SheetRow};
use crate::paint::{TextStyle, draw_disc, draw_ring, draw_text};
use articula::core::{Mesh, PosedMesh, Rig, Viewport};
use articula::flat::{
    Appearance, Bounds, Picture, PictureError, RenderOptions, Rgba, orbit_view, render,
};
use glam::{Quat, Vec2, Vec3};

/// Width and height of a tile, pixels.
const TILE: (u32, u32) = (860, 860);
/// Vertical field of view, radians: a long lens.
const FOV_Y_RADIANS: f32 = 0.25;
/// Blend of the picture towards white, 0 to 1.
const FADE: f32 = 0.35;
/// Group of the feature points of the outer lips, in the names of points.
const OUTER_LIPS: &str = "8.";
/// Margin around the lips relative to their size.
const AROUND_MOUTH: f32 = 0.15;
const HALO: Rgba = [255, 255, 255, 220];
const INK: Rgba = [20, 22, 28, 255];

/// A point to be drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceMark {
    /// Its name, such as `2.10`.
    pub name: String,
    /// Where it is, in model space, metres.
    pub place: Vec3,
    /// How sure it is, 0 to 1: colours run from red to green.
    pub confidence: f32,
    /// Whether it is inside the head: such points are rings.
    pub inside: bool,
}

/// Draws the face of a figure at rest, with marks, from the front and from its left; and, enlarged, its
/// mouth, if any mark is of its lips.
/// `facing_radians` is the direction in which the figure faces at rest, from +Z to its left.
///
/// # Errors
/// [`PictureError`] if the page would be too large.
///
/// # Panics
/// If the mesh belongs to another rig.
pub fn face_sheet(
    (rig, mesh): (&Rig, &Mesh),
    look: &Appearance,
    facing_radians: f32,
    marks: &[FaceMark],
    (title, notes): (&str, Vec<String>),
) -> Result<Picture, PictureError> {
    let mut posed = PosedMesh::new(rig, mesh);
    posed.pose(rig.rest_pose());
    let still = vec![0.0; mesh.morph_weights.len()];
    let skinned = posed.skinned(&still);
    let to_head = Quat::from_rotation_y(-facing_radians);
    let places = marks.iter().map(|m| m.place);
    let bounds = Bounds::around(places.map(|p| (p, p))).unwrap_or(Bounds {
        low: Vec3::ZERO,
        high: Vec3::ONE,
    });
    let middle = to_head * bounds.middle();
    let depth_of_head = (bounds.high - bounds.low).length();
    let mut cells = Vec::new();
    let mut views = vec![
        ("front", bounds, 0.0, false),
        ("from its left", bounds, 1.3, true),
    ];
    views.extend(mouth(marks).map(|lips| ("mouth", lips, 0.0, false)));
    for (_, bounds, azimuth, from_left) in &views {
        let viewport = Viewport {
            width_px: TILE.0 as f32,
            height_px: TILE.1 as f32,
            fov_y_radians: FOV_Y_RADIANS,
        };
        let camera = orbit_view(bounds, facing_radians + azimuth, 0.0, viewport);
        let options = RenderOptions::default();
        let mut picture = render(mesh, &skinned, look, &camera, &options)?;
        for y in 0..TILE.1 as i32 {
            for x in 0..TILE.0 as i32 {
                picture.blend(x, y, [255; 4], FADE);
            }
        }
        for mark in marks {
            // The far side of the head hides its points.
            let seen = to_head * mark.place - middle;
            if seen.x < -1e-4 && *from_left || seen.z < -0.25 * depth_of_head && !from_left {
                continue;
            }
            let (at, depth) = camera.project(mark.place);
            if depth > 0.0 {
                draw_mark(&mut picture, at, mark);
            }
        }
        cells.push(SheetCell::of(picture, ""));
    }
    ContactSheet {
        title: title.to_owned(),
        notes,
        columns: views.iter().map(|v| v.0.to_owned()).collect(),
        rows: vec![SheetRow {
            label: String::new(),
            cells,
        }],
        ..ContactSheet::default()
    }
    .draw()
}

/// The box around the lips.
fn mouth(marks: &[FaceMark]) -> Option<Bounds> {
    let lips = marks.iter().filter(|m| m.name.starts_with(OUTER_LIPS));
    let lips = Bounds::around(lips.map(|m| (m.place, m.place)))?;
    let around = Vec3::splat(AROUND_MOUTH * (lips.high - lips.low).length());
    Some(Bounds {
        low: lips.low - around,
        high: lips.high + around,
    })
}

fn draw_mark(picture: &mut Picture, at: Vec2, mark: &FaceMark) {
    let unsure = 1.0 - mark.confidence.clamp(0.0, 1.0);
    let color = [
        (40.0 + 190.0 * (2.0 * unsure).min(1.0)) as u8,
        (150.0 - 110.0 * (2.0 * unsure).min(1.0)) as u8,
        60,
        255,
    ];
    draw_disc(picture, at, 5.0, HALO);
    if mark.inside {
        draw_ring(picture, at, 4.0, 1.6, color);
    } else {
        draw_disc(picture, at, 3.6, color);
    }
    let (x, y) = (at.x as i32 + 6, at.y as i32 - 7);
    for (dx, dy) in [(-1, 0), (1, 0), (0, -1), (0, 1)] {
        draw_text(picture, x + dx, y + dy, &mark.name, TextStyle::Body, HALO);
    }
    draw_text(picture, x, y, &mark.name, TextStyle::Body, INK);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mouth_is_framed_by_its_outer_lips_alone() {
        let mark = |name: &str, x: f32| FaceMark {
            name: name.into(),
            place: Vec3::new(x, 0.0, 0.0),
            confidence: 1.0,
            inside: false,
        };
        let marks = [
            mark("2.1", 9.0),
            mark("8.3", 1.0),
            mark("8.4", -1.0),
            mark("3.8", 5.0),
        ];
        let lips = mouth(&marks).unwrap();
        assert_eq!((lips.low.x, lips.high.x), (-1.3, 1.3));
        assert_eq!(mouth(&marks[..1]), None);
    }
}
