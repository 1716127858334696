//! Whether two textures look the same, texel for texel.
//!
//! Colours: the difference of `local_difference`, CIELAB after a blur as the eye has it, where a texel is a
//! pixel of the screen; as near as a texture is sharp. Alpha is not looked at. Numbers, such as normals, by
//! their stored bytes.

use crate::compare::same_size;
use crate::error::PictureError;
use crate::local_difference::difference_map;
use crate::picture::Picture;

/// Standard deviation of the blur, in texels.
const SIGMA_TEXELS: f32 = 1.0;

/// Difference of two pictures in colour. In units of CIELAB: of two fields side by side, 2.3 is just seen.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ColorDifference {
    /// Mean of all texels.
    pub mean: f64,
    /// What 999 of 1000 texels do not exceed.
    pub most: f64,
    /// The largest.
    pub largest: f64,
}

/// Compares the colours of two pictures, as if they were opaque.
///
/// O(pixels log pixels).
///
/// # Errors
/// [`PictureError::Mismatch`] if the pictures differ in size.
pub fn color_difference(a: &Picture, b: &Picture) -> Result<ColorDifference, PictureError> {
    same_size(a, b)?;
    if a.pixels().is_empty() {
        return Ok(ColorDifference::default());
    }
    let mut map = difference_map(&opaque(a), &opaque(b), SIGMA_TEXELS);
    map.sort_by(f32::total_cmp);
    let at = |i: usize| map.get(i).copied().map_or(0.0, f64::from);
    let last = map.len().saturating_sub(1);
    Ok(ColorDifference {
        mean: map.iter().copied().map(f64::from).sum::<f64>() / map.len().max(1) as f64,
        most: at(last - map.len() / 1000),
        largest: at(last),
    })
}

fn opaque(picture: &Picture) -> Picture {
    let mut picture = picture.clone();
    picture.pixels_mut().iter_mut().for_each(|p| p[3] = 255);
    picture
}

/// Difference of two pictures in their stored bytes, in levels of 0 to 255.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct NumberDifference {
    /// Root mean square of all channels.
    pub rms: f64,
    /// The largest of any channel.
    pub largest: u8,
}

/// Compares the bytes of two pictures, alpha too.
///
/// # Errors
/// [`PictureError::Mismatch`] if the pictures differ in size.
pub fn number_difference(a: &Picture, b: &Picture) -> Result<NumberDifference, PictureError> {
    same_size(a, b)?;
    let (a, b) = (a.pixels().as_flattened(), b.pixels().as_flattened());
    let (mut squares, mut largest) = (0.0, 0);
    for off in a.iter().zip(b).map(|(p, q)| p.abs_diff(*q)) {
        squares += f64::from(off).powi(2);
        largest = largest.max(off);
    }
    Ok(NumberDifference {
        rms: (squares / a.len().max(1) as f64).sqrt(),
        largest,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_those_of_cielab_and_alpha_does_not_count() {
        let white = Picture::new(8, 5, [255; 4]).unwrap();
        let black = Picture::new(8, 5, [0, 0, 0, 7]).unwrap();
        let found = color_difference(&white, &black).unwrap();
        for value in [found.mean, found.most, found.largest] {
            assert!((value - 100.0).abs() < 0.05, "{found:?}");
        }
        let clear = Picture::new(8, 5, [255, 255, 255, 0]).unwrap();
        let none = color_difference(&white, &clear).unwrap();
        assert_eq!(none, ColorDifference::default());
        assert!(color_difference(&white, &Picture::new(5, 8, [0; 4]).unwrap()).is_err());
    }

    #[test]
    fn one_texel_in_a_thousand_is_the_largest_alone() {
        let plain = Picture::new(100, 100, [128, 128, 128, 255]).unwrap();
        let mut spot = plain.clone();
        spot.set(50, 50, [255; 4]);
        let found = color_difference(&plain, &spot).unwrap();
        assert!(
            found.largest > 10.0 && found.most < 0.3 * found.largest,
            "{found:?}"
        );
    }

    #[test]
    fn numbers_by_hand() {
        let a = Picture::from_pixels(2, 1, vec![[10, 20, 30, 255], [0; 4]]).unwrap();
        let b = Picture::from_pixels(2, 1, vec![[14, 20, 30, 255], [0; 4]]).unwrap();
        let found = number_difference(&a, &b).unwrap();
        // One of eight bytes is off by four.
        assert_eq!((found.rms, found.largest), (2.0_f64.sqrt(), 4));
    }
}
