//! How far two pictures are apart.

use crate::error::PictureError;
use crate::picture::{Picture, Rgba};

/// Root mean square difference of red, green and blue, in levels (0 to 255).
///
/// Colours count as laid over white, so what is transparent in both is equal.
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

/// A picture of the differences: white where two pictures agree, the darker the more they
/// differ, `gain` times as strong as the difference itself.
///
/// # Errors
/// [`PictureError::Mismatch`] if the pictures differ in size.
pub fn difference(a: &Picture, b: &Picture, gain: f32) -> Result<Picture, PictureError> {
    same_size(a, b)?;
    let of = |(p, q): (&Rgba, &Rgba)| {
        let channel = |i: usize| {
            let apart = (on_white(*p, i) - on_white(*q, i)).abs();
            (255.0 - apart * gain).clamp(0.0, 255.0).round() as u8
        };
        [channel(0), channel(1), channel(2), 255]
    };
    let pixels = a.pixels().iter().zip(b.pixels()).map(of).collect();
    Picture::from_pixels(a.width(), a.height(), pixels)
}

fn same_size(a: &Picture, b: &Picture) -> Result<(), PictureError> {
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
        let seen = difference(&a, &b, 2.0).unwrap();
        assert_eq!(seen.get(1, 0), Some([195, 255, 175, 255]));
        assert_eq!(seen.get(0, 0), Some([255; 4]));
        assert!(rmse(&a, &Picture::new(2, 1, [0; 4]).unwrap()).is_err());
    }

    #[test]
    fn the_transparent_is_white() {
        let clear = Picture::new(1, 1, [9, 9, 9, 0]).unwrap();
        let white = Picture::new(1, 1, [255; 4]).unwrap();
        assert_eq!(rmse(&clear, &white).unwrap(), 0.0);
    }
}
