//! Differences between two pictures: RMSE and SSIM.

use crate::error::PictureError;
use crate::picture::{Picture, Rgba};

/// Returns the root mean square difference of red, green and blue, in levels (0 to 255).
///
/// Colours are composited over white, so pixels that are transparent in both are equal.
///
/// # Errors
/// [`PictureError::Mismatch`] if the pictures differ in size.
pub fn rmse(a: &Picture, b: &Picture) -> Result<f64, PictureError> {
    same_size(a, b)?;
    let squares = |(p, q): (&Rgba, &Rgba)| {
        let channel = |i: usize| f64::from(on_white(*p, i)) - f64::from(on_white(*q, i));
        (0..3).map(|i| channel(i) * channel(i)).sum::<f64>()
    };
    let sum: f64 = a.pixels().iter().zip(b.pixels()).map(squares).sum();
    Ok((sum / (3 * a.pixels().len().max(1)) as f64).sqrt())
}

/// Returns [`rmse`] over the pixels of a mask, row by row; 0 if the mask is empty.
///
/// # Errors
/// [`PictureError::Mismatch`] if pictures or mask differ in size.
pub fn masked_rmse(a: &Picture, b: &Picture, mask: &[bool]) -> Result<f64, PictureError> {
    let pairs = masked(a, b, mask)?;
    let squares = |(p, q): (Rgba, Rgba)| {
        let channel = |i: usize| f64::from(on_white(p, i)) - f64::from(on_white(q, i));
        (0..3).map(|i| channel(i) * channel(i)).sum::<f64>()
    };
    let count = mask.iter().filter(|m| **m).count();
    Ok((pairs.map(squares).sum::<f64>() / (3 * count.max(1)) as f64).sqrt())
}

/// Fraction (0 to 1) of a mask's pixels in which a channel differs by more than `levels`.
///
/// # Errors
/// [`PictureError::Mismatch`] if pictures or mask differ in size.
pub(crate) fn share_off(
    a: &Picture,
    b: &Picture,
    mask: &[bool],
    levels: f32,
) -> Result<f64, PictureError> {
    let is_off =
        |(p, q): &(Rgba, Rgba)| (0..3).any(|i| (on_white(*p, i) - on_white(*q, i)).abs() > levels);
    let off = masked(a, b, mask)?.filter(is_off).count();
    Ok(off as f64 / mask.iter().filter(|m| **m).count().max(1) as f64)
}

/// Side of the window of [`ssim`], pixels.
const WINDOW: usize = 11;

/// Returns the mean structural similarity of the luma of two pictures: 1 if they are equal.
///
/// Source: Z. Wang, A. C. Bovik, H. R. Sheikh, E. P. Simoncelli, "Image quality assessment: from
/// error visibility to structural similarity", IEEE Transactions on Image Processing 13(4), 2004:
/// Gaussian window of 11 x 11 pixels with sigma 1.5, K1 = 0.01, K2 = 0.03, L = 255, the mean over
/// all windows inside the picture. The luma is that of Rec. ITU-R BT.601 over white, not rounded to
/// whole levels.
///
/// O(pixels).
///
/// # Errors
/// [`PictureError::Mismatch`] if the pictures differ in size, or a side is shorter than 11 pixels.
pub fn ssim(a: &Picture, b: &Picture) -> Result<f64, PictureError> {
    same_size(a, b)?;
    let (width, height) = (a.width() as usize, a.height() as usize);
    if width < WINDOW || height < WINDOW {
        return Err(PictureError::Mismatch {
            at: "pictures",
            what: format!(
                "{width} x {height} pixels are smaller than the window of {WINDOW} x {WINDOW}"
            ),
        });
    }
    let (p, q) = (luma(a), luma(b));
    let product = |u: &[f64], v: &[f64]| u.iter().zip(v).map(|(x, y)| x * y).collect::<Vec<_>>();
    let mean = |values: &[f64]| windowed(values, width);
    let (mean_p, mean_q) = (mean(&p), mean(&q));
    let (pp, qq, pq) = (
        mean(&product(&p, &p)),
        mean(&product(&q, &q)),
        mean(&product(&p, &q)),
    );
    let (c1, c2) = ((0.01 * 255.0f64).powi(2), (0.03 * 255.0f64).powi(2));
    let of = |i: usize| {
        let (m, n) = (mean_p[i], mean_q[i]);
        let spread = pp[i] - m * m + qq[i] - n * n;
        let shared = pq[i] - m * n;
        (2.0 * m * n + c1) * (2.0 * shared + c2) / ((m * m + n * n + c1) * (spread + c2))
    };
    Ok((0..mean_p.len()).map(of).sum::<f64>() / mean_p.len() as f64)
}

fn luma(picture: &Picture) -> Vec<f64> {
    let weights = [0.299, 0.587, 0.114];
    let of = |p: &Rgba| {
        (0..3)
            .map(|i| weights[i] * f64::from(on_white(*p, i)))
            .sum()
    };
    picture.pixels().iter().map(of).collect()
}

/// Gaussian means of all windows inside the picture, filtered along rows, then columns.
fn windowed(values: &[f64], width: usize) -> Vec<f64> {
    let middle = (WINDOW / 2) as f64;
    let weight = |i: usize| (-(i as f64 - middle).powi(2) / (2.0 * 1.5 * 1.5)).exp();
    let sum: f64 = (0..WINDOW).map(weight).sum();
    let weights: [f64; WINDOW] = std::array::from_fn(|i| weight(i) / sum);
    let dot = |part: &[f64]| weights.iter().zip(part).map(|(w, v)| w * v).sum::<f64>();
    let rows: Vec<f64> = values
        .chunks_exact(width)
        .flat_map(|row| row.windows(WINDOW).map(dot))
        .collect();
    let inner = width + 1 - WINDOW;
    let column = |at: usize| (0..WINDOW).map(|i| weights[i] * rows[at + i * inner]).sum();
    (0..rows.len() + inner - WINDOW * inner)
        .map(column)
        .collect()
}

fn masked<'a>(
    a: &'a Picture,
    b: &'a Picture,
    mask: &'a [bool],
) -> Result<impl Iterator<Item = (Rgba, Rgba)> + 'a, PictureError> {
    same_size(a, b)?;
    if mask.len() != a.pixels().len() {
        return Err(PictureError::Mismatch {
            at: "mask",
            what: format!(
                "{} pixels, the pictures have {}",
                mask.len(),
                a.pixels().len()
            ),
        });
    }
    let pairs = a.pixels().iter().copied().zip(b.pixels().iter().copied());
    Ok(pairs.zip(mask).filter(|(_, m)| **m).map(|(pair, _)| pair))
}

/// Checks that two pictures have the same size.
///
/// # Errors
/// [`PictureError::Mismatch`] if they differ.
pub(crate) fn same_size(a: &Picture, b: &Picture) -> Result<(), PictureError> {
    if (a.width(), a.height()) == (b.width(), b.height()) {
        return Ok(());
    }
    let size = |p: &Picture| format!("{} x {}", p.width(), p.height());
    Err(PictureError::Mismatch {
        at: "pictures",
        what: format!("one is {}, the other {}", size(a), size(b)),
    })
}

fn on_white(pixel: Rgba, channel: usize) -> f32 {
    let alpha = f32::from(pixel[3]) / 255.0;
    255.0 + (f32::from(pixel[channel]) - 255.0) * alpha
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_pixel_off_by_hand() {
        let a = Picture::new(2, 2, [100, 100, 100, 255]).unwrap();
        let mut b = a.clone();
        b.set(1, 0, [130, 100, 60, 255]);
        // (30^2 + 40^2) over twelve values.
        let expected = (2500.0f64 / 12.0).sqrt();
        assert!((rmse(&a, &b).unwrap() - expected).abs() < 1e-9);
        assert_eq!(rmse(&a, &a).unwrap(), 0.0);
        assert!(rmse(&a, &Picture::new(2, 1, [0; 4]).unwrap()).is_err());
    }

    #[test]
    fn the_transparent_is_white() {
        let clear = Picture::new(1, 1, [9, 9, 9, 0]).unwrap();
        let white = Picture::new(1, 1, [255; 4]).unwrap();
        assert_eq!(rmse(&clear, &white).unwrap(), 0.0);
    }

    #[test]
    fn a_mask_leaves_the_rest_out() {
        let a = Picture::new(2, 2, [100, 100, 100, 255]).unwrap();
        let mut b = a.clone();
        b.set(1, 0, [130, 100, 60, 255]);
        b.set(0, 1, [116, 100, 100, 255]);
        let top = [true, true, false, false];
        let expected = (2500.0f64 / 6.0).sqrt();
        assert!((masked_rmse(&a, &b, &top).unwrap() - expected).abs() < 1e-9);
        assert_eq!(share_off(&a, &b, &top, 16.0).unwrap(), 0.5);
        // Sixteen levels are not more than sixteen.
        assert_eq!(share_off(&a, &b, &[true; 4], 16.0).unwrap(), 0.25);
        assert_eq!(share_off(&a, &b, &[true; 4], 15.0).unwrap(), 0.5);
        assert_eq!(masked_rmse(&a, &b, &[false; 4]).unwrap(), 0.0);
        assert!(share_off(&a, &b, &[true; 3], 16.0).is_err());
    }

    #[test]
    fn ssim_agrees_with_the_paper_and_with_another_hand() {
        let flat = |level: u8| Picture::new(11, 11, [level, level, level, 255]).unwrap();
        // Without structure the luminance term is alone: (2 m n + C1) / (m^2 + n^2 + C1).
        let expected =
            (2.0 * 100.0 * 120.0 + 6.5025) / (100.0f64.powi(2) + 120.0f64.powi(2) + 6.5025);
        let found = ssim(&flat(100), &flat(120)).unwrap();
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        assert!(ssim(&flat(1), &Picture::new(10, 11, [0; 4]).unwrap()).is_err());
        assert!(
            ssim(
                &Picture::new(10, 11, [0; 4]).unwrap(),
                &Picture::new(10, 11, [0; 4]).unwrap()
            )
            .is_err()
        );

        let pattern = |s: u32| {
            let mut picture = Picture::new(20, 17, [0, 0, 0, 255]).unwrap();
            for y in 0..17 {
                for x in 0..20 {
                    let level = |v: u32| (v % 256) as u8;
                    let color = [
                        level(x * 7 + y * 3 + s * 11),
                        level(x * x + 5 * y),
                        level(x * y + s * 40),
                        255,
                    ];
                    picture.set(x, y, color);
                }
            }
            picture
        };
        // The formula written out in numpy: every window of 11 x 11 times the outer product of
        // the Gaussian, mean of 7 x 10 windows.
        let found = ssim(&pattern(0), &pattern(1)).unwrap();
        assert!((found - 0.996_809_760_627_115_3).abs() < 1e-6, "{found}");
        assert!((ssim(&pattern(0), &pattern(0)).unwrap() - 1.0).abs() < 1e-12);
    }
}
