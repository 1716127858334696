//! Pictures by the graphics protocol of kitty (<https://sw.kovidgoyal.net/kitty/graphics-protocol/>).

use anyhow::Context;
use articula::flat::Picture;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use std::fmt::Write as _;

/// Bytes of base64 in one escape sequence, as the protocol allows.
const CHUNK: usize = 4096;

/// A picture over some columns and rows, from the cursor on, which stays. It takes the place of the one before.
pub(super) fn shown(picture: &Picture, columns: u32, rows: u32) -> anyhow::Result<String> {
    let png = picture.to_png().context("the picture")?;
    let encoded = STANDARD.encode(png);
    let mut text = String::with_capacity(encoded.len() + encoded.len() / 100 + 64);
    // Base64 is ASCII.
    let chunks: Vec<&[u8]> = encoded.as_bytes().chunks(CHUNK).collect();
    for (number, chunk) in chunks.iter().enumerate() {
        text.push_str("\x1b_G");
        if number == 0 {
            // Transmitted and shown at once, PNG, no answers, one image in one place.
            let _ = write!(text, "a=T,f=100,q=2,i=1,p=1,C=1,c={columns},r={rows},");
        }
        let _ = write!(text, "m={};", u8::from(number + 1 < chunks.len()));
        text.push_str(std::str::from_utf8(chunk).unwrap_or_default());
        text.push_str("\x1b\\");
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_sent_whole_in_chunks_that_the_protocol_allows() {
        // Noise, which PNG does not make short.
        let mut seed = 1_u32;
        let pixels = (0..64 * 64).map(|_| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let [r, g, b, _] = seed.to_be_bytes();
            [r, g, b, 255]
        });
        let picture = Picture::from_pixels(64, 64, pixels.collect()).unwrap();
        let text = shown(&picture, 8, 4).unwrap();
        let parts: Vec<&str> = text
            .split("\x1b\\")
            .filter(|part| !part.is_empty())
            .collect();
        assert!(parts.len() > 2);
        let mut encoded = String::new();
        for (number, part) in parts.iter().enumerate() {
            let (keys, data) = part
                .strip_prefix("\x1b_G")
                .unwrap()
                .split_once(';')
                .unwrap();
            assert!(data.len() <= CHUNK && (number + 1 == parts.len() || data.len() % 4 == 0));
            assert_eq!(keys.ends_with("m=1"), number + 1 < parts.len());
            assert_eq!(keys.contains("c=8,r=4"), number == 0);
            encoded.push_str(data);
        }
        assert_eq!(STANDARD.decode(encoded).unwrap(), picture.to_png().unwrap());
    }
}
