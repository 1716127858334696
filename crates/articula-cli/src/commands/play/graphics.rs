//! Pictures in terminals that show pixels, by the graphics protocol of kitty (<https://sw.kovidgoyal.net/kitty/graphics-protocol/>).

use anyhow::Context;
use articula::flat::Picture;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use std::fmt::Write as _;

/// Bytes of base64 in one escape sequence, as the protocol allows.
const CHUNK: usize = 4096;
/// Most pixels of a picture, which software draws 20 times a second; the terminal enlarges it.
const MOST_PIXELS: u32 = 480 * 640;
/// Width and height of a cell where the terminal does not tell.
const CELL_PX: (u32, u32) = (8, 16);
/// Values of `TERM_PROGRAM` of other terminals with this protocol.
const PROGRAMS: [&str; 2] = ["ghostty", "WezTerm"];

/// A terminal that shows pixels.
pub(super) struct Graphics {
    /// Width and height of a cell in pixels.
    cell_px: (u32, u32),
}

impl Graphics {
    /// What the terminal of the environment shows; `variable` returns variables of it.
    pub(super) fn of_environment(variable: impl Fn(&str) -> Option<String>) -> Option<Self> {
        let is = |name: &str, wanted: &[&str]| {
            variable(name).is_some_and(|value| wanted.contains(&value.as_str()))
        };
        // A terminal within another one passes no pictures on.
        let is_nested = variable("TMUX").is_some() || variable("STY").is_some();
        let is_known =
            is("TERM", &["xterm-kitty", "xterm-ghostty"]) || is("TERM_PROGRAM", &PROGRAMS);
        (is_known && !is_nested).then(|| Self { cell_px: cell_px() })
    }

    /// Width and height of a picture that fills some columns and rows.
    pub(super) fn size(&self, columns: u32, rows: u32) -> (u32, u32) {
        let (width, height) = (columns * self.cell_px.0, rows * self.cell_px.1);
        let scale = (f64::from(MOST_PIXELS) / (f64::from(width) * f64::from(height)))
            .sqrt()
            .min(1.0);
        let scaled = |pixels: u32| ((f64::from(pixels) * scale) as u32).max(2);
        (scaled(width), scaled(height))
    }

    /// A picture over some columns and rows, from the cursor on, which stays. It takes the place of the one before.
    pub(super) fn shown(
        &self,
        picture: &Picture,
        columns: u32,
        rows: u32,
    ) -> anyhow::Result<String> {
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
}

#[cfg(unix)]
fn cell_px() -> (u32, u32) {
    let Ok(size) = rustix::termios::tcgetwinsize(std::io::stdout()) else {
        return CELL_PX;
    };
    let of = |pixels: u16, cells: u16| {
        u32::from(pixels)
            .checked_div(u32::from(cells))
            .filter(|px| *px > 0)
    };
    of(size.ws_xpixel, size.ws_col)
        .zip(of(size.ws_ypixel, size.ws_row))
        .unwrap_or(CELL_PX)
}

#[cfg(not(unix))]
fn cell_px() -> (u32, u32) {
    CELL_PX
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(variables: &[(&str, &str)]) -> Option<Graphics> {
        Graphics::of_environment(|name| {
            let found = variables.iter().find(|(known, _)| *known == name);
            found.map(|(_, value)| (*value).to_owned())
        })
    }

    #[test]
    fn terminals_that_show_pixels_are_known_by_their_names() {
        assert!(of(&[("TERM", "xterm-kitty")]).is_some());
        assert!(of(&[("TERM", "xterm-256color"), ("TERM_PROGRAM", "WezTerm")]).is_some());
        assert!(
            of(&[
                ("TERM", "xterm-256color"),
                ("TERM_PROGRAM", "Apple_Terminal")
            ])
            .is_none()
        );
        assert!(of(&[("TERM", "xterm-kitty"), ("TMUX", "a,1,0")]).is_none());
        assert!(of(&[]).is_none());
    }

    #[test]
    fn a_picture_is_sent_whole_in_chunks_that_the_protocol_allows() {
        let graphics = Graphics { cell_px: (10, 20) };
        assert_eq!(graphics.size(20, 10), (200, 200));
        let (width, height) = graphics.size(160, 55);
        assert!(width * height <= MOST_PIXELS && width * height > MOST_PIXELS * 99 / 100);
        // Noise, which PNG does not make short.
        let mut seed = 1_u32;
        let pixels = (0..64 * 64).map(|_| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let [r, g, b, _] = seed.to_be_bytes();
            [r, g, b, 255]
        });
        let picture = Picture::from_pixels(64, 64, pixels.collect()).unwrap();
        let text = graphics.shown(&picture, 8, 4).unwrap();
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
