//! Smaller pictures by area average, for textures at several sizes.

use crate::error::PictureError;
use crate::picture::{Picture, Rgba, linear_table, srgb_byte};

/// What is averaged when a picture is made smaller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Averaging {
    /// Linear light, weighted by alpha: of pictures that hold colours.
    Light,
    /// The stored numbers, each channel by itself: of pictures that hold normals or other data.
    Numbers,
}

/// Pixels that an output pixel covers along one axis, with the covered share of each.
type Cover = Vec<(usize, f32)>;

impl Picture {
    /// Returns the picture at another size, each pixel the mean of the area that it covers. Sizes
    /// beyond the picture's own are limited to it, and are at least 1.
    ///
    /// O(pixels of the picture).
    ///
    /// # Errors
    /// [`PictureError::Mismatch`] if the picture has no pixels.
    pub fn resized(
        &self,
        (width, height): (u32, u32),
        averaging: Averaging,
    ) -> Result<Self, PictureError> {
        if self.pixels().is_empty() {
            return Err(PictureError::Mismatch {
                at: "picture",
                what: "it has no pixels".to_owned(),
            });
        }
        let (width, height) = (width.clamp(1, self.width()), height.clamp(1, self.height()));
        let columns = covers(self.width(), width);
        let rows = covers(self.height(), height);
        let mut sums = vec![[0.0_f32; 4]; self.width() as usize];
        let mut pixels = Vec::with_capacity(width as usize * height as usize);
        for row in &rows {
            sums.fill([0.0; 4]);
            for (y, share) in row {
                let first = y * self.width() as usize;
                let line = &self.pixels()[first..first + sums.len()];
                for (sum, pixel) in sums.iter_mut().zip(line) {
                    add(sum, numbers(*pixel, averaging), *share);
                }
            }
            pixels.extend(columns.iter().map(|column| {
                let mut mean = [0.0; 4];
                for (x, share) in column {
                    add(&mut mean, sums[*x], *share);
                }
                stored(mean, averaging)
            }));
        }
        Self::from_pixels(width, height, pixels)
    }
}

/// For each of `to` pixels the pixels of `from` that it covers; shares sum to 1.
fn covers(from: u32, to: u32) -> Vec<Cover> {
    let (from, to) = (u64::from(from), u64::from(to));
    // In units of 1 / to of a pixel, so that shares are exact.
    let cover = |i: u64| {
        let (start, end) = (i * from, (i + 1) * from);
        let share = |p: u64| {
            let covered = end.min((p + 1) * to) - start.max(p * to);
            (p as usize, covered as f32 / from as f32)
        };
        (start / to..end.div_ceil(to)).map(share).collect()
    };
    (0..to).map(cover).collect()
}

fn add(sum: &mut [f32; 4], numbers: [f32; 4], share: f32) {
    for (sum, number) in sum.iter_mut().zip(numbers) {
        *sum += share * number;
    }
}

/// A pixel as numbers whose mean counts: premultiplied linear light, or the bytes.
fn numbers(pixel: Rgba, averaging: Averaging) -> [f32; 4] {
    match averaging {
        Averaging::Numbers => pixel.map(f32::from),
        Averaging::Light => {
            let table = linear_table();
            let alpha = f32::from(pixel[3]) / 255.0;
            let [r, g, b] = [0, 1, 2].map(|i: usize| alpha * table[usize::from(pixel[i])]);
            [r, g, b, alpha]
        }
    }
}

fn stored(mean: [f32; 4], averaging: Averaging) -> Rgba {
    match averaging {
        Averaging::Numbers => mean.map(|x| x.round() as u8),
        Averaging::Light => {
            let [r, g, b, alpha] = mean;
            if alpha <= 0.0 {
                return [0; 4];
            }
            let [r, g, b] = [r, g, b].map(|x| srgb_byte(x / alpha));
            [r, g, b, (255.0 * alpha).round() as u8]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn odd_sizes_share_pixels_by_area() {
        // Three pixels into two: the middle one belongs to both, half to each.
        let covers = covers(3, 2);
        let third = 1.0_f32 / 3.0;
        assert_eq!(covers[0], [(0, 2.0 * third), (1, third)]);
        assert_eq!(covers[1], [(1, third), (2, 2.0 * third)]);
        let row = [[0, 30, 60, 255], [90, 30, 0, 255], [255; 4]].to_vec();
        let picture = Picture::from_pixels(3, 1, row).unwrap();
        let half = picture.resized((2, 1), Averaging::Numbers).unwrap();
        assert_eq!(half.pixels(), [[30, 30, 40, 255], [200, 180, 170, 255]]);
    }

    #[test]
    fn light_is_averaged_and_the_transparent_has_no_colour() {
        let of = |pixels: [Rgba; 2]| {
            let picture = Picture::from_pixels(2, 1, pixels.to_vec()).unwrap();
            picture.resized((1, 1), Averaging::Light).unwrap().pixels()[0]
        };
        // Half of the light of white is level 188 in sRGB.
        assert_eq!(of([[0, 0, 0, 255], [255; 4]]), [188, 188, 188, 255]);
        assert_eq!(of([[200, 10, 10, 255], [0, 255, 0, 0]]), [200, 10, 10, 128]);
        assert_eq!(of([[9, 9, 9, 0]; 2]), [0; 4]);
    }

    #[test]
    fn sizes_stay_between_one_and_the_picture() {
        let picture = Picture::new(5, 3, [1, 2, 3, 4]).unwrap();
        let size = |to| {
            let made = picture.resized(to, Averaging::Numbers).unwrap();
            (made.width(), made.height())
        };
        assert_eq!((size((0, 9)), size((4, 2))), ((1, 3), (4, 2)));
        let none = Picture::new(0, 3, [0; 4]).unwrap();
        assert!(none.resized((1, 1), Averaging::Light).is_err());
    }

    proptest! {
        #[test]
        fn even_pictures_stay_even_and_shares_sum_to_one(
            from in 1u32..50, to in 1u32..50, color: [u8; 3],
        ) {
            let to = to.min(from);
            for cover in covers(from, to) {
                let sum: f32 = cover.iter().map(|c| c.1).sum();
                prop_assert!((sum - 1.0).abs() < 1e-5);
            }
            let [r, g, b] = color;
            let picture = Picture::new(from, 2, [r, g, b, 255]).unwrap();
            for averaging in [Averaging::Light, Averaging::Numbers] {
                let small = picture.resized((to, 1), averaging).unwrap();
                for pixel in small.pixels() {
                    for (a, b) in pixel.iter().zip([r, g, b, 255]) {
                        prop_assert!(a.abs_diff(b) <= 1);
                    }
                }
            }
        }
    }
}
