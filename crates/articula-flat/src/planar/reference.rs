//! The reference picture of a planar clip, against which every output is measured.
//!
//! Source: `docs/methods/vector.md` 11. Colours are interpolated linearly between the corners on
//! the screen and averaged in sRGB, as vector players do; hidden surfaces are resolved per sample,
//! so no painting order can be wrong.

use super::clip::PlanarClip;
use super::drawn::draw_frame;
use super::texture::PlanarTexture;
use crate::error::PictureError;
use crate::item_buffer::{ItemBuffer, Supersampling, barycentric};
use crate::picture::{Picture, Rgba};
use glam::Vec2;

/// Renders a frame of a clip over a background; published numbers use 8 x 8 samples per pixel.
///
/// # Errors
/// [`PictureError::LimitExceeded`] if the clip's picture is too large.
pub fn reference(
    clip: &PlanarClip,
    frame: usize,
    samples: Supersampling,
    background: Rgba,
) -> Result<Picture, PictureError> {
    let buffer = drawn(clip, frame, samples)?;
    shaded(clip, frame, &buffer, background)
}

/// Returns [`reference()`] and, row by row, whether a pixel shows the character at least in part.
///
/// # Errors
/// [`PictureError::LimitExceeded`] if the clip's picture is too large.
pub(crate) fn reference_with_mask(
    clip: &PlanarClip,
    frame: usize,
    samples: Supersampling,
    background: Rgba,
) -> Result<(Picture, Vec<bool>), PictureError> {
    let buffer = drawn(clip, frame, samples)?;
    Ok((
        shaded(clip, frame, &buffer, background)?,
        mask(clip, &buffer),
    ))
}

fn drawn(
    clip: &PlanarClip,
    frame: usize,
    samples: Supersampling,
) -> Result<ItemBuffer, PictureError> {
    let mut buffer = ItemBuffer::new(clip.width, clip.height, samples)?;
    draw_frame(clip, frame, &mut buffer);
    Ok(buffer)
}

fn mask(clip: &PlanarClip, buffer: &ItemBuffer) -> Vec<bool> {
    let places = (0..clip.height).flat_map(|y| (0..clip.width).map(move |x| (x, y)));
    places.map(|(x, y)| !buffer.is_blank(x, y)).collect()
}

fn shaded(
    clip: &PlanarClip,
    frame: usize,
    buffer: &ItemBuffer,
    background: Rgba,
) -> Result<Picture, PictureError> {
    let samples = buffer.samples();
    let mut picture = Picture::new(clip.width, clip.height, background)?;
    let n = samples.per_side();
    for y in 0..clip.height {
        for x in 0..clip.width {
            if buffer.is_blank(x, y) {
                continue;
            }
            let mut sum = [0.0f32; 4];
            for j in 0..n {
                for i in 0..n {
                    let color = sample(clip, frame, buffer, (x * n + i, y * n + j));
                    let color = color.unwrap_or(background.map(f32::from));
                    for (k, total) in sum.iter_mut().enumerate() {
                        *total += color[k] * if k < 3 { color[3] } else { 1.0 };
                    }
                }
            }
            let alpha = sum[3].max(1e-6);
            let level = |k: usize| (sum[k] / alpha).round().clamp(0.0, 255.0) as u8;
            let opacity = (sum[3] / samples.per_pixel() as f32).round() as u8;
            picture.set(x, y, [level(0), level(1), level(2), opacity]);
        }
    }
    Ok(picture)
}

fn sample(
    clip: &PlanarClip,
    frame: usize,
    buffer: &ItemBuffer,
    (x, y): (u32, u32),
) -> Option<[f32; 4]> {
    let triangle = buffer.item(x, y)? as usize;
    let corners = clip.corners(frame, triangle);
    let weights = barycentric(&corners, buffer.position(x, y))?.to_array();
    if let Some(texture) = clip.texture.as_ref().filter(|t| t.shows[triangle]) {
        return Some(textured(clip, frame, texture, (triangle, weights)));
    }
    let mut color = [0.0, 0.0, 0.0, 255.0];
    for (weight, vertex) in weights.into_iter().zip(clip.triangles[triangle]) {
        let of_vertex = clip.color(frame, vertex);
        for k in 0..3 {
            color[k] += weight * of_vertex[k];
        }
    }
    Some(color)
}

/// The picture at a point of a triangle, in the light there.
fn textured(
    clip: &PlanarClip,
    frame: usize,
    texture: &PlanarTexture,
    (triangle, weights): (usize, [f32; 3]),
) -> [f32; 4] {
    let (mut place, mut light) = (Vec2::ZERO, 0.0);
    for (weight, vertex) in weights.into_iter().zip(clip.triangles[triangle]) {
        place += weight * texture.places[vertex as usize];
        light += weight * clip.frames[frame].light[vertex as usize];
    }
    let levels = texture.at(place).truncate() * light;
    levels.extend(255.0).to_array()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planar::clip::fixture;

    const WHITE: Rgba = [255; 4];

    #[test]
    fn a_half_covered_pixel_is_the_mean_in_srgb() {
        // The right edge runs through the centres of the pixels of column 10.
        let left = [[0.0, 0.0, 0.5], [0.0, 400.0, 0.5], [10.5, 0.0, 0.5]];
        let clip = fixture::loose(&[(left, [100, 0, 50])], 1);
        let picture = reference(&clip, 0, Supersampling::Eight, WHITE).unwrap();
        assert_eq!(picture.get(2, 2), Some([100, 0, 50, 255]));
        assert_eq!(picture.get(20, 2), Some(WHITE));
        let [r, g, _, a] = picture.get(10, 0).unwrap();
        // The edge leans: 10.5 at the top, 10.47 a pixel below.
        assert!((i32::from(r) - 178).abs() <= 3 && (i32::from(g) - 128).abs() <= 5 && a == 255);
        let clear = reference(&clip, 0, Supersampling::Eight, [0; 4]).unwrap();
        let [r, _, _, a] = clear.get(10, 0).unwrap();
        assert!(r == 100 && (i32::from(a) - 127).abs() <= 5);
    }

    #[test]
    fn a_picture_is_shown_in_the_light() {
        let wide = [[0.0, 0.0, 0.5], [0.0, 40.0, 0.5], [40.0, 0.0, 0.5]];
        let mut clip = fixture::loose(&[(wide, [9; 3])], 1);
        clip.frames[0].light = vec![0.5; 3];
        let pixels = (0..8u8).map(|x| [30 * x, 100, 0, 255]).collect();
        let texture = PlanarTexture {
            picture: std::sync::Arc::new(Picture::from_pixels(8, 1, pixels).unwrap()),
            places: vec![
                Vec2::new(0.5, 0.5),
                Vec2::new(0.5, 0.5),
                Vec2::new(4.5, 0.5),
            ],
            shows: vec![true],
        };
        clip.texture = Some(texture);
        clip.check().unwrap();
        let picture = reference(&clip, 0, Supersampling::Eight, WHITE).unwrap();
        for x in 0..30u32 {
            // Ten pixels of the screen for each of the picture, which rises by 30 levels.
            let expected = 0.5 * 30.0 * (x as f32 + 0.5) / 10.0;
            let [r, g, ..] = picture.get(x, 3).unwrap();
            assert!((f32::from(r) - expected).abs() < 1.01, "{r} at {x}");
            assert_eq!(g, 50);
        }
        clip.texture.as_mut().unwrap().shows.clear();
        assert!(clip.check().is_err());
    }

    #[test]
    fn colours_run_straight_between_the_corners() {
        let wide = [[0.0, 0.0, 0.5], [0.0, 40.0, 0.5], [40.0, 0.0, 0.5]];
        let mut clip = fixture::loose(&[(wide, [200; 3])], 1);
        clip.frames[0].light = vec![0.0, 0.0, 1.0];
        let picture = reference(&clip, 0, Supersampling::Eight, WHITE).unwrap();
        for x in 0..30u32 {
            let expected = 200.0 * (x as f32 + 0.5) / 40.0;
            let [r, ..] = picture.get(x, 3).unwrap();
            assert!((f32::from(r) - expected).abs() < 1.01, "{r} at {x}");
        }
    }
}
