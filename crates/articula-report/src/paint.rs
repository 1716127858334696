//! Anti-aliased lines, discs, rings, boxes and text on a picture.

use articula::flat::{Picture, Rgba};
use glam::Vec2;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// Replacement of letters that the font lacks.
const UNKNOWN: char = '?';

/// Size and weight of text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum TextStyle {
    /// 16 pixels high.
    #[default]
    Body,
    /// 16 pixels high, bold.
    Strong,
    /// 20 pixels high, bold.
    Title,
}

impl TextStyle {
    /// Height of a line in pixels.
    pub(crate) fn height(self) -> u32 {
        self.raster().1 as u32
    }

    /// Width of a text in pixels; the font is monospaced.
    pub(crate) fn width(self, text: &str) -> u32 {
        (text.chars().count() * self.letter_width()) as u32
    }

    /// Returns the text, its end replaced by two dots if it is wider than `width` pixels.
    pub(crate) fn fitted(self, text: &str, width: u32) -> String {
        if self.width(text) <= width {
            return text.to_owned();
        }
        let room = (width as usize / self.letter_width()).saturating_sub(2);
        let kept: String = text.chars().take(room).collect();
        kept + ".."
    }

    fn raster(self) -> (FontWeight, RasterHeight) {
        match self {
            Self::Body => (FontWeight::Regular, RasterHeight::Size16),
            Self::Strong => (FontWeight::Bold, RasterHeight::Size16),
            Self::Title => (FontWeight::Bold, RasterHeight::Size20),
        }
    }

    fn letter_width(self) -> usize {
        let (weight, height) = self.raster();
        get_raster_width(weight, height)
    }
}

/// Draws a line with round ends, with radius `from_radius` at `from` and `to_radius` at `to`.
pub(crate) fn draw_line(picture: &mut Picture, from: (Vec2, f32), to: (Vec2, f32), color: Rgba) {
    let ((a, from_radius), (b, to_radius)) = (from, to);
    let axis = b - a;
    let length = axis.length_squared();
    let reach = from_radius.max(to_radius);
    draw_shape(picture, (a.min(b) - reach, a.max(b) + reach), color, |at| {
        let along = (at - a).dot(axis) / length;
        let along = if along.is_finite() {
            along.clamp(0.0, 1.0)
        } else {
            0.0
        };
        let radius = from_radius + (to_radius - from_radius) * along;
        at.distance(a + axis * along) - radius
    });
}

/// Draws a filled disc.
pub(crate) fn draw_disc(picture: &mut Picture, middle: Vec2, radius: f32, color: Rgba) {
    draw_shape(picture, (middle - radius, middle + radius), color, |at| {
        at.distance(middle) - radius
    });
}

/// Draws a ring of this line width inside the radius.
pub(crate) fn draw_ring(picture: &mut Picture, middle: Vec2, radius: f32, width: f32, color: Rgba) {
    draw_shape(picture, (middle - radius, middle + radius), color, |at| {
        (at.distance(middle) - radius + 0.5 * width).abs() - 0.5 * width
    });
}

/// Fills the box between two corners, in whole pixels.
pub(crate) fn draw_box(
    picture: &mut Picture,
    x: i32,
    y: i32,
    width: u32,
    height: u32,
    color: Rgba,
) {
    for row in y..y.saturating_add_unsigned(height) {
        for column in x..x.saturating_add_unsigned(width) {
            picture.blend(column, row, color, 1.0);
        }
    }
}

/// Draws one line of text, its top left at `(x, y)`.
///
/// Letters outside Latin 1 become a question mark.
pub(crate) fn draw_text(
    picture: &mut Picture,
    x: i32,
    y: i32,
    text: &str,
    style: TextStyle,
    color: Rgba,
) {
    let (weight, height) = style.raster();
    let advance = style.letter_width() as i32;
    for (i, letter) in (0..).zip(text.chars()) {
        let shape = get_raster(letter, weight, height);
        let Some(shape) = shape.or_else(|| get_raster(UNKNOWN, weight, height)) else {
            continue;
        };
        for (row, line) in (0..).zip(shape.raster()) {
            for (column, coverage) in (0..).zip(line.iter()) {
                if *coverage > 0 {
                    let coverage = f32::from(*coverage) / 255.0;
                    picture.blend(x + i * advance + column, y + row, color, coverage);
                }
            }
        }
    }
}

/// Fills where a signed distance (in pixels) is negative, between two corners.
fn draw_shape(
    picture: &mut Picture,
    (low, high): (Vec2, Vec2),
    color: Rgba,
    distance: impl Fn(Vec2) -> f32,
) {
    if !(low.is_finite() && high.is_finite()) {
        return;
    }
    let size = Vec2::new(picture.width() as f32, picture.height() as f32);
    let low = (low - 1.0).clamp(Vec2::ZERO, size);
    let high = (high + 1.0).clamp(Vec2::ZERO, size);
    for y in low.y as i32..high.y.ceil() as i32 {
        for x in low.x as i32..high.x.ceil() as i32 {
            let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            let coverage = 0.5 - distance(at);
            if coverage > 0.0 {
                picture.blend(x, y, color, coverage);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: Rgba = [255; 4];
    const BLACK: Rgba = [0, 0, 0, 255];

    fn ink(picture: &Picture) -> f32 {
        let dark = |p: &Rgba| 1.0 - f32::from(p[0]) / 255.0;
        picture.pixels().iter().map(dark).sum()
    }

    #[test]
    fn areas_are_those_of_the_shapes() {
        let mut disc = Picture::new(40, 40, WHITE).unwrap();
        draw_disc(&mut disc, Vec2::new(20.3, 19.8), 8.0, BLACK);
        let area = std::f32::consts::PI * 64.0;
        assert!((ink(&disc) - area).abs() < 0.01 * area);
        let mut ring = Picture::new(40, 40, WHITE).unwrap();
        draw_ring(&mut ring, Vec2::splat(20.0), 8.0, 2.0, BLACK);
        let area = std::f32::consts::PI * (64.0 - 36.0);
        assert!((ink(&ring) - area).abs() < 0.02 * area);
        let mut line = Picture::new(40, 40, WHITE).unwrap();
        let (a, b) = (Vec2::new(8.0, 8.0), Vec2::new(32.0, 26.0));
        draw_line(&mut line, (a, 2.0), (b, 2.0), BLACK);
        let area = 30.0 * 4.0 + std::f32::consts::PI * 4.0;
        assert!((ink(&line) - area).abs() < 0.02 * area);
    }

    #[test]
    fn marks_outside_or_without_a_place_are_left_out() {
        let mut picture = Picture::new(8, 8, WHITE).unwrap();
        draw_disc(&mut picture, Vec2::splat(-50.0), 3.0, BLACK);
        draw_disc(&mut picture, Vec2::NAN, 3.0, BLACK);
        draw_line(
            &mut picture,
            (Vec2::splat(99.0), 1.0),
            (Vec2::splat(99.0), 1.0),
            BLACK,
        );
        draw_text(&mut picture, 7, 900, "far", TextStyle::Body, BLACK);
        assert_eq!(ink(&picture), 0.0);
        draw_line(
            &mut picture,
            (Vec2::splat(4.0), 2.0),
            (Vec2::splat(4.0), 2.0),
            BLACK,
        );
        assert!(ink(&picture) > 10.0, "a line without length is a dot");
    }

    #[test]
    fn text_is_as_wide_as_it_says() {
        let mut picture = Picture::new(200, 24, WHITE).unwrap();
        draw_text(&mut picture, 4, 2, "Ag\u{4e2d}", TextStyle::Title, BLACK);
        let width = TextStyle::Title.width("Ag\u{4e2d}");
        let inked = |x: u32| (0..24).any(|y| picture.get(x, y) != Some(WHITE));
        assert!((0..4).all(|x| !inked(x)) && (4 + width..200).all(|x| !inked(x)));
        assert!((4..4 + width).any(inked));
        assert_eq!(TextStyle::Body.fitted("walking", 5 * 8), "wal..");
        assert_eq!(TextStyle::Body.fitted("walk", 4 * 8), "walk");
    }
}
