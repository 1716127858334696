//! Movies of pixels, for where vector graphics are not supported: GIF and animated WebP.
//!
//! Source: GIF89a (CompuServe, 1990) with the Netscape loop extension; the WebP container (RFC
//! 9649: `VP8X`, `ANIM`, `ANMF`) around lossless pictures. The frames come from
//! [`super::smil_sampler`] and [`super::raster`]; a sequence of PNG files is [`Picture::to_png`] of
//! each. Both formats repeat forever.

use crate::error::PictureError;
use crate::picture::Picture;
use gif::{DisposalMethod, Encoder, Frame, Repeat};
use image_webp::{ColorType, WebPEncoder};

/// Palette quality of the encoder: 1 best, 30 fastest.
const PALETTE_SPEED: i32 = 10;
/// Maximum side of a WebP picture, pixels.
const MAX_WEBP_SIDE: u32 = 1 << 14;

/// Returns a GIF file of pictures, each with its duration in seconds: 256 colours per frame, pixels
/// either opaque or transparent, times in hundredths of a second.
///
/// Rounded times never drift by more than half a hundredth, but browsers slow down animations
/// faster than 50 frames per second.
///
/// # Errors
/// [`PictureError::Mismatch`] if there are no frames, their sizes differ, a side is 0 or above
/// 65535, or a duration is not a positive number.
pub fn gif(moments: &[(Picture, f64)]) -> Result<Vec<u8>, PictureError> {
    let (width, height) = size(moments, u32::from(u16::MAX))?;
    let (width, height) = (width as u16, height as u16);
    let refuse = |e: gif::EncodingError| mismatch(e.to_string());
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width, height, &[]).map_err(refuse)?;
    encoder.set_repeat(Repeat::Infinite).map_err(refuse)?;
    for ((picture, _), delay) in moments.iter().zip(ticks(moments, 100.0)) {
        // GIF has no partial transparency: half covered counts as opaque.
        let hard = |[r, g, b, a]: &[u8; 4]| {
            if *a < 128 { [0; 4] } else { [*r, *g, *b, 255] }
        };
        let mut pixels: Vec<u8> = picture.pixels().iter().flat_map(hard).collect();
        let mut frame = Frame::from_rgba_speed(width, height, &mut pixels, PALETTE_SPEED);
        frame.delay = u16::try_from(delay).unwrap_or(u16::MAX);
        if frame.transparent.is_some() {
            frame.dispose = DisposalMethod::Background;
        }
        encoder.write_frame(&frame).map_err(refuse)?;
    }
    drop(encoder);
    Ok(bytes)
}

/// Returns a lossless animated WebP file of pictures, each with its duration in seconds; times in
/// milliseconds.
///
/// # Errors
/// As [`gif()`], with sides up to 16384.
pub fn webp(moments: &[(Picture, f64)]) -> Result<Vec<u8>, PictureError> {
    let (width, height) = size(moments, MAX_WEBP_SIDE)?;
    // Canvas and frame sizes are stored less one, in three bytes.
    let three = |n: u32| n.to_le_bytes().into_iter().take(3);
    let canvas: Vec<u8> = three(width - 1).chain(three(height - 1)).collect();
    let mut body = b"WEBP".to_vec();
    const ANIMATION: u8 = 1 << 1;
    const ALPHA: u8 = 1 << 4;
    let mut head = vec![ANIMATION | ALPHA, 0, 0, 0];
    head.extend(&canvas);
    push_chunk(&mut body, *b"VP8X", &head);
    // Transparent background, endless.
    push_chunk(&mut body, *b"ANIM", &[0; 6]);
    for ((picture, _), millis) in moments.iter().zip(ticks(moments, 1000.0)) {
        let mut still = Vec::new();
        WebPEncoder::new(&mut still)
            .encode(
                picture.pixels().as_flattened(),
                width,
                height,
                ColorType::Rgba8,
            )
            .map_err(|e| mismatch(e.to_string()))?;
        // At the canvas' corner, of its size, replacing what was there.
        const REPLACES: u8 = 1 << 1;
        let mut frame = vec![0; 6];
        frame.extend(&canvas);
        frame.extend(three(millis.min((1 << 24) - 1)));
        frame.push(REPLACES);
        // The picture's own chunk follows the twelve bytes of its file's header.
        frame.extend(still.get(12..).unwrap_or_default());
        push_chunk(&mut body, *b"ANMF", &frame);
    }
    let mut bytes = Vec::new();
    push_chunk(&mut bytes, *b"RIFF", &body);
    Ok(bytes)
}

/// A RIFF chunk, padded to an even length.
fn push_chunk(out: &mut Vec<u8>, name: [u8; 4], content: &[u8]) {
    out.extend(name);
    out.extend((content.len() as u32).to_le_bytes());
    out.extend(content);
    if !content.len().is_multiple_of(2) {
        out.push(0);
    }
}

/// Number of ticks of each picture; the sums are rounded, so nothing drifts.
fn ticks(moments: &[(Picture, f64)], a_second: f64) -> Vec<u32> {
    let mut secs = 0.0;
    let mut before = 0.0;
    let of = |(_, shown): &(Picture, f64)| {
        secs += shown;
        let now = (secs * a_second).round();
        let ticks = now - before;
        before = now;
        ticks as u32
    };
    moments.iter().map(of).collect()
}

fn size(moments: &[(Picture, f64)], most: u32) -> Result<(u32, u32), PictureError> {
    let Some((first, _)) = moments.first() else {
        return Err(mismatch("the picture has no frame".to_owned()));
    };
    let (width, height) = (first.width(), first.height());
    if width == 0 || height == 0 || width > most || height > most {
        let found = format!("{width} x {height}, expected 1 to {most} pixels per side");
        return Err(mismatch(found));
    }
    for (picture, secs) in moments {
        if (picture.width(), picture.height()) != (width, height) {
            return Err(mismatch("all frames must have the same size".to_owned()));
        }
        if !secs.is_finite() || *secs <= 0.0 {
            return Err(mismatch(format!(
                "a frame must last a positive, finite time, found {secs} s"
            )));
        }
    }
    Ok((width, height))
}

fn mismatch(what: String) -> PictureError {
    let at = "moving picture";
    PictureError::Mismatch { at, what }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::Rgba;
    use std::io::Cursor;

    fn moment(colors: [Rgba; 2], secs: f64) -> (Picture, f64) {
        let picture = Picture::from_pixels(2, 1, colors.to_vec()).unwrap();
        (picture, secs)
    }

    const CLEAR: Rgba = [0; 4];
    const RED: Rgba = [255, 0, 0, 255];
    const GREY: Rgba = [7, 8, 9, 255];

    #[test]
    fn gif_gives_pixels_and_times_back() {
        let moments = [
            moment([RED, GREY], 1.0 / 30.0),
            moment([CLEAR, RED], 1.0 / 30.0),
            moment([GREY, GREY], 1.0 / 30.0),
        ];
        let bytes = gif(&moments).unwrap();
        assert_eq!(bytes, gif(&moments).unwrap());
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut reader = options.read_info(Cursor::new(&bytes)).unwrap();
        assert_eq!(reader.repeat(), Repeat::Infinite);
        let mut delays = Vec::new();
        for (picture, _) in &moments {
            let frame = reader.read_next_frame().unwrap().unwrap();
            delays.push(frame.delay);
            for (found, wanted) in frame.buffer.chunks(4).zip(picture.pixels()) {
                assert!(found == wanted || (found[3] == 0 && wanted[3] == 0));
            }
        }
        // A thirtieth is 3.33 hundredths; three of them are ten.
        assert_eq!(delays, [3, 4, 3]);
    }

    #[test]
    fn webp_gives_pixels_and_times_back() {
        let half = [10, 20, 30, 128];
        let moments = [moment([RED, half], 0.04), moment([CLEAR, GREY], 0.5)];
        let bytes = webp(&moments).unwrap();
        let mut reader = image_webp::WebPDecoder::new(Cursor::new(&bytes)).unwrap();
        assert_eq!(reader.dimensions(), (2, 1));
        assert!(reader.is_animated() && reader.has_alpha());
        assert_eq!(reader.num_frames(), 2);
        assert_eq!(reader.loop_count(), image_webp::LoopCount::Forever);
        for (picture, secs) in &moments {
            let mut pixels = [0; 8];
            let millis = reader.read_frame(&mut pixels).unwrap();
            assert_eq!(f64::from(millis), secs * 1000.0);
            assert_eq!(pixels, picture.pixels().as_flattened());
        }
    }

    #[test]
    fn what_cannot_be_written_is_refused() {
        let good = moment([RED, GREY], 0.1);
        let other = (Picture::new(1, 1, RED).unwrap(), 0.1);
        let none = (Picture::new(0, 1, RED).unwrap(), 0.1);
        for bad in [
            vec![],
            vec![none],
            vec![good.clone(), other],
            vec![(good.0.clone(), f64::NAN)],
            vec![(good.0, 0.0)],
        ] {
            assert!(gif(&bad).is_err() && webp(&bad).is_err());
        }
    }
}
