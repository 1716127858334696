//! Packs what the triangles of a clip show of their textures into one picture.
//!
//! Source: `docs/methods/vector.md` 8.3. Triangles whose vertex colours show the texture as well keep
//! them. The others form charts, connected pieces of texture space, each scaled to the pixels that
//! it covers on the screen ([`charts`]); their rectangles are packed ([`packed`]) and filled with
//! the colours of the materials ([`painted`]).

mod charts;
mod packed;
mod painted;

use super::bake::Painter;
use super::clip::PlanarClip;
use super::drawn::Drawn;
use super::error::PlanarError;
use super::texture::PlanarTexture;
use charts::{Charts, ShownTriangle};
use glam::{Vec2, Vec3};
use std::sync::Arc;

/// Root mean square difference between texture and vertex colours, in levels, up to which a triangle
/// shows its vertex colours.
const PLAIN_RMS_LEVELS: f32 = 5.0;
/// Subdivisions of each side of a triangle at whose centres colours are compared.
const PARTS: usize = 6;

/// The picture of a clip whose vertices are these vertices of the subject's mesh; `None` if no
/// triangle needs one.
///
/// O(frames x samples covered + pixels of the picture).
///
/// # Errors
/// Errors of the clip; [`PlanarError::NothingVisible`].
pub(super) fn atlas(
    clip: &PlanarClip,
    painter: &Painter<'_>,
    sources: &[u32],
) -> Result<Option<PlanarTexture>, PlanarError> {
    let shown = shown_triangles(clip, painter, sources)?;
    let charts = Charts::new(clip, &shown);
    let Some(places) = packed::packed(&charts) else {
        return Ok(None);
    };
    let picture = painted::painted(&shown, &places, &charts.of_triangle, painter)?;
    let mut texture = PlanarTexture {
        picture: Arc::new(picture),
        places: vec![Vec2::ZERO; clip.albedo.len()],
        shows: vec![false; clip.triangles.len()],
    };
    for (shown, chart) in shown.iter().zip(&charts.of_triangle) {
        texture.shows[shown.triangle] = true;
        for (vertex, texel) in clip.triangles[shown.triangle].iter().zip(shown.texels) {
            texture.places[*vertex as usize] = places.place(*chart, texel);
        }
    }
    Ok(Some(texture))
}

/// Triangles that are drawn in some frame and whose vertex colours do not show their texture.
fn shown_triangles(
    clip: &PlanarClip,
    painter: &Painter<'_>,
    sources: &[u32],
) -> Result<Vec<ShownTriangle>, PlanarError> {
    let is_plain = |t: &[u32; 3]| {
        let corners = t.map(|v| sources[v as usize]);
        painter.appearance_of(&corners).detail().is_none()
    };
    if clip.triangles.iter().all(is_plain) {
        return Ok(Vec::new());
    }
    let drawn = Drawn::seen(clip)?;
    let mut all = Vec::new();
    for t in drawn.ever().into_iter().map(|t| t as usize) {
        let corners = clip.triangles[t].map(|v| sources[v as usize]);
        let Some(detail) = painter.appearance_of(&corners).detail() else {
            continue;
        };
        let size = detail.size();
        let texels = painter.texcoords(&corners).map(|at| at * size);
        let frames = (0..clip.frames.len()).filter(|f| drawn.get(*f, t));
        let area = |f| area(&clip.places(f, t)).abs();
        let shown = ShownTriangle {
            triangle: t,
            corners,
            texels,
            texels_per_unit: size,
            pixels: frames.map(area).fold(0.0, f32::max),
            surface: clip.surface[t],
        };
        if shown.is_usable() && rms_levels(clip, painter, &shown) > PLAIN_RMS_LEVELS {
            all.push(shown);
        }
    }
    Ok(all)
}

/// Half of the cross product of two sides.
fn area([a, b, c]: &[Vec2; 3]) -> f32 {
    (*b - *a).perp_dot(*c - *a) / 2.0
}

/// Root mean square difference between the vertex colours of a triangle and its texture.
fn rms_levels(clip: &PlanarClip, painter: &Painter<'_>, shown: &ShownTriangle) -> f32 {
    let colors = clip.triangles[shown.triangle].map(|v| Vec3::from(clip.albedo[v as usize]));
    let level = painter.level_for(&shown.corners, (PARTS * PARTS) as f32);
    let mut sum = 0.0;
    for weights in centres() {
        let (texture, _) = painter.color(&shown.corners, weights, level);
        let plain = colors[0] * weights.x + colors[1] * weights.y + colors[2] * weights.z;
        sum += texture.distance_squared(plain) / 3.0;
    }
    (sum / (PARTS * PARTS) as f32).sqrt()
}

/// Barycentric weights of the centroids of the equal triangles that a triangle is divided into.
fn centres() -> impl Iterator<Item = Vec3> {
    let cell = |row: usize, column: usize, third: f32| {
        let (u, v) = (row as f32 + third, column as f32 + third);
        let (u, v) = (u / PARTS as f32, v / PARTS as f32);
        Vec3::new(1.0 - u - v, u, v)
    };
    (0..PARTS).flat_map(move |row| {
        let upright = (0..PARTS - row).map(move |column| cell(row, column, 1.0 / 3.0));
        let inverted = (0..PARTS - row - 1).map(move |column| cell(row, column, 2.0 / 3.0));
        upright.chain(inverted)
    })
}
