//! Key-framed shapes: a clip after key-frame reduction, ready to be written.
//!
//! Source: `docs/methods/vector.md` 7. All values are integers on a grid, so a writer loses nothing
//! and a reader restores them exactly.

use crate::planar::PlanarError;
use crate::planar::clip::MAX_FRAMES;
use crate::planar::keyed_motion::KeyedMotion;
pub(crate) use crate::planar::keyed_track::KeyedTrack;
use std::ops::Range;

/// Grid steps per pixel; the viewBox of an SVG is this many times its size.
pub(crate) const GRID: i32 = 4;
/// Steps of a gradient line over the width and over the height of its shape's bounding box.
pub(crate) const BOX: i32 = 1000;

/// Units of gradient lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum LineUnits {
    /// Grid steps on the picture.
    #[default]
    Grid,
    /// Thousandths of the width and height of the shape's bounding box, from its top left
    /// (`objectBoundingBox` of SVG): the line moves along with the shape, and bands of equal colour
    /// are sheared as the box is stretched.
    Box,
}

/// An animated vector graphic.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct KeyedClip {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Frames per second.
    pub fps: f32,
    /// Number of frames; frame `i` is at `i / fps` seconds, the last one ends the clip, which then
    /// repeats.
    pub frames: u32,
    /// End colours of the shared ramps, each from black; sRGB levels.
    pub ramps: Vec<[u8; 3]>,
    /// Units of the lines of all gradients.
    pub lines: LineUnits,
    /// Motions that shapes follow.
    pub motions: Vec<KeyedMotion>,
    /// The shapes, back to front.
    pub shapes: Vec<KeyedShape>,
}

/// One shape. A triangle that changes its position in the painting order has several.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct KeyedShape {
    /// Index into [`KeyedClip::motions`] of the motion that moves outline and gradient; `None` if they
    /// are on the picture.
    pub motion: Option<u32>,
    /// Points of its closed outlines as x, y, x, y, …; grid steps.
    pub outline: KeyedTrack,
    /// Index of the first point of each further closed outline (merged shapes have holes and
    /// islands); empty for a triangle.
    pub further_outlines: Vec<u32>,
    /// Fill of the shape.
    pub paint: KeyedPaint,
    /// Spans in which it is shown, in half frames, ascending and disjoint: a frame `f` in which it
    /// is drawn covers `2 f - 1 .. 2 f + 1`, clamped to `0 .. 2 (frames - 1) + 1`. Always shown if
    /// one span covers all of it.
    pub shown: Vec<Range<u32>>,
}

/// Fill of a shape.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum KeyedPaint {
    /// One colour, sRGB levels.
    Flat([u8; 3]),
    /// One colour that changes: red, green and blue by key, sRGB levels.
    Changing(KeyedTrack),
    /// A shared ramp from black to a colour, along a line.
    Ramp {
        /// Index into [`KeyedClip::ramps`].
        ramp: u32,
        /// The line x1, y1, x2, y2 in [`KeyedClip::lines`].
        line: KeyedTrack,
    },
    /// Two colours along a line, not shared with other shapes.
    Own {
        /// Colours at the line's start and end, sRGB levels.
        stops: [[u8; 3]; 2],
        /// The line x1, y1, x2, y2 in [`KeyedClip::lines`].
        line: KeyedTrack,
    },
}

impl KeyedClip {
    /// Checks that all parts are consistent, so that writers cannot fail.
    ///
    /// # Errors
    /// [`PlanarError::NoFrames`], or [`PlanarError::Mismatch`] with the index of the shape.
    pub(crate) fn check(&self) -> Result<(), PlanarError> {
        if self.frames == 0 {
            return Err(PlanarError::NoFrames);
        }
        if self.frames as usize > MAX_FRAMES {
            let (found, most) = (self.frames as usize, MAX_FRAMES);
            return Err(PlanarError::TooManyFrames { found, most });
        }
        let mismatch = |what: String| {
            let at = "keyed clip";
            Err(PlanarError::Mismatch { at, what })
        };
        if !self.fps.is_finite() || self.fps <= 0.0 {
            return mismatch(format!(
                "fps must be positive and finite, found {}",
                self.fps
            ));
        }
        for (m, motion) in self.motions.iter().enumerate() {
            if let Err(what) = motion.check(self.frames) {
                return mismatch(format!("motion {m}: {what}"));
            }
        }
        for (s, shape) in self.shapes.iter().enumerate() {
            if shape
                .motion
                .is_some_and(|m| m as usize >= self.motions.len())
            {
                return mismatch(format!("shape {s}: its motion is out of range"));
            }
            if let Err(what) = shape.check(self.frames, self.ramps.len()) {
                return mismatch(format!("shape {s}: {what}"));
            }
        }
        Ok(())
    }
}

impl KeyedShape {
    /// Half frames that cover spans of frames of a clip with `frames` frames.
    pub(crate) fn shown_in(spans: &[Range<usize>], frames: u32) -> Vec<Range<u32>> {
        let end = 2 * frames.saturating_sub(1) + 1;
        let half = |f: usize| (2 * f as u32).saturating_sub(1);
        let of = |span: &Range<usize>| half(span.start)..half(span.end).min(end);
        spans.iter().map(of).collect()
    }

    fn check(&self, frames: u32, ramps: usize) -> Result<(), &'static str> {
        self.outline.check(frames)?;
        if self.outline.width < 6 || !self.outline.width.is_multiple_of(2) {
            return Err("an outline has fewer than three points");
        }
        let points = self.outline.width as u32 / 2;
        let mut before = 0;
        for first in &self.further_outlines {
            if *first <= before || *first >= points {
                return Err("further outlines must rise within the points");
            }
            before = *first;
        }
        let end = 2 * (frames - 1) + 1;
        let mut before = None;
        for span in &self.shown {
            let is_apart = before.is_none_or(|end| end < span.start);
            if span.start >= span.end || span.end > end || !is_apart {
                return Err("the spans must rise within the clip");
            }
            before = Some(span.end);
        }
        let line = match &self.paint {
            KeyedPaint::Flat(_) => return Ok(()),
            KeyedPaint::Changing(color) => {
                let is_level = |level: &i32| (0..=255).contains(level);
                return match color.width == 3 && color.values.iter().all(is_level) {
                    true => color.check(frames),
                    false => Err("a colour must have three levels of 0 to 255"),
                };
            }
            KeyedPaint::Ramp { ramp, .. } if *ramp as usize >= ramps => {
                return Err("a ramp index is out of range");
            }
            KeyedPaint::Ramp { line, .. } | KeyedPaint::Own { line, .. } => line,
        };
        if line.width != 4 {
            return Err("the line of a gradient must have four values");
        }
        line.check(frames)
    }

    /// Whether the shape is shown at a time in frames.
    #[cfg(test)]
    pub(crate) fn is_shown_at(&self, frame: f64) -> bool {
        // Half frames begin half a frame before the first frame: frame f lies at 2 f.
        let half = 2.0 * frame;
        let covers =
            |span: &Range<u32>| f64::from(span.start) <= half && half < f64::from(span.end);
        self.shown.iter().any(covers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_shown_half_a_frame_to_both_sides() {
        let shape = KeyedShape {
            motion: None,
            outline: KeyedTrack::still(vec![0; 6]),
            further_outlines: vec![],
            paint: KeyedPaint::Flat([0; 3]),
            shown: vec![5..7, 9..11],
        };
        assert!(!shape.is_shown_at(2.4) && shape.is_shown_at(2.5));
        assert!(shape.is_shown_at(3.0) && shape.is_shown_at(3.4) && !shape.is_shown_at(3.5));
        assert!(!shape.is_shown_at(4.4) && shape.is_shown_at(4.5));
    }
}
