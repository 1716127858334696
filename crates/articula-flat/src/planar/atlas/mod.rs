//! Packs what the triangles of a clip show of their textures into one picture.
//!
//! Source: `docs/methods/vector.md` 8.3. Triangles whose vertex colours show the texture as well keep
//! them. The others form charts, connected pieces of texture space, each scaled to the pixels that
//! it covers on the screen ([`charts`]); their rectangles are packed ([`packed`]) and filled with
//! the colours of the materials ([`painted`]).

mod charts;
mod packed;
mod painted;

use super::bake::{BakeOptions, Painter, still_parts};
use super::clip::PlanarClip;
use super::drawn::Drawn;
use super::error::PlanarError;
use super::subject::PlanarSubject;
use super::texture::PlanarTexture;
use charts::{Charts, ShownTriangle};
use glam::{Vec2, Vec3};
use std::sync::Arc;

/// Root mean square difference between texture and vertex colours, in levels, up to which a triangle
/// shows its vertex colours.
const PLAIN_RMS_LEVELS: f32 = 5.0;
/// Difference at one of the places that are compared from which a triangle shows its texture, in
/// levels: a small mark on a large triangle has little weight in the mean.
const MARK_LEVELS: f32 = 48.0;
/// Least share of the area of all drawn triangles in which a picture is worth its bytes and its script.
const LEAST_SHARE: f32 = 0.005;
/// Least and greatest subdivisions of each side of a triangle at whose centres colours are compared.
const PARTS: (usize, usize) = (6, 32);
/// Pixels of the screen along each side of a part of a large triangle.
const PART_PX: f32 = 2.0;

/// Adds to a clip that [`bake`](super::bake()) or [`bake_shapes`](super::bake_shapes) made of a subject a picture of what its vertex
/// colours do not show of the textures ([`PlanarClip::texture`]).
///
/// O(frames x samples covered).
///
/// # Errors
/// [`PlanarError::Mismatch`] for the clip of another subject; errors of the clip;
/// [`PlanarError::NothingVisible`].
pub fn textured(
    mut clip: PlanarClip,
    subject: &PlanarSubject<'_>,
    options: &BakeOptions,
) -> Result<PlanarClip, PlanarError> {
    let (same, sources) = still_parts(subject, options)?;
    if same.triangles != clip.triangles {
        let what = "the clip was not made of this subject".to_owned();
        return Err(PlanarError::Mismatch { at: "clip", what });
    }
    let vertices: Vec<u32> = sources.iter().map(|source| source.vertex).collect();
    clip.texture = atlas(&clip, &Painter::new(subject), &vertices)?;
    Ok(clip)
}

/// The picture of a clip whose vertices are these vertices of the subject's mesh; `None` if no
/// triangle needs one.
///
/// O(frames x samples covered + pixels of the picture).
///
/// # Errors
/// Errors of the clip; [`PlanarError::NothingVisible`].
fn atlas(
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
    let pixels = |t: usize| {
        let frames = (0..clip.frames.len()).filter(|f| drawn.get(*f, t));
        let area = |f| area(&clip.places(f, t)).abs();
        frames.map(area).fold(0.0, f32::max)
    };
    let (mut all, mut figure) = (Vec::new(), 0.0);
    for t in drawn.ever().into_iter().map(|t| t as usize) {
        let corners = clip.triangles[t].map(|v| sources[v as usize]);
        let pixels = pixels(t);
        figure += pixels;
        let Some(detail) = painter.appearance_of(&corners).detail() else {
            continue;
        };
        let size = detail.size();
        let texels = painter.texcoords(&corners).map(|at| at * size);
        let shown = ShownTriangle {
            triangle: t,
            corners,
            texels,
            texels_per_unit: size,
            pixels,
            surface: clip.surface[t],
        };
        if shown.is_usable() && has_detail(clip, painter, &shown) {
            all.push(shown);
        }
    }
    let shown: f32 = all.iter().map(|shown: &ShownTriangle| shown.pixels).sum();
    if shown < LEAST_SHARE * figure {
        all.clear();
    }
    Ok(all)
}

/// Half of the cross product of two sides.
fn area([a, b, c]: &[Vec2; 3]) -> f32 {
    (*b - *a).perp_dot(*c - *a) / 2.0
}

/// Whether the vertex colours of a triangle do not show its texture.
fn has_detail(clip: &PlanarClip, painter: &Painter<'_>, shown: &ShownTriangle) -> bool {
    let colors = clip.triangles[shown.triangle].map(|v| Vec3::from(clip.albedo[v as usize]));
    let parts = (shown.pixels.sqrt() / PART_PX) as usize;
    let parts = parts.clamp(PARTS.0, PARTS.1);
    let count = (parts * parts) as f32;
    let level = painter.level_for(&shown.corners, count);
    let (mut sum, mut most) = (0.0, 0.0f32);
    for weights in centres(parts) {
        let (texture, _) = painter.color(&shown.corners, weights, level);
        let plain = colors[0] * weights.x + colors[1] * weights.y + colors[2] * weights.z;
        let square = texture.distance_squared(plain) / 3.0;
        sum += square;
        most = most.max(square);
    }
    // Of a small triangle, parts are smaller than pixels.
    let is_marked = shown.pixels > count && most.sqrt() > MARK_LEVELS;
    (sum / count).sqrt() > PLAIN_RMS_LEVELS || is_marked
}

/// Barycentric weights of the centroids of the equal triangles that a triangle is divided into.
fn centres(parts: usize) -> impl Iterator<Item = Vec3> {
    let cell = move |row: usize, column: usize, third: f32| {
        let (u, v) = (row as f32 + third, column as f32 + third);
        let (u, v) = (u / parts as f32, v / parts as f32);
        Vec3::new(1.0 - u - v, u, v)
    };
    (0..parts).flat_map(move |row| {
        let upright = (0..parts - row).map(move |column| cell(row, column, 1.0 / 3.0));
        let inverted = (0..parts - row - 1).map(move |column| cell(row, column, 2.0 / 3.0));
        upright.chain(inverted)
    })
}

#[cfg(test)]
mod tests {
    use super::super::bake::bake;
    use super::super::fixture::{Figure, figure};
    use super::super::reference::reference;
    use super::super::source_picture::SourcePainter;
    use super::*;
    use crate::appearance::Appearance;
    use crate::item_buffer::Supersampling;
    use crate::picture::Picture;
    use articula_core::source::{Image, Material};
    use glam::Vec4;

    const WHITE: [u8; 4] = [255; 4];

    /// The human under a picture of squares, which repeats.
    fn checked(level: impl Fn(u32, u32) -> u8) -> Figure {
        let mut figure = figure();
        let mesh = Arc::make_mut(&mut figure.asset.mesh);
        mesh.colors.fill(Vec4::ONE);
        mesh.parts
            .iter_mut()
            .for_each(|part| part.material = Some(0));
        for (at, place) in mesh.texcoords.iter_mut().zip(&mesh.positions) {
            *at = Vec2::new(place.x, place.y) * 3.0;
        }
        let level = &level;
        let pixels = (0..64).flat_map(|y| (0..64).map(move |x| [level(x, y), 60, 90, 255]));
        let picture = Picture::from_pixels(64, 64, pixels.collect()).unwrap();
        let image = Image {
            bytes: picture.to_png().unwrap(),
            ..Image::default()
        };
        let material = Material {
            base_color_image: Some(0),
            ..Material::default()
        };
        figure.appearance = Appearance::new(&[material], &[image]).0;
        figure
    }

    #[test]
    fn the_picture_shows_what_vertex_colours_do_not() {
        let squares = |x: u32, y: u32| {
            if (x / 16 + y / 16).is_multiple_of(2) {
                0
            } else {
                220
            }
        };
        let figure = checked(squares);
        let (subject, options) = (figure.subject(), &figure.options);
        let plain = bake(&subject, &[0.0], options).unwrap();
        let clip = textured(plain.clone(), &subject, options).unwrap();
        clip.check().unwrap();
        let mut painter = SourcePainter::new(&subject, options).unwrap();
        painter.pose(0.0);
        let truth = painter.textured(WHITE).unwrap();
        let off = |clip: &PlanarClip| {
            let shown = reference(clip, 0, Supersampling::Four, WHITE).unwrap();
            crate::compare::rmse(&truth, &shown).unwrap()
        };
        let (with, without) = (off(&clip), off(&plain));
        assert!(with < 0.4 * without, "{with} {without}");
        assert!(clip.textured_share() > 0.3);
        // The clip of other triangles is refused.
        let mut other = plain;
        other.triangles.pop();
        assert!(textured(other, &subject, options).is_err());
    }

    #[test]
    fn one_colour_needs_no_picture() {
        let figure = checked(|_, _| 80);
        let (subject, options) = (figure.subject(), &figure.options);
        let plain = bake(&subject, &[0.0], options).unwrap();
        let clip = textured(plain.clone(), &subject, options).unwrap();
        assert_eq!(clip, plain);
        assert_eq!(clip.textured_share(), 0.0);
    }
}
