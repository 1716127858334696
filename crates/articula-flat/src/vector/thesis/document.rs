//! Head and tail of a file, its numbers and its clock.

use crate::planar::PlanarError;
use glam::Vec2;
use std::fmt::{self, Display, Write};

/// An SVG that is being written.
pub(super) struct Document(String);

impl Document {
    /// Opens a picture of this many pixels.
    pub(super) fn new(width: u32, height: u32) -> Self {
        // Gradients add up to the colours at the corners in sRGB only.
        Self(format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" \
             xmlns:xlink=\"http://www.w3.org/1999/xlink\" version=\"1.1\" width=\"{width}\" \
             height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
             color-interpolation-filters=\"sRGB\">\n"
        ))
    }

    /// What was written so far, to write on.
    pub(super) fn text(&mut self) -> &mut String {
        &mut self.0
    }

    /// Closes it; the text and the number of its elements.
    pub(super) fn end(mut self) -> (String, usize) {
        self.0.push_str("</svg>\n");
        // Nothing but elements and the first line has such a bracket.
        let brackets = self.0.matches('<').count();
        let elements = brackets - self.0.matches("</").count() - 1;
        (self.0, elements)
    }
}

/// Appends formatted text; a `String` takes everything.
pub(super) fn put(text: &mut String, arguments: fmt::Arguments<'_>) {
    text.write_fmt(arguments).unwrap_or_default();
}

/// A closed triangle with absolute coordinates, as `d` has it.
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

/// Corners as `points` has them, with so many decimals.
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

/// A moment or a length of time in milliseconds, as SVG writes it.
#[derive(Clone, Copy)]
pub(super) struct Millis(u64);

impl Display for Millis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{:03}s", self.0 / 1000, self.0 % 1000)
    }
}

/// When frames begin.
#[derive(Clone, Copy)]
pub(super) struct Clock {
    fps: f64,
}

impl Clock {
    /// A clock of so many frames a second.
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

    /// When a frame begins. Cut, not rounded: at `frame / fps` it has begun in any case.
    pub(super) fn begin(self, frame: usize) -> Millis {
        Millis((frame as f64 / self.fps * 1000.0 + 1e-6) as u64)
    }

    /// Time from the begin of a frame to that of another.
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
        // 31 / 25 s is not cut to 1.239.
        assert_eq!(Clock::new(25.0).unwrap().begin(31).to_string(), "1.240s");
        for fps in [0.001, 12.5, 29.97, 999.0, 1000.0] {
            let clock = Clock::new(fps).unwrap();
            assert!((0..2000).all(|f| clock.between(f, f + 1).0 > 0), "{fps}");
        }
        assert!(Clock::new(1001.0).is_err() && Clock::new(1e-30).is_err());
    }
}
