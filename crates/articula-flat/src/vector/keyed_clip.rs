//! Shapes with keys: what is left of a clip after key-frame reduction, ready to be written.
//!
//! Source: `spec/vector.md` 7. Everything is a whole number on a grid, so that a writer loses
//! nothing and a reader gets it back exactly.

use std::ops::Range;

/// Steps of the grid in a pixel; the viewBox of an SVG is this many times its size.
pub const GRID: i32 = 4;

/// A moving vector graphic.
#[derive(Debug, Clone, PartialEq)]
pub struct KeyedClip {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Frames a second.
    pub fps: f32,
    /// Number of frames; frame `i` is at `i / fps`, the last one ends the clip, then it repeats.
    pub frames: u32,
    /// The colours of the shared ramps, each from black to this; sRGB levels.
    pub ramps: Vec<[u8; 3]>,
    /// The shapes, back to front.
    pub shapes: Vec<KeyedShape>,
}

/// One shape. A triangle that changes its place in the painting order is there more than once.
#[derive(Debug, Clone, PartialEq)]
pub struct KeyedShape {
    /// Its closed outlines' points as x, y, x, y, …; grid steps.
    pub outline: KeyedTrack,
    /// First point of each further closed outline (merged shapes have holes and islands); empty
    /// for a triangle.
    pub further_outlines: Vec<u32>,
    /// Its paint.
    pub paint: KeyedPaint,
    /// When it is shown, in half frames, rising and apart: a frame `f` in which it is drawn
    /// covers `2 f - 1 .. 2 f + 1`, held within `0 .. 2 (frames - 1) + 1`. Always shown if this
    /// is one span over all of it.
    pub shown: Vec<Range<u32>>,
}

/// What a shape is filled with.
#[derive(Debug, Clone, PartialEq)]
pub enum KeyedPaint {
    /// One colour, sRGB levels.
    Flat([u8; 3]),
    /// A shared ramp from black to a colour, along a line.
    Ramp {
        /// Index into [`KeyedClip::ramps`].
        ramp: u32,
        /// The line x1, y1, x2, y2 in grid steps.
        line: KeyedTrack,
    },
    /// Two colours of its own along a line.
    Own {
        /// sRGB levels at the line's start and end.
        stops: [[u8; 3]; 2],
        /// The line x1, y1, x2, y2 in grid steps.
        line: KeyedTrack,
    },
}

/// Numbers that move straight from key to key.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct KeyedTrack {
    /// Frame of each key, rising. One key alone does not move. More than one: the first is 0
    /// and the last the clip's last frame.
    pub frames: Vec<u32>,
    /// `frames.len() * width` numbers.
    pub values: Vec<i32>,
    /// Numbers a key.
    pub width: usize,
}

impl KeyedTrack {
    /// A track that does not move.
    pub fn still(values: Vec<i32>) -> Self {
        Self {
            frames: vec![0],
            width: values.len(),
            values,
        }
    }

    /// Whether there is nothing but one key.
    pub fn is_still(&self) -> bool {
        self.frames.len() < 2
    }

    /// The numbers of a key.
    pub fn key(&self, key: usize) -> &[i32] {
        &self.values[key * self.width..(key + 1) * self.width]
    }

    /// Number of keys.
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// Whether there is no key.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// The numbers at a moment, in frames; held beyond the ends.
    pub fn at(&self, frame: f64) -> Vec<f64> {
        let after = self.frames.partition_point(|f| f64::from(*f) <= frame);
        let of = |key: usize| self.key(key).iter().map(|v| f64::from(*v));
        if self.is_empty() {
            return Vec::new();
        }
        if after == 0 || after == self.len() {
            return of(after.saturating_sub(1)).collect();
        }
        let (from, to) = (
            f64::from(self.frames[after - 1]),
            f64::from(self.frames[after]),
        );
        let share = (frame - from) / (to - from);
        of(after - 1)
            .zip(of(after))
            .map(|(a, b)| a + (b - a) * share)
            .collect()
    }
}

impl KeyedShape {
    /// Whether it is shown at a moment, in frames.
    pub fn is_shown_at(&self, frame: f64) -> bool {
        // Half frames are counted from half a frame before the first: frame f lies at 2 f.
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
    fn a_track_runs_straight_and_holds_at_its_ends() {
        let track = KeyedTrack {
            frames: vec![0, 4, 6],
            values: vec![0, 10, 8, 10, 8, 0],
            width: 2,
        };
        assert_eq!(track.at(1.0), [2.0, 10.0]);
        assert_eq!(track.at(5.0), [8.0, 5.0]);
        assert_eq!(track.at(-1.0), [0.0, 10.0]);
        assert_eq!(track.at(9.0), [8.0, 0.0]);
        assert_eq!(KeyedTrack::still(vec![3]).at(7.5), [3.0]);
        assert!(KeyedTrack::default().at(0.0).is_empty());
    }

    #[test]
    fn a_frame_is_shown_half_a_frame_to_both_sides() {
        let shape = KeyedShape {
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
