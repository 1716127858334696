//! Head and tail of a file, its numbers and its clock.

use crate::planar::PlanarError;
use glam::Vec2;
use std::fmt::{self, Display, Write};

/// An SVG that is being written.
pub(super) struct Document(String);

impl Document {
    /// Opens a picture of this size in pixels.
    pub(super) fn new(width: u32, height: u32) -> Self {
        // The opacities add up to the corner colours in sRGB only.
        Self(format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" \
             xmlns:xlink=\"http://www.w3.org/1999/xlink\" version=\"1.1\" width=\"{width}\" \
             height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
             color-interpolation-filters=\"sRGB\">\n"
        ))
    }

    /// The text so far, for appending.
    pub(super) fn text(&mut self) -> &mut String {
        &mut self.0
    }

    /// Closes the document; returns the text and the number of its elements.
    pub(super) fn end(mut self) -> (String, usize) {
        self.0.push_str("</svg>\n");
        // Only elements and the first line contain this bracket.
        let brackets = self.0.matches('<').count();
        let elements = brackets - self.0.matches("</").count() - 1;
        (self.0, elements)
    }
}

/// Appends formatted text; writing into a `String` does not fail.
pub(super) fn put(text: &mut String, arguments: fmt::Arguments<'_>) {
    text.write_fmt(arguments).unwrap_or_default();
}

/// A closed triangle with absolute coordinates, in the form of `d`.
pub(super) struct Outline(pub(super) [Vec2; 3]);

impl Display for Outline {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [a, b, c] = self.0;
        write!(
            f,
            "M {:.3} {:.3} L {:.3} {:.3} L {:.3} {:.3} z",
            a.x, a.y, b.x, b.y, c.x, c.y
        )
    }
}

/// Corners in the form of `points`, with a number of decimals.
pub(super) struct Points(pub(super) [Vec2; 3], pub(super) usize);

impl Display for Points {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([a, b, c], n) = (self.0, self.1);
        write!(
            f,
            "{:.n$},{:.n$} {:.n$},{:.n$} {:.n$},{:.n$}",
            a.x, a.y, b.x, b.y, c.x, c.y
        )
    }
}

/// A time or duration in milliseconds, in SVG syntax.
#[derive(Clone, Copy)]
pub(super) struct Millis(u64);

impl Display for Millis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{:03}s", self.0 / 1000, self.0 % 1000)
    }
}

/// Start times of frames.
#[derive(Clone, Copy)]
pub(super) struct Clock {
    fps: f64,
}

impl Clock {
    /// Returns the clock of a frame rate.
    ///
    /// # Errors
    /// [`PlanarError::Mismatch`] if frames are shorter than a millisecond or longer than 1000 s.
    pub(super) fn new(fps: f32) -> Result<Self, PlanarError> {
        if !(1e-3..=1e3).contains(&fps) {
            let what = format!("{fps}, expected 0.001 to 1000 frames a second");
            return Err(PlanarError::Mismatch { at: "fps", what });
        }
        Ok(Self { fps: fps.into() })
    }

    /// Start of a frame. Truncated, not rounded, so that the frame has begun at `frame / fps`.
    pub(super) fn begin(self, frame: usize) -> Millis {
        Millis((frame as f64 / self.fps * 1000.0 + 1e-6) as u64)
    }

    /// Time from the start of a frame to that of another.
    pub(super) fn between(self, from: usize, to: usize) -> Millis {
        Millis(self.begin(to).0 - self.begin(from).0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_digits_before_the_point_make_56_bytes_with_the_separator() {
        let corners = [[123.4561, 234.0], [345.1, 100.0], [399.9996, 200.5]];
        let outline = Outline(corners.map(Vec2::from)).to_string();
        assert_eq!(
            outline,
            "M 123.456 234.000 L 345.100 100.000 L 400.000 200.500 z"
        );
        assert_eq!(outline.len() + ";".len(), 56);
        let points = Points(corners.map(Vec2::from), 1).to_string();
        assert_eq!(points, "123.5,234.0 345.1,100.0 400.0,200.5");
    }

    #[test]
    fn frames_begin_in_time_and_abut() {
        let clock = Clock::new(30.0).unwrap();
        let begins: Vec<String> = (0..4).map(|f| clock.begin(f).to_string()).collect();
        assert_eq!(begins, ["0.000s", "0.033s", "0.066s", "0.100s"]);
        assert_eq!(clock.between(1, 3).to_string(), "0.067s");
        // 31 / 25 s is not truncated to 1.239.
        assert_eq!(Clock::new(25.0).unwrap().begin(31).to_string(), "1.240s");
        for fps in [0.001, 12.5, 29.97, 999.0, 1000.0] {
            let clock = Clock::new(fps).unwrap();
            assert!((0..2000).all(|f| clock.between(f, f + 1).0 > 0), "{fps}");
        }
        assert!(Clock::new(1001.0).is_err() && Clock::new(1e-30).is_err());
    }
}
