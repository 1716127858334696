//! View pictures: the figure in full quality from several sides, in layers.
//!
//! All layers of a view lie in one picture, the first with the size of the screen area it shows,
//! the others cropped below it. Colours are extended by a few pixels, so that a triangle whose edge
//! lies a little outside the figure finds no hole.

use super::error::PortraitError;
use super::flat_mesh::{FlatMesh, corners_of, part_at};
use super::head::HeadPose;
use super::posing::{Poser, places, project};
use super::source::{PortraitOptions, PortraitSource};
use super::visibility::{Layers, layers};
use crate::picture::{Picture, Rgba};
use crate::projection::Projection;
use crate::render::{Light, RenderOptions, render};
use articula_core::{Mesh, Part, Progress, SkinnedMesh, triangle_distance_squared};
use glam::{Vec2, Vec3, Vec4};

/// Margin around each layer, pixels.
const MARGIN_PX: f32 = 3.0;
/// Distance by which colours are extended, pixels.
const BLEED_PX: usize = 4;

/// Offset of a layer in the view's picture: position in the picture minus position on the screen.
pub(super) type Shift = [i32; 2];

/// One view of the figure.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct View {
    /// Pose of the head.
    pub pose: HeadPose,
    /// Picture with all layers.
    pub picture: Picture,
    /// For each layer, the offset from screen to picture.
    pub shifts: Vec<Shift>,
}

/// Views and the layers in them.
pub(crate) struct Views {
    pub(crate) views: Vec<View>,
    pub(crate) layers: Layers,
}

/// Light of a picture with the head in this pose: the key light turns with the head, so that all
/// views show the same shading.
pub(crate) fn light(pose: &HeadPose) -> Light {
    let still = Light::default();
    // The fill light mirrors the key about the viewer, so it cannot turn with the head: its mean
    // contribution is added to the ambient term instead.
    Light {
        key_direction: pose.rotation() * still.key_direction,
        fill: 0.0,
        ambient: still.ambient + 0.5 * still.fill,
        ..still
    }
}

/// Options with which the figure is rendered.
pub(crate) fn render_options(pose: &HeadPose) -> RenderOptions {
    RenderOptions {
        background: [0; 4],
        samples: crate::item_buffer::Supersampling::Four,
        projection: Projection::Perspective,
        light: light(pose),
        ..RenderOptions::default()
    }
}

/// Renders all views.
pub(crate) fn views(
    source: &PortraitSource<'_>,
    options: &PortraitOptions,
    flat: &FlatMesh,
    progress: &mut Progress<'_>,
) -> Result<Views, PortraitError> {
    let poser = Poser::new(source.mesh, source.rig, &source.head, source.expressions);
    let viewport = source.camera.viewport;
    let size = (
        viewport.width_px.round() as u32,
        viewport.height_px.round() as u32,
    );
    let poses = options.view_poses();
    let mut skinned = Vec::with_capacity(poses.len());
    let mut corners = Vec::with_capacity(poses.len());
    for pose in &poses {
        let whole = poser.skin(*pose, &[]);
        let few = SkinnedMesh {
            positions: flat
                .vertices
                .iter()
                .map(|v| whole.positions[*v as usize])
                .collect(),
            normals: Vec::new(),
        };
        corners.push(project(&few, &source.camera, *pose)?);
        skinned.push(whole);
    }
    let layers = layers(flat, &corners, size)?;
    let owners = owners(source, flat, &poser.skin(HeadPose::default(), &[]));
    let mut views = Vec::with_capacity(poses.len());
    for (v, pose) in poses.iter().enumerate() {
        let mut sheet = Sheet::default();
        let of_view = &layers.of_view[v];
        for layer in 0..layers.count(v) as u8 {
            let Some((low, high)) = bounds(flat, of_view, &corners[v], layer, size) else {
                sheet.skip();
                continue;
            };
            let is_here = |t: usize| layer == 0 || of_view[owners[t] as usize] == layer;
            let mesh = subset(source.mesh, is_here);
            let mut appearance = source.appearance.clone();
            if layers.turned[v] == Some(layer) {
                appearance
                    .materials
                    .iter_mut()
                    .for_each(|m| m.double_sided = true);
            }
            let options = render_options(pose);
            let picture = render(&mesh, &skinned[v], &appearance, &source.camera, &options)?;
            let picture = picture.crop(low.0, low.1, high.0 - low.0, high.1 - low.1);
            sheet.place(bleed(&picture), low);
        }
        views.push(sheet.view(*pose)?);
        progress.step((v + 1) as f32 / poses.len() as f32)?;
    }
    Ok(Views { views, layers })
}

/// Layers of one view, stacked vertically.
#[derive(Default)]
struct Sheet {
    pieces: Vec<(Picture, u32)>,
    shifts: Vec<Shift>,
    height: u32,
}

impl Sheet {
    fn skip(&mut self) {
        self.shifts.push([0, 0]);
    }

    fn place(&mut self, picture: Picture, from: (u32, u32)) {
        let top = self.height as i32 - from.1 as i32;
        self.shifts.push([-(from.0 as i32), top]);
        let height = picture.height();
        self.pieces.push((picture, self.height));
        self.height += height;
    }

    fn view(self, pose: HeadPose) -> Result<View, PortraitError> {
        let width = self.pieces.iter().map(|(p, _)| p.width()).max();
        let mut picture = Picture::new(width.unwrap_or(1).max(1), self.height.max(1), [0; 4])?;
        for (piece, top) in &self.pieces {
            picture.blit(piece, 0, *top as i32);
        }
        Ok(View {
            pose,
            picture,
            shifts: self.shifts,
        })
    }
}

/// Bounding box of the pixels that the triangles of a layer take from a view; `None` if there are
/// none.
fn bounds(
    flat: &FlatMesh,
    layers: &[u8],
    corners: &[Vec4],
    layer: u8,
    size: (u32, u32),
) -> Option<((u32, u32), (u32, u32))> {
    let places = places(corners);
    let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
    let here = flat
        .triangles
        .iter()
        .zip(layers)
        .filter(|(_, l)| **l == layer);
    for corner in here.flat_map(|(t, _)| corners_of(&places, *t)) {
        low = low.min(corner);
        high = high.max(corner);
    }
    let most = Vec2::new(size.0 as f32, size.1 as f32);
    let low = (low - MARGIN_PX).floor().clamp(Vec2::ZERO, most);
    let high = (high + MARGIN_PX).ceil().clamp(Vec2::ZERO, most);
    let is_empty = high.cmple(low).any() || !low.is_finite() || !high.is_finite();
    (!is_empty).then_some(((low.x as u32, low.y as u32), (high.x as u32, high.y as u32)))
}

/// Triangle of the 2D mesh for each triangle of the full mesh: the nearest one, preferably with the
/// same facing and material.
fn owners(source: &PortraitSource<'_>, flat: &FlatMesh, rest: &SkinnedMesh) -> Vec<u32> {
    let corners = |t: [u32; 3]| t.map(|v| rest.positions[v as usize]);
    let coarse: Vec<[Vec3; 3]> = flat
        .triangles
        .iter()
        .map(|t| corners(t.map(|v| flat.vertices[v as usize])))
        .collect();
    let normal = |[a, b, c]: &[Vec3; 3]| (*b - *a).cross(*c - *a).normalize_or_zero();
    let normals: Vec<Vec3> = coarse.iter().map(normal).collect();
    let material = |v: u32| part_at(source.mesh, v).and_then(|p| source.mesh.parts[p].material);
    let owner = |t: &[u32; 3]| {
        let triangle = corners(*t);
        let middle = (triangle[0] + triangle[1] + triangle[2]) / 3.0;
        let facing = normal(&triangle);
        let own = material(t[0]);
        let far = |c: usize| {
            let turned = facing.dot(normals[c]) < 0.0 || flat.materials[c] != own;
            let far = triangle_distance_squared(middle, coarse[c]);
            // A triangle that faces away or has another material counts as twice as far, plus a
            // centimetre.
            if turned { far * 4.0 + 1e-4 } else { far }
        };
        let nearest = (0..coarse.len()).min_by(|a, b| far(*a).total_cmp(&far(*b)));
        nearest.map_or(0, |c| c as u32)
    };
    source.mesh.triangles.iter().map(owner).collect()
}

/// The mesh with some of its triangles, for rendering with the same skinned vertices.
fn subset(full: &Mesh, keep: impl Fn(usize) -> bool) -> Mesh {
    let mut mesh = Mesh {
        positions: full.positions.clone(),
        normals: full.normals.clone(),
        texcoords: full.texcoords.clone(),
        colors: full.colors.clone(),
        ..Mesh::default()
    };
    for part in &full.parts {
        let first = mesh.triangles.len();
        let kept = part.triangles.clone().filter(|t| keep(*t));
        mesh.triangles.extend(kept.map(|t| full.triangles[t]));
        mesh.parts.push(Part {
            triangles: first..mesh.triangles.len(),
            ..part.clone()
        });
    }
    mesh
}

/// Makes every pixel opaque that shows anything, and extends colours into empty pixels.
fn bleed(picture: &Picture) -> Picture {
    let mut out = picture.clone();
    // A partly covered pixel takes the colour that covers it; empty pixels take their neighbours'.
    for pixel in out.pixels_mut() {
        pixel[3] = if pixel[3] > 0 { 255 } else { 0 };
    }
    for _ in 0..BLEED_PX {
        let before = out.clone();
        for y in 0..out.height() {
            for x in 0..out.width() {
                if before.get(x, y).is_some_and(|p| p[3] == 0)
                    && let Some(color) = mean_around(&before, x, y)
                {
                    out.set(x, y, color);
                }
            }
        }
    }
    out
}

/// Mean colour of the opaque pixels around one.
fn mean_around(picture: &Picture, x: u32, y: u32) -> Option<Rgba> {
    let mut sum = [0u32; 3];
    let mut count = 0;
    for (dx, dy) in [
        (0, 1),
        (1, 0),
        (2, 1),
        (1, 2),
        (0, 0),
        (2, 0),
        (0, 2),
        (2, 2),
    ] {
        let at = ((x + dx).checked_sub(1), (y + dy).checked_sub(1));
        if let (Some(x), Some(y)) = at
            && let Some(pixel) = picture.get(x, y)
            && pixel[3] > 0
        {
            sum.iter_mut()
                .zip(pixel)
                .for_each(|(s, p)| *s += u32::from(p));
            count += 1;
        }
    }
    let mean = |s: u32| ((s + count / 2) / count) as u8;
    (count > 0).then(|| [mean(sum[0]), mean(sum[1]), mean(sum[2]), 255])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_run_into_the_empty_and_no_farther() {
        let mut picture = Picture::new(9, 1, [0; 4]).unwrap();
        picture.set(0, 0, [10, 20, 30, 128]);
        let found = bleed(&picture);
        assert_eq!(found.get(0, 0), Some([10, 20, 30, 255]));
        assert_eq!(found.get(4, 0), Some([10, 20, 30, 255]));
        assert_eq!(found.get(5, 0), Some([0; 4]));
    }
}
