//! The first frame as a picture, for places where scripts do not run.

use super::clip::PlayerClip;
use crate::error::PictureError;
use crate::item_buffer::Supersampling;
use crate::picture::{Picture, Rgba};
use crate::planar::reference::reference;

/// Quality of the colours; coverage is kept exactly.
const QUALITY: u8 = 60;
/// Few levels of coverage, which take a third of the bytes otherwise.
const SAMPLES: Supersampling = Supersampling::Two;
const BLACK: Rgba = [0, 0, 0, 255];
const WHITE: Rgba = [255; 4];

/// The first frame as a WebP of the size of the clip, with a transparent background.
///
/// # Errors
/// [`PictureError::LimitExceeded`] if the clip's picture is too large.
pub(super) fn first_frame(clip: &PlayerClip) -> Result<Vec<u8>, PictureError> {
    let painted = clip.painted(0.0);
    let over = |background| reference(&painted, 0, SAMPLES, background);
    let (dark, light) = (over(BLACK)?, over(WHITE)?);
    let each = dark.pixels().iter().zip(light.pixels());
    let mut pixels: Vec<Rgba> = each.map(|(dark, light)| cut_out(*dark, *light)).collect();
    // Blocks of a lossy picture mix neighbours: the background takes a colour of the figure.
    let mean = mean_of_opaque(&pixels);
    for [r, g, b, _] in pixels.iter_mut().filter(|p| p[3] == 0) {
        [*r, *g, *b] = mean;
    }
    Picture::from_pixels(dark.width(), dark.height(), pixels)?.to_webp(QUALITY)
}

/// The colour and coverage of a pixel that was drawn over black and over white.
fn cut_out(dark: Rgba, light: Rgba) -> Rgba {
    let gap = (0..3)
        .map(|k| i32::from(light[k]) - i32::from(dark[k]))
        .min();
    let alpha = 255 - gap.unwrap_or(255).clamp(0, 255);
    if alpha == 0 {
        return [0; 4];
    }
    let whole = |level: u8| ((i32::from(level) * 255 + alpha / 2) / alpha).min(255) as u8;
    [whole(dark[0]), whole(dark[1]), whole(dark[2]), alpha as u8]
}

fn mean_of_opaque(pixels: &[Rgba]) -> [u8; 3] {
    let opaque = || pixels.iter().filter(|p| p[3] == 255);
    let count = opaque().count().max(1) as u64;
    [0, 1, 2].map(|k| (opaque().map(|p| u64::from(p[k])).sum::<u64>() / count) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coverage_is_what_black_and_white_leave() {
        assert_eq!(
            cut_out([10, 200, 30, 255], [10, 200, 30, 255]),
            [10, 200, 30, 255]
        );
        assert_eq!(cut_out(BLACK, WHITE), [0; 4]);
        // Half of (200, 100, 0) over both.
        assert_eq!(
            cut_out([100, 50, 0, 255], [227, 177, 127, 255]),
            [199, 100, 0, 128]
        );
    }
}
