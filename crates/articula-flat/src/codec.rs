//! PNG encoder and decoder, decoders of JPEG and WebP. Small files: `encode`.

use crate::error::PictureError;
use crate::item_buffer::MAX_SIDE;
use crate::picture::{Picture, Rgba};
use image_webp::WebPDecoder;
use std::io::Cursor;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// Maximum memory of a decoder for one picture, bytes.
const MAX_DECODED_BYTES: usize = 1 << 29;

impl Picture {
    /// Encodes the picture as PNG. The same picture gives the same bytes.
    ///
    /// # Errors
    /// [`PictureError::Mismatch`] if the picture has no pixels, which PNG cannot represent.
    pub fn to_png(&self) -> Result<Vec<u8>, PictureError> {
        self.encoded(
            png::ColorType::Rgba,
            png::Compression::Balanced,
            self.pixels().as_flattened(),
        )
    }

    pub(crate) fn encoded(
        &self,
        color: png::ColorType,
        compression: png::Compression,
        data: &[u8],
    ) -> Result<Vec<u8>, PictureError> {
        let refuse = |e: png::EncodingError| PictureError::Mismatch {
            at: "picture",
            what: e.to_string(),
        };
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width(), self.height());
        encoder.set_color(color);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_compression(compression);
        let mut writer = encoder.write_header().map_err(refuse)?;
        writer.write_image_data(data).map_err(refuse)?;
        writer.finish().map_err(refuse)?;
        Ok(bytes)
    }

    /// Decodes a PNG, JPEG or WebP file, recognised by its first bytes; of an animated one, the first
    /// picture.
    ///
    /// # Errors
    /// [`PictureError`] if the file is malformed, of another format, or too large.
    pub fn decode(bytes: &[u8]) -> Result<Self, PictureError> {
        if bytes.starts_with(b"\x89PNG") {
            return decode_png(bytes);
        }
        if bytes.starts_with(&[0xff, 0xd8]) {
            return decode_jpeg(bytes);
        }
        if is_webp(bytes) {
            return decode_webp(bytes);
        }
        let head: Vec<String> = bytes.iter().take(4).map(|b| format!("{b:02x}")).collect();
        Err(PictureError::Unsupported {
            what: format!("a picture that begins with bytes [{}]", head.join(" ")),
            mend: "use PNG, JPEG or WebP".to_owned(),
        })
    }

    /// Whether bytes begin as a file of a format that [`Self::decode`] reads.
    pub fn is_known_format(bytes: &[u8]) -> bool {
        bytes.starts_with(b"\x89PNG") || bytes.starts_with(&[0xff, 0xd8]) || is_webp(bytes)
    }
}

fn is_webp(bytes: &[u8]) -> bool {
    bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP")
}

fn decode_png(bytes: &[u8]) -> Result<Picture, PictureError> {
    let refuse = |e: png::DecodingError| PictureError::Malformed {
        at: "PNG",
        what: e.to_string(),
    };
    let limits = png::Limits {
        bytes: MAX_DECODED_BYTES,
    };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(refuse)?;
    let (width, height) = reader.info().size();
    check_size(width, height)?;
    let size = reader.output_buffer_size().unwrap_or(usize::MAX);
    if size > MAX_DECODED_BYTES {
        return Err(too_large(width, height));
    }
    let mut data = vec![0; size];
    let frame = reader.next_frame(&mut data).map_err(refuse)?;
    data.truncate(frame.buffer_size());
    let pixels = to_rgba(&data, frame.color_type.samples());
    Picture::from_pixels(width, height, pixels)
}

fn check_size(width: u32, height: u32) -> Result<(), PictureError> {
    let bytes = u64::from(width) * u64::from(height) * 4;
    if width > MAX_SIDE || height > MAX_SIDE || bytes > MAX_DECODED_BYTES as u64 {
        return Err(too_large(width, height));
    }
    Ok(())
}

fn too_large(width: u32, height: u32) -> PictureError {
    PictureError::LimitExceeded {
        width,
        height,
        samples: 1,
        limit: "16384 pixels per side or 512 MiB",
    }
}

/// Converts grey, grey and alpha, RGB or RGBA bytes to RGBA.
fn to_rgba(data: &[u8], channels: usize) -> Vec<Rgba> {
    let pixel = |p: &[u8]| match *p {
        [grey] => [grey, grey, grey, 255],
        [grey, alpha] => [grey, grey, grey, alpha],
        [r, g, b] => [r, g, b, 255],
        [r, g, b, a, ..] => [r, g, b, a],
        [] => [0; 4],
    };
    data.chunks_exact(channels.max(1)).map(pixel).collect()
}

fn decode_jpeg(bytes: &[u8]) -> Result<Picture, PictureError> {
    let refuse = |what: String| PictureError::Malformed { at: "JPEG", what };
    let options = DecoderOptions::default()
        .jpeg_set_out_colorspace(ColorSpace::RGBA)
        .set_max_width(MAX_SIDE as usize)
        .set_max_height(MAX_SIDE as usize);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder
        .decode_headers()
        .map_err(|e| refuse(format!("{e:?}")))?;
    let Some(found) = decoder.info() else {
        return Err(refuse("no frame header".to_owned()));
    };
    let (width, height) = (u32::from(found.width), u32::from(found.height));
    check_size(width, height)?;
    let data = decoder.decode().map_err(|e| refuse(format!("{e:?}")))?;
    Picture::from_pixels(width, height, to_rgba(&data, 4))
}

fn decode_webp(bytes: &[u8]) -> Result<Picture, PictureError> {
    let refuse = |e: image_webp::DecodingError| PictureError::Malformed {
        at: "WebP",
        what: e.to_string(),
    };
    let mut decoder = WebPDecoder::new(Cursor::new(bytes)).map_err(refuse)?;
    decoder.set_memory_limit(MAX_DECODED_BYTES);
    let (width, height) = decoder.dimensions();
    check_size(width, height)?;
    let size = decoder.output_buffer_size().unwrap_or(usize::MAX);
    if size > MAX_DECODED_BYTES {
        return Err(too_large(width, height));
    }
    let channels = if decoder.has_alpha() { 4 } else { 3 };
    let mut data = vec![0; size];
    decoder.read_image(&mut data).map_err(refuse)?;
    Picture::from_pixels(width, height, to_rgba(&data, channels))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn small() -> Picture {
        let pixels = (0..35u8).map(|i| [i * 7, 255 - i, i, i * 5]).collect();
        Picture::from_pixels(7, 5, pixels).unwrap()
    }

    #[test]
    fn png_goes_there_and_back_with_the_same_bytes() {
        let bytes = small().to_png().unwrap();
        assert_eq!(bytes, small().to_png().unwrap());
        assert_eq!(Picture::decode(&bytes).unwrap(), small());
        assert!(Picture::new(0, 3, [0; 4]).unwrap().to_png().is_err());
    }

    #[test]
    fn a_small_png_holds_the_same_pixels() {
        let opaque = Picture::from_pixels(
            7,
            5,
            small()
                .pixels()
                .iter()
                .map(|[r, g, b, _]| [*r, *g, *b, 255])
                .collect(),
        );
        for picture in [small(), opaque.unwrap()] {
            let bytes = picture.to_small_png().unwrap();
            assert_eq!(Picture::decode(&bytes).unwrap(), picture);
            // The colour type stands after the signature, the start of the header and its sizes.
            assert_eq!(bytes[25], if picture.is_opaque() { 2 } else { 6 });
        }
    }

    #[test]
    fn reads_every_colour_type_of_png() {
        use png::{BitDepth, ColorType};
        let encode = |color, depth, data: &[u8]| {
            let mut bytes = Vec::new();
            let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
            encoder.set_color(color);
            encoder.set_depth(depth);
            if color == ColorType::Indexed {
                encoder.set_palette(vec![1, 2, 3, 4, 5, 6]);
                encoder.set_trns(vec![255, 128]);
            }
            let mut writer = encoder.write_header().unwrap();
            writer.write_image_data(data).unwrap();
            writer.finish().unwrap();
            Picture::decode(&bytes).unwrap().pixels().to_vec()
        };
        let grey = encode(ColorType::Grayscale, BitDepth::One, &[0b0100_0000]);
        assert_eq!(grey, [[0, 0, 0, 255], [255; 4]]);
        let alpha = encode(ColorType::GrayscaleAlpha, BitDepth::Eight, &[9, 8, 7, 6]);
        assert_eq!(alpha, [[9, 9, 9, 8], [7, 7, 7, 6]]);
        let wide = [1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0];
        let rgb = encode(ColorType::Rgb, BitDepth::Sixteen, &wide);
        assert_eq!(rgb, [[1, 2, 3, 255], [4, 5, 6, 255]]);
        let indexed = encode(ColorType::Indexed, BitDepth::Eight, &[1, 0]);
        assert_eq!(indexed, [[4, 5, 6, 128], [1, 2, 3, 255]]);
    }

    #[test]
    fn broken_files_are_refused_at_every_length() {
        let bytes = small().to_png().unwrap();
        for length in 0..bytes.len() - 12 {
            assert!(
                Picture::decode(&bytes[..length]).is_err(),
                "cut to {length} bytes"
            );
        }
        let gif = Picture::decode(b"GIF89a").unwrap_err().to_string();
        assert!(gif.contains("47 49 46 38") && gif.contains("PNG, JPEG or WebP"));
    }

    #[test]
    fn reads_webp_with_and_without_alpha() {
        let encode = |color, data: &[u8]| {
            let mut bytes = Vec::new();
            let encoder = image_webp::WebPEncoder::new(&mut bytes);
            encoder.encode(data, 2, 1, color).unwrap();
            bytes
        };
        let rgba = encode(image_webp::ColorType::Rgba8, &[1, 2, 3, 4, 5, 6, 7, 255]);
        let found = Picture::decode(&rgba).unwrap();
        assert_eq!(found.pixels(), [[1, 2, 3, 4], [5, 6, 7, 255]]);
        let rgb = encode(image_webp::ColorType::Rgb8, &[9, 8, 7, 6, 5, 4]);
        let found = Picture::decode(&rgb).unwrap();
        assert_eq!(found.pixels(), [[9, 8, 7, 255], [6, 5, 4, 255]]);
        assert!(Picture::is_known_format(&rgb));
        for length in 12..rgb.len() - 2 {
            assert!(Picture::decode(&rgb[..length]).is_err(), "{length} bytes");
        }
    }

    #[test]
    fn a_picture_of_nearly_no_bytes_cannot_ask_for_much_memory() {
        let mut bytes = small().to_png().unwrap();
        bytes[16..24].copy_from_slice(&[0, 0, 0x7f, 0xff, 0, 0, 0x7f, 0xff]);
        // The header's checksum is now wrong as well; either error is correct.
        assert!(Picture::decode(&bytes).is_err());
        // Start of image, then a frame header for 65535 x 65535.
        let jpeg =
            b"\xff\xd8\xff\xc0\x00\x11\x08\xff\xff\xff\xff\x03\x01\x11\x00\x02\x11\x00\x03\x11\x00";
        assert!(matches!(
            Picture::decode(jpeg),
            Err(PictureError::Malformed { .. } | PictureError::LimitExceeded { .. })
        ));
    }
}
