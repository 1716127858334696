//! Visibility of triangles per frame.
//!
//! Source: `docs/methods/vector.md` 3. A triangle is visible if it owns at least one of the 2 x 2
//! samples of some pixel; covered triangles and back faces are not drawn, which changes no pixel.
//! Short gaps are drawn too, since switching costs more bytes than painting something hidden.

use super::clip::PlanarClip;
use super::error::PlanarError;
use crate::item_buffer::{Faces, ItemBuffer, Supersampling};
use std::ops::Range;

/// Gaps of fewer frames than this are drawn.
const SHORT_GAP: usize = 6;

/// A bit for each frame and triangle.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Drawn {
    frames: usize,
    triangles: usize,
    bits: Vec<bool>,
}

impl PlanarClip {
    /// Returns the number of triangles that are visible in some frame.
    ///
    /// O(frames x samples covered).
    ///
    /// # Errors
    /// Errors of the clip, or [`PlanarError::NothingVisible`].
    pub fn triangles_seen(&self) -> Result<usize, PlanarError> {
        Ok(Drawn::seen(self)?.ever().len())
    }
}

impl Drawn {
    /// Nothing is drawn.
    pub(crate) fn none(frames: usize, triangles: usize) -> Self {
        Self {
            frames,
            triangles,
            bits: vec![false; frames * triangles],
        }
    }

    /// Finds the visible triangles of a clip; gaps shorter than six frames between frames in which
    /// the triangle is visible are filled.
    ///
    /// O(frames x samples covered).
    ///
    /// # Errors
    /// Errors of the clip, or [`PlanarError::NothingVisible`].
    #[cfg(test)]
    pub(crate) fn of(clip: &PlanarClip) -> Result<Self, PlanarError> {
        Ok(Self::seen(clip)?.with_short_gaps())
    }

    /// Returns a copy in which gaps shorter than six frames are filled.
    #[must_use]
    pub(crate) fn with_short_gaps(&self) -> Self {
        let mut drawn = self.clone();
        for t in 0..drawn.triangles {
            drawn.fill_gaps(t);
        }
        drawn
    }

    /// Finds the visible triangles of a clip, frame by frame.
    ///
    /// # Errors
    /// Errors of the clip, or [`PlanarError::NothingVisible`].
    pub(crate) fn seen(clip: &PlanarClip) -> Result<Self, PlanarError> {
        clip.check()?;
        let mut drawn = Self::none(clip.frames.len(), clip.triangles.len());
        let mut buffer = ItemBuffer::new(clip.width, clip.height, Supersampling::Two)?;
        for f in 0..clip.frames.len() {
            draw_frame(clip, f, &mut buffer);
            let (width, height) = buffer.sample_size();
            for y in 0..height {
                for x in 0..width {
                    if let Some(t) = buffer.item(x, y) {
                        drawn.set(f, t as usize, true);
                    }
                }
            }
        }
        if !drawn.bits.contains(&true) {
            return Err(PlanarError::NothingVisible);
        }
        Ok(drawn)
    }

    /// Number of frames.
    pub(crate) fn frames(&self) -> usize {
        self.frames
    }

    /// Number of triangles, drawn or not.
    pub(crate) fn triangles(&self) -> usize {
        self.triangles
    }

    /// Whether a triangle is drawn in a frame.
    pub(crate) fn get(&self, frame: usize, triangle: usize) -> bool {
        self.bits[frame * self.triangles + triangle]
    }

    /// Sets whether a triangle is drawn in a frame.
    pub(crate) fn set(&mut self, frame: usize, triangle: usize, drawn: bool) {
        self.bits[frame * self.triangles + triangle] = drawn;
    }

    /// Triangles that are drawn in some frame, ascending.
    pub(crate) fn ever(&self) -> Vec<u32> {
        self.within(&(0..self.frames))
    }

    /// Triangles that are drawn in some of these frames, ascending.
    pub(crate) fn within(&self, frames: &Range<usize>) -> Vec<u32> {
        let mask = self.mask(frames);
        (0..)
            .zip(mask)
            .filter_map(|(t, is)| is.then_some(t))
            .collect()
    }

    /// Whether each triangle is drawn in some of these frames.
    pub(crate) fn mask(&self, frames: &Range<usize>) -> Vec<bool> {
        let mut mask = vec![false; self.triangles];
        for f in frames.start..frames.end.min(self.frames) {
            let row = &self.bits[f * self.triangles..(f + 1) * self.triangles];
            for (is_drawn, bit) in mask.iter_mut().zip(row) {
                *is_drawn |= bit;
            }
        }
        mask
    }

    /// Checks the numbers of frames and triangles against a clip.
    ///
    /// # Errors
    /// [`PlanarError::Mismatch`] if they differ.
    pub(crate) fn fits(&self, clip: &PlanarClip) -> Result<(), PlanarError> {
        let (frames, triangles) = (clip.frames.len(), clip.triangles.len());
        if (self.frames, self.triangles) == (frames, triangles) {
            return Ok(());
        }
        let found = format!("{} frames of {} triangles", self.frames, self.triangles);
        let what = format!("{found}, expected {frames} of {triangles}");
        let at = "drawn";
        Err(PlanarError::Mismatch { at, what })
    }

    /// Spans of frames in which a triangle is drawn.
    pub(crate) fn spans(&self, triangle: usize) -> Vec<Range<usize>> {
        let mut spans: Vec<Range<usize>> = Vec::new();
        for f in (0..self.frames).filter(|f| self.get(*f, triangle)) {
            match spans.last_mut() {
                Some(last) if last.end == f => last.end = f + 1,
                _ => spans.push(f..f + 1),
            }
        }
        spans
    }

    fn fill_gaps(&mut self, triangle: usize) {
        let spans = self.spans(triangle);
        for pair in spans.windows(2) {
            let gap = pair[0].end..pair[1].start;
            if gap.len() < SHORT_GAP {
                for f in gap {
                    self.set(f, triangle, true);
                }
            }
        }
    }
}

/// Clears the buffer and draws the front faces of one frame.
pub(crate) fn draw_frame(clip: &PlanarClip, frame: usize, buffer: &mut ItemBuffer) {
    buffer.clear();
    for t in 0..clip.triangles.len() {
        buffer.draw(t as u32, clip.corners(frame, t), Faces::Front);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planar::clip::fixture;

    #[test]
    fn a_cube_shows_three_sides_and_every_side_once() {
        let cube = fixture::turning_cube(24);
        let drawn = Drawn::seen(&cube).unwrap();
        for f in 0..24 {
            let count = (0..12).filter(|t| drawn.get(f, *t)).count();
            assert!((2..=6).contains(&count), "{count} in frame {f}");
        }
        assert!(drawn.ever().len() >= 8);
    }

    #[test]
    fn covered_triangles_and_backs_are_not_drawn() {
        let front = [[2.0, 2.0, 0.9], [2.0, 38.0, 0.9], [38.0, 2.0, 0.9]];
        let behind = [[4.0, 4.0, 0.2], [4.0, 20.0, 0.2], [20.0, 4.0, 0.2]];
        let mut back = front;
        back.swap(1, 2);
        let clip = fixture::loose(&[(behind, [1; 3]), (front, [2; 3]), (back, [3; 3])], 2);
        let drawn = Drawn::of(&clip).unwrap();
        assert_eq!(drawn.ever(), [1]);
        assert_eq!(drawn.spans(1), vec![0..2]);
    }

    #[test]
    fn five_hidden_frames_are_drawn_and_six_are_not() {
        for (hidden, expected) in [(5, 1), (6, 2)] {
            let mut drawn = Drawn::none(3 + hidden, 1);
            drawn.set(0, 0, true);
            drawn.set(1 + hidden, 0, true);
            drawn.fill_gaps(0);
            assert_eq!(drawn.spans(0).len(), expected);
            // Frames before the first and after the last visible one stay empty.
            assert!(!drawn.get(2 + hidden, 0));
        }
    }
}
