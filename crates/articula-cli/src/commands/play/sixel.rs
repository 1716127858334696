//! Pictures by Sixel (DEC STD 070, "Video Systems Reference Manual", chapter 9).
//!
//! The crates that write it bring some fifty others for the choice of colours; this one takes those of GIF files.

use articula::flat::Picture;
use color_quant::NeuQuant;
use std::collections::BTreeMap;
use std::collections::hash_map::{Entry, HashMap};
use std::fmt::Write as _;

/// Most colours, as all terminals have.
const MOST_COLORS: usize = 256;
/// One in how many pixels the colours of a picture with more are chosen by.
const SAMPLED: i32 = 10;
/// Rows of pixels of a character.
const ROWS: usize = 6;

/// A picture from the cursor on, over what is there.
pub(super) fn shown(picture: &Picture) -> String {
    let (colors, indices) = indexed(picture);
    let (width, height) = (picture.width() as usize, picture.height());
    // Pixels are square, and none is left as it is.
    let mut text = format!("\x1bP0;1q\"1;1;{width};{height}");
    for (index, color) in colors.iter().enumerate() {
        let [r, g, b] = color.map(|channel| (u32::from(channel) * 100 + 127) / 255);
        let _ = write!(text, "#{index};2;{r};{g};{b}");
    }
    for band in indices.chunks(ROWS * width) {
        let mut bits: BTreeMap<u8, Vec<u8>> = BTreeMap::new();
        for (at, index) in band.iter().enumerate() {
            let columns = bits.entry(*index).or_insert_with(|| vec![0; width]);
            columns[at % width] |= 1 << (at / width);
        }
        for (index, columns) in bits {
            let _ = write!(text, "#{index}");
            for run in columns.chunk_by(|a, b| a == b) {
                let character = char::from(b'?' + run[0]);
                match run.len() {
                    length @ 1..=3 => text.extend(std::iter::repeat_n(character, length)),
                    length => {
                        let _ = write!(text, "!{length}{character}");
                    }
                }
            }
            text.push('$');
        }
        text.push('-');
    }
    text.push_str("\x1b\\");
    text
}

/// The colours of a picture, at most 256, and that of each pixel.
fn indexed(picture: &Picture) -> (Vec<[u8; 3]>, Vec<u8>) {
    let opaque = |[r, g, b, _]: &[u8; 4]| [*r, *g, *b];
    let mut known: HashMap<[u8; 3], u8> = HashMap::new();
    let mut colors: Vec<[u8; 3]> = Vec::new();
    for color in picture.pixels().iter().map(opaque) {
        if let Entry::Vacant(place) = known.entry(color) {
            if colors.len() == MOST_COLORS {
                return chosen(picture);
            }
            place.insert(colors.len() as u8);
            colors.push(color);
        }
    }
    let indices = picture.pixels().iter().map(|pixel| known[&opaque(pixel)]);
    let indices = indices.collect();
    (colors, indices)
}

/// The colours that suit a picture of more than 256 best.
fn chosen(picture: &Picture) -> (Vec<[u8; 3]>, Vec<u8>) {
    let pixels = picture.pixels();
    let chosen = NeuQuant::new(SAMPLED, MOST_COLORS, pixels.as_flattened());
    let map = chosen.color_map_rgb();
    let (colors, _) = map.as_chunks::<3>();
    let mut nearest: HashMap<[u8; 4], u8> = HashMap::new();
    let of = |pixel: &[u8; 4]| {
        let index = nearest.entry(*pixel);
        *index.or_insert_with_key(|pixel| chosen.index_of(pixel) as u8)
    };
    (colors.to_vec(), pixels.iter().map(of).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a terminal shows, whose pixels are black before.
    fn displayed(text: &str) -> Vec<Vec<[u8; 3]>> {
        let body = text.strip_prefix("\x1bP0;1q\"1;1;").unwrap();
        let body = body.strip_suffix("\x1b\\").unwrap();
        let (size, mut rest) = body.split_at(body.find('#').unwrap());
        let (width, height) = size.split_once(';').unwrap();
        let [width, height]: [usize; 2] = [width, height].map(|n| n.parse().unwrap());
        let mut screen = vec![vec![[0; 3]; width]; height];
        let mut colors = HashMap::new();
        let (mut color, mut x, mut y) = (0, 0, 0);
        let number = |text: &mut &str| -> usize {
            let end = text.find(|c: char| !c.is_ascii_digit()).unwrap();
            let (digits, left) = text.split_at(end);
            *text = left;
            digits.parse().unwrap()
        };
        while let Some(first) = rest.chars().next() {
            rest = &rest[1..];
            let mut count = 1;
            let mut character = first;
            match first {
                '#' => {
                    color = number(&mut rest);
                    if let Some(defined) = rest.strip_prefix(";2;") {
                        rest = defined;
                        let mut channel = || {
                            let value = number(&mut rest);
                            rest = rest.strip_prefix(';').unwrap_or(rest);
                            (value * 255 / 100) as u8
                        };
                        colors.insert(color, [channel(), channel(), channel()]);
                    }
                    continue;
                }
                '$' => x = 0,
                '-' => (x, y) = (0, y + ROWS),
                '!' => {
                    count = number(&mut rest);
                    character = rest.chars().next().unwrap();
                    rest = &rest[1..];
                }
                _ => {}
            }
            if ('?'..='~').contains(&character) {
                let bits = character as u8 - b'?';
                for _ in 0..count {
                    for row in (0..ROWS).filter(|row| bits >> row & 1 == 1) {
                        screen[y + row][x] = colors[&color];
                    }
                    x += 1;
                }
            }
        }
        screen
    }

    #[test]
    fn few_colors_are_shown_as_they_are() {
        // Channels that hundredths tell exactly.
        let color = |x: usize, y: usize| {
            [
                51 * (x % 6) as u8,
                51 * (y % 5) as u8,
                255 * u8::from(x > 9),
            ]
        };
        let (width, height) = (23, 17);
        let all = (0..width * height).map(|i| (i % width, i / width));
        let pixels = all.map(|(x, y)| {
            let [r, g, b] = color(x, y);
            [r, g, b, 255]
        });
        let picture = Picture::from_pixels(23, 17, pixels.collect()).unwrap();
        let screen = displayed(&shown(&picture));
        assert_eq!((screen.len(), screen[0].len()), (height, width));
        for (y, row) in screen.iter().enumerate() {
            for (x, found) in row.iter().enumerate() {
                assert_eq!(*found, color(x, y), "{x} {y}");
            }
        }
    }

    #[test]
    fn of_many_colors_those_are_shown_that_are_near() {
        let pixels =
            (0..96 * 96).map(|i: usize| [(2 * (i % 96)) as u8, (2 * (i / 96)) as u8, 128, 255]);
        let picture = Picture::from_pixels(96, 96, pixels.collect()).unwrap();
        let screen = displayed(&shown(&picture));
        let pairs = screen.iter().flatten().zip(picture.pixels());
        let off = pairs.flat_map(|(a, b)| a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b))));
        let mean = off.sum::<f64>() / (96.0 * 96.0 * 3.0);
        // In a grid of 16 by 16 colours the two channels that change are 3 levels off in the mean; a hundredth is 2.55.
        assert!(mean < 6.0, "{mean}");
    }
}
