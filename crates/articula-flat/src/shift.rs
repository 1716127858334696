//! A difference in colour as a shift in pixels: how far the same picture would have to move to differ
//! as much.
//!
//! Definition and example: `docs/metrics.md`. An error of motion or shape is a distance on the screen,
//! so this makes a difference in colour comparable with it.

use crate::compare::{masked_rmse, same_size};
use crate::error::PictureError;
use crate::picture::Picture;

/// Least difference that a shift by a pixel counts as, in levels: of a picture nearly without detail,
/// no shift would explain a difference.
const LEAST_LEVELS: f64 = 1.0;

/// Difference of two pictures of one view.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PictureShift {
    /// Root mean square difference over the figure, in levels of 0 to 255.
    pub rms_levels: f64,
    /// The same between the first picture and itself shifted by one pixel, but at least 1.
    pub levels_per_px: f64,
    /// The first divided by the second, in pixels.
    pub shift_px: f64,
}

/// Compares a picture of a figure with another one of the same view. The figure is what is opaque in
/// the first, which has a transparent background. Edges against the background do not count: shifts
/// are compared between pixels of the figure alone.
///
/// O(pixels).
///
/// # Errors
/// [`PictureError::Mismatch`] if the pictures differ in size.
pub fn equal_shift(original: &Picture, other: &Picture) -> Result<PictureShift, PictureError> {
    same_size(original, other)?;
    let mask: Vec<bool> = original.pixels().iter().map(|p| p[3] == 255).collect();
    let rms_levels = masked_rmse(original, other, &mask)?;
    let width = original.width() as usize;
    let (mut sum, mut count) = (0.0_f64, 0_usize);
    for at in (0..mask.len()).filter(|at| mask[*at]) {
        let right = (at + 1 < mask.len() && (at + 1) % width > 0).then_some(at + 1);
        let below = (at + width < mask.len()).then_some(at + width);
        for next in [right, below].into_iter().flatten().filter(|n| mask[*n]) {
            let (a, b) = (original.pixels()[at], original.pixels()[next]);
            for (a, b) in a[..3].iter().zip(&b[..3]) {
                sum += f64::from(a.abs_diff(*b)).powi(2);
            }
            count += 3;
        }
    }
    let levels_per_px = (sum / count.max(1) as f64).sqrt().max(LEAST_LEVELS);
    Ok(PictureShift {
        rms_levels,
        levels_per_px,
        shift_px: rms_levels / levels_per_px,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ramp of `slope` levels a pixel to the right, from `start`.
    fn ramp(start: u8, slope: u8) -> Picture {
        let pixels = (0..64u8).map(|i| {
            let level = start + slope * (i % 8);
            [level, level, level, 255]
        });
        Picture::from_pixels(8, 8, pixels.collect()).unwrap()
    }

    #[test]
    fn a_shifted_ramp_by_hand() {
        // Of 56 + 56 pairs of neighbours, those to the right differ by 10: the root of half of 100.
        let found = equal_shift(&ramp(0, 10), &ramp(20, 10)).unwrap();
        assert_eq!(found.rms_levels, 20.0);
        assert!((found.levels_per_px - 50.0_f64.sqrt()).abs() < 1e-12);
        assert!((found.shift_px - 20.0 / 50.0_f64.sqrt()).abs() < 1e-12);
        let none = equal_shift(&ramp(3, 10), &ramp(3, 10)).unwrap();
        assert_eq!((none.rms_levels, none.shift_px), (0.0, 0.0));
    }

    #[test]
    fn a_flat_picture_counts_as_one_level_a_pixel_and_the_background_not_at_all() {
        let flat = Picture::new(8, 8, [50, 50, 50, 255]).unwrap();
        let found = equal_shift(&flat, &Picture::new(8, 8, [52, 52, 52, 255]).unwrap()).unwrap();
        assert_eq!(found.shift_px, 2.0);
        let mut framed = Picture::new(12, 12, [0; 4]).unwrap();
        framed.blit(&ramp(0, 10), 2, 2);
        let mut other = Picture::new(12, 12, [255; 4]).unwrap();
        other.blit(&ramp(20, 10), 2, 2);
        let inside = equal_shift(&ramp(0, 10), &ramp(20, 10)).unwrap();
        assert_eq!(equal_shift(&framed, &other).unwrap(), inside);
        let none = Picture::new(4, 4, [0; 4]).unwrap();
        assert_eq!(equal_shift(&none, &none).unwrap().shift_px, 0.0);
        assert!(equal_shift(&none, &flat).is_err());
    }
}
