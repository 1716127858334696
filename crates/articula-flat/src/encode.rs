//! Encoders of small picture files: PNG, JPEG and WebP.
//!
//! The same picture gives the same bytes.

use crate::error::PictureError;
use crate::item_buffer::MAX_SIDE;
use crate::picture::{Picture, Rgba};
use jpeg_encoder::{ColorType, Encoder, SamplingFactor};
use std::collections::BTreeMap;
use webp_rust::{
    ImageBuffer, LosslessEncodingConfig, LossyEncodingConfig, encode_lossless_with_config,
    encode_lossy_with_config,
};

/// Effort of the WebP encoders; the next levels need five times the time for a twentieth of the bytes.
const WEBP_METHOD: u8 = 4;
/// Longest side of a WebP file.
const MAX_WEBP_SIDE: u32 = MAX_SIDE - 1;
/// Most colours of a palette.
const MAX_PALETTE: usize = 256;

impl Picture {
    /// Encodes the picture as a smaller PNG, more slowly: without alpha where every pixel is opaque, and
    /// with a palette of at most 256 colours if that needs fewer bytes.
    ///
    /// # Errors
    /// As [`Self::to_png`].
    pub fn to_small_png(&self) -> Result<Vec<u8>, PictureError> {
        let plain = match self.is_opaque() {
            true => self.encoded(png::ColorType::Rgb, png::Compression::High, &self.rgb())?,
            false => {
                let data = self.pixels().as_flattened();
                self.encoded(png::ColorType::Rgba, png::Compression::High, data)?
            }
        };
        let indexed = self.to_indexed_png()?;
        Ok(match indexed.filter(|bytes| bytes.len() < plain.len()) {
            Some(indexed) => indexed,
            None => plain,
        })
    }

    /// Encodes the picture as a progressive JPEG of a quality of 1 to 100, with all of its colour samples.
    /// Alpha is left out.
    ///
    /// # Errors
    /// [`PictureError::Mismatch`] if the picture has no pixels.
    pub fn to_jpeg(&self, quality: u8) -> Result<Vec<u8>, PictureError> {
        let refuse = |what: String| PictureError::Mismatch {
            at: "picture",
            what,
        };
        let side = |side: u32| u16::try_from(side).map_err(|e| refuse(e.to_string()));
        let (width, height) = (side(self.width())?, side(self.height())?);
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, quality.clamp(1, 100));
        encoder.set_progressive(true);
        encoder.set_optimized_huffman_tables(true);
        // Halved colour bleeds over the borders of islands by more than is invisible.
        encoder.set_sampling_factor(SamplingFactor::F_1_1);
        let encoded = encoder.encode(&self.rgb(), width, height, ColorType::Rgb);
        encoded.map_err(|e| refuse(e.to_string()))?;
        Ok(bytes)
    }

    /// Encodes the picture as a lossy WebP of a quality of 0 to 100. Alpha is kept exactly.
    ///
    /// # Errors
    /// [`PictureError::Mismatch`] if the picture has no pixels or a side is longer than 16,383 pixels.
    pub fn to_webp(&self, quality: u8) -> Result<Vec<u8>, PictureError> {
        let config = LossyEncodingConfig {
            quality: f32::from(quality.min(100)),
            method: WEBP_METHOD,
            // The colours of transparent pixels count where a material ignores alpha.
            exact: true,
            ..LossyEncodingConfig::default()
        };
        let encoded = encode_lossy_with_config(&self.webp_buffer()?, &config, None);
        encoded.map_err(|e| refused_webp(&e.to_string()))
    }

    /// Encodes the picture as a WebP that holds the same pixels.
    ///
    /// # Errors
    /// As [`Self::to_webp`].
    pub fn to_lossless_webp(&self) -> Result<Vec<u8>, PictureError> {
        let config = LosslessEncodingConfig {
            z_level: WEBP_METHOD,
        };
        let encoded = encode_lossless_with_config(&self.webp_buffer()?, &config, None);
        encoded.map_err(|e| refused_webp(&e.to_string()))
    }

    /// Whether every pixel is opaque.
    pub fn is_opaque(&self) -> bool {
        self.pixels().iter().all(|p| p[3] == 255)
    }

    fn rgb(&self) -> Vec<u8> {
        let pixels = self.pixels().iter();
        pixels.flat_map(|[r, g, b, _]| [*r, *g, *b]).collect()
    }

    fn webp_buffer(&self) -> Result<ImageBuffer, PictureError> {
        let (width, height) = (self.width(), self.height());
        if width.min(height) == 0 || width.max(height) > MAX_WEBP_SIDE {
            let what = format!("WebP has sides of 1 to {MAX_WEBP_SIDE}, not {width} x {height}");
            return Err(refused_webp(&what));
        }
        Ok(ImageBuffer {
            width: width as usize,
            height: height as usize,
            rgba: self.pixels().as_flattened().to_vec(),
        })
    }

    /// Encodes the picture as a PNG with a palette; `None` if it has more than 256 colours.
    fn to_indexed_png(&self) -> Result<Option<Vec<u8>>, PictureError> {
        let mut colors: BTreeMap<Rgba, u8> = BTreeMap::new();
        for pixel in self.pixels() {
            if !colors.contains_key(pixel) {
                if colors.len() == MAX_PALETTE {
                    return Ok(None);
                }
                colors.insert(*pixel, 0);
            }
        }
        // Colours that are not opaque come first, so that the list of opacities is short.
        let mut order: Vec<Rgba> = colors.keys().copied().collect();
        order.sort_by_key(|p| (p[3] == 255, *p));
        for (i, color) in (0..=255).zip(&order) {
            colors.insert(*color, i);
        }
        let depth = match order.len() {
            0..=2 => png::BitDepth::One,
            3..=4 => png::BitDepth::Two,
            5..=16 => png::BitDepth::Four,
            _ => png::BitDepth::Eight,
        };
        let bits = depth as usize;
        let indices: Vec<u8> = self.pixels().iter().map(|p| colors[p]).collect();
        let packed = |chunk: &[u8]| {
            let fill = |byte: u8, (k, index): (usize, &u8)| byte | index << (8 - bits * (k + 1));
            chunk.iter().enumerate().fold(0, fill)
        };
        let rows = indices.chunks(self.width().max(1) as usize);
        let data: Vec<u8> = rows
            .flat_map(|row| row.chunks(8 / bits).map(packed))
            .collect();
        let palette = order.iter().flat_map(|p| [p[0], p[1], p[2]]).collect();
        let clear: Vec<u8> = order
            .iter()
            .map(|p| p[3])
            .take_while(|a| *a < 255)
            .collect();
        let refuse = |e: png::EncodingError| PictureError::Mismatch {
            at: "picture",
            what: e.to_string(),
        };
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width(), self.height());
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(depth);
        encoder.set_palette::<Vec<u8>>(palette);
        if !clear.is_empty() {
            encoder.set_trns(clear);
        }
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_compression(png::Compression::High);
        // Neighbours in a palette are not neighbours in colour.
        encoder.set_filter(png::Filter::NoFilter);
        let mut writer = encoder.write_header().map_err(refuse)?;
        writer.write_image_data(&data).map_err(refuse)?;
        writer.finish().map_err(refuse)?;
        Ok(Some(bytes))
    }
}

fn refused_webp(what: &str) -> PictureError {
    PictureError::Mismatch {
        at: "picture",
        what: what.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::rmse;
    use crate::texture_difference::color_difference;

    /// A smooth picture, with alpha that varies or none.
    fn smooth(width: u32, height: u32, is_opaque: bool) -> Picture {
        let pixel = |i: u32| {
            let (x, y) = (i % width, i / width);
            let wave = |a: u32, b: u32| (128 + (a * x + b * y) % 64) as u8;
            let alpha = if is_opaque { 255 } else { (x * 40 + y) as u8 };
            [wave(1, 0), wave(0, 1), wave(1, 1), alpha]
        };
        Picture::from_pixels(width, height, (0..width * height).map(pixel).collect()).unwrap()
    }

    #[test]
    fn lossless_files_hold_the_same_pixels_at_odd_sizes() {
        for (width, height) in [(1, 1), (3, 5), (1, 7), (17, 16), (40, 40)] {
            for is_opaque in [true, false] {
                let picture = smooth(width, height, is_opaque);
                for bytes in [
                    picture.to_small_png().unwrap(),
                    picture.to_lossless_webp().unwrap(),
                ] {
                    assert_eq!(Picture::decode(&bytes).unwrap(), picture);
                }
            }
        }
    }

    #[test]
    fn palettes_of_each_depth_hold_the_same_pixels() {
        for count in [1u32, 2, 3, 4, 5, 16, 17, 256] {
            let color = |i: u32| {
                let k = (i * 7 + i / 19) % count;
                [k as u8, 255 - k as u8, 9, if k == 1 { 128 } else { 255 }]
            };
            let picture = Picture::from_pixels(19, 40, (0..760).map(color).collect()).unwrap();
            let bytes = picture.to_indexed_png().unwrap().unwrap();
            assert_eq!(Picture::decode(&bytes).unwrap(), picture, "{count}");
        }
        let many = smooth(40, 40, false);
        assert_eq!(many.to_indexed_png().unwrap(), None);
        let flat = Picture::new(64, 64, [1, 2, 3, 255]).unwrap();
        // The signature, a header, sRGB, a palette of one colour, data and the end.
        let small = flat.to_small_png().unwrap();
        assert!(small[25] == 3 && small.len() < 110, "{}", small.len());
    }

    #[test]
    fn lossy_files_decode_to_nearly_the_same() {
        let picture = smooth(48, 40, true);
        let jpeg = Picture::decode(&picture.to_jpeg(95).unwrap()).unwrap();
        let webp = Picture::decode(&picture.to_webp(95).unwrap()).unwrap();
        for found in [&jpeg, &webp] {
            assert_eq!((found.width(), found.height()), (48, 40));
            assert!(rmse(&picture, found).unwrap() < 6.0);
        }
        let exact = color_difference(&picture, &jpeg).unwrap();
        assert!(exact.mean < 1.0 && exact.largest < 10.0, "{exact:?}");
        let coarse = picture.to_jpeg(30).unwrap();
        assert!(coarse.len() < picture.to_jpeg(95).unwrap().len());
        assert!(coarse == picture.to_jpeg(30).unwrap());
    }

    #[test]
    fn lossy_webp_keeps_alpha_to_the_bit_and_odd_sizes() {
        for (width, height) in [(1, 1), (3, 5), (33, 18)] {
            let picture = smooth(width, height, false);
            let found = Picture::decode(&picture.to_webp(60).unwrap()).unwrap();
            assert_eq!((found.width(), found.height()), (width, height));
            for (a, b) in picture.pixels().iter().zip(found.pixels()) {
                assert_eq!(a[3], b[3]);
            }
            let jpeg = Picture::decode(&picture.to_jpeg(60).unwrap()).unwrap();
            assert!((jpeg.width(), jpeg.height()) == (width, height) && jpeg.is_opaque());
        }
    }

    #[test]
    fn pictures_without_pixels_are_refused() {
        let none = Picture::new(0, 3, [0; 4]).unwrap();
        assert!(none.to_small_png().is_err() && none.to_jpeg(90).is_err());
        assert!(none.to_webp(90).is_err() && none.to_lossless_webp().is_err());
    }
}
