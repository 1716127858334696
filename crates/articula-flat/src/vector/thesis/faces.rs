//! Culling, painting order and colour of whole faces.
//!
//! Source: thesis 4.2.1 (view-frustum and back-face culling give one flag per face and frame;
//! occlusion is ignored) and 4.2.2 (sorted by depth at initialisation).

use crate::planar::order::Painting;
use crate::planar::{Drawn, PlanarClip, PlanarError};
use glam::Vec2;
use std::ops::Range;

/// Visibility of the faces per frame, and their painting order.
pub(super) struct Faces {
    flags: Drawn,
    /// Faces that are in view in some frame, far ones first.
    pub(super) order: Vec<u32>,
}

impl Faces {
    /// Culls the faces in some frames, and sorts them by their depth in the neutral one.
    ///
    /// # Errors
    /// [`PlanarError::Mismatch`] if the clip has no such neutral frame.
    pub(super) fn of(
        clip: &PlanarClip,
        frames: Range<usize>,
        neutral_frame: usize,
    ) -> Result<Self, PlanarError> {
        let mut flags = Drawn::none(clip.frames.len(), clip.triangles.len());
        let size = Vec2::new(clip.width as f32, clip.height as f32);
        for f in frames {
            for t in 0..clip.triangles.len() {
                flags.set(f, t, is_in_view(clip.places(f, t), size));
            }
        }
        let sorted = Painting::one_depth_sort(clip, &flags, neutral_frame)?;
        let order = sorted.epochs.into_iter().flat_map(|e| e.order).collect();
        Ok(Self { flags, order })
    }

    /// Number of pairs of a face and a frame in view.
    pub(super) fn shown(&self) -> usize {
        let of_face = |t: &u32| self.spans(*t).iter().map(Range::len).sum::<usize>();
        self.order.iter().map(of_face).sum()
    }

    /// Whether a face is in view in a frame.
    pub(super) fn is_shown(&self, frame: usize, face: u32) -> bool {
        self.flags.get(frame, face as usize)
    }

    /// Spans of frames in which a face is in view.
    pub(super) fn spans(&self, face: u32) -> Vec<Range<usize>> {
        self.flags.spans(face as usize)
    }
}

/// Whether a face shows its front and is not wholly beyond one side of the view.
fn is_in_view(corners: [Vec2; 3], size: Vec2) -> bool {
    let [a, b, c] = corners.map(|corner| corner.as_dvec2());
    // y points down, so a counter-clockwise face has negative area.
    let is_front = (b - a).perp_dot(c - a) < 0.0;
    let beyond = |is_out: &dyn Fn(Vec2) -> bool| corners.iter().all(|corner| is_out(*corner));
    let is_out = beyond(&|p| p.x <= 0.0)
        || beyond(&|p| p.y <= 0.0)
        || beyond(&|p| p.x >= size.x)
        || beyond(&|p| p.y >= size.y);
    is_front && !is_out
}

/// Colour of a face in a frame: the mean of its corners' colours, sRGB levels.
pub(super) fn mean_color(clip: &PlanarClip, frame: usize, face: u32) -> [u8; 3] {
    let corners = clip.triangles[face as usize].map(|v| clip.color(frame, v));
    let mean = |k: usize| (corners[0][k] + corners[1][k] + corners[2][k]) / 3.0;
    levels([mean(0), mean(1), mean(2)])
}

/// Rounds to whole levels, 0 to 255.
pub(super) fn levels(color: [f32; 3]) -> [u8; 3] {
    color.map(|level| level.round().clamp(0.0, 255.0) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planar::clip::fixture;

    const SIZE: Vec2 = Vec2::new(40.0, 40.0);

    #[test]
    fn backs_and_faces_beyond_one_side_are_culled_and_covered_ones_are_not() {
        let at = |x: f32, y: f32| [(x, y), (x, y + 5.0), (x + 5.0, y)].map(Vec2::from);
        assert!(is_in_view(at(2.0, 2.0), SIZE));
        let mut back = at(2.0, 2.0);
        back.swap(0, 1);
        assert!(!is_in_view(back, SIZE));
        // Partly in view counts as in view; touching a side does not.
        assert!(is_in_view(at(-4.0, 2.0), SIZE) && is_in_view(at(2.0, 39.0), SIZE));
        for (x, y) in [(-5.0, 2.0), (2.0, -5.0), (40.0, 2.0), (2.0, 40.0)] {
            assert!(!is_in_view(at(x, y), SIZE), "{x} {y}");
        }
        // Without area there is no front.
        assert!(!is_in_view([Vec2::ONE; 3], SIZE));
    }

    #[test]
    fn far_faces_are_painted_first_as_they_lie_in_the_neutral_frame() {
        let at = |near: f32| [[2.0, 2.0, near], [2.0, 9.0, near], [9.0, 2.0, near]];
        let mut clip = fixture::loose(
            &[(at(0.7), [1; 3]), (at(0.2), [2; 3]), (at(0.5), [3; 3])],
            2,
        );
        for v in 0..3 {
            clip.frames[1].nearness[v] = 0.1;
        }
        assert_eq!(Faces::of(&clip, 0..2, 0).unwrap().order, [1, 2, 0]);
        assert_eq!(Faces::of(&clip, 0..2, 1).unwrap().order, [0, 1, 2]);
        // The covered ones stay, since the thesis ignores occlusion.
        assert_eq!(Faces::of(&clip, 0..2, 0).unwrap().shown(), 6);
    }

    #[test]
    fn a_face_has_the_mean_colour_of_its_corners() {
        let mut clip = fixture::loose(&[([[0.0; 3]; 3], [90, 60, 240])], 1);
        clip.frames[0].light = vec![0.0, 0.5, 1.0];
        assert_eq!(mean_color(&clip, 0, 0), [45, 30, 120]);
        assert_eq!(levels([-3.0, 254.6, 999.0]), [0, 255, 255]);
    }
}
