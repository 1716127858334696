//! A clip as the player has it: triangles in painting order, places and light as components.
//!
//! Source: `docs/methods/vector.md` 8.3.

use crate::low_rank::quantised::Quantised;
use crate::planar::shading::Shading;
use crate::planar::{PlanarClip, PlanarFrame, PlanarMaterial};
use glam::Vec2;
use std::ops::Range;

/// A weight of one of a named input, in coefficient steps.
pub(super) const INPUT_ONE: f64 = 256.0;

/// The painting order from a frame on, until the next one begins.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct PlayerEpoch {
    /// Its first frame; 0 for the first epoch.
    pub first_frame: u32,
    /// Triangles back to front.
    pub order: Vec<u32>,
}

/// What the player's container holds.
///
/// A *point* is a place, shared by all vertices that are never apart; a *wedge* is a point with
/// one light and one colour. Columns of the motion are x and y of each point in pixels, then, with
/// Gouraud shading, the light of each wedge times `light_weight`.
#[derive(Debug, Clone, PartialEq)]
pub struct PlayerClip {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Frames a second.
    pub fps: f32,
    /// Number of frames; frame `i` is at `i / fps`, the last one ends the clip.
    pub frames: u32,
    /// How triangles are filled.
    pub shading: Shading,
    /// How much full light counts in the columns.
    pub(crate) light_weight: f64,
    /// Wedges of each triangle; wedges are numbered as they are first named.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Point of each wedge; points are numbered as they are first named.
    pub wedge_points: Vec<u32>,
    /// sRGB albedo of each wedge (Gouraud) or colour of each triangle (flat).
    pub(crate) colors: Vec<[u8; 3]>,
    /// Frames in which each triangle is drawn: spans, rising and apart.
    pub(crate) shown: Vec<Vec<Range<u32>>>,
    /// The painting orders.
    pub(crate) epochs: Vec<PlayerEpoch>,
    /// Places and light; with inputs, its components are theirs.
    pub(crate) motion: Quantised,
    /// Names of the inputs that drive it; empty if it can only be played.
    pub inputs: Vec<String>,
}

/// One moment of a clip of the player.
#[derive(Debug, Clone, PartialEq)]
pub struct PlayerFrame {
    /// Place of each wedge, pixels.
    pub xy: Vec<Vec2>,
    /// Light of each wedge, 0 to 1 and a little beyond; ones with flat shading.
    pub light: Vec<f32>,
}

impl PlayerClip {
    /// Number of points.
    pub(crate) fn points(&self) -> usize {
        self.wedge_points
            .iter()
            .max()
            .map_or(0, |p| *p as usize + 1)
    }

    /// Places and light at a moment, in frames; straight between frames, held beyond the ends.
    pub fn moment(&self, frame: f64) -> PlayerFrame {
        let numbers = self.motion.row(frame);
        let place = |p: &u32| {
            let at = 2 * *p as usize;
            Vec2::new(numbers[at] as f32, numbers[at + 1] as f32)
        };
        let light = match self.shading {
            Shading::Flat => vec![1.0; self.wedge_points.len()],
            Shading::Gouraud => numbers[2 * self.points()..]
                .iter()
                .map(|n| (n / self.light_weight) as f32)
                .collect(),
        };
        PlayerFrame {
            xy: self.wedge_points.iter().map(place).collect(),
            light,
        }
    }

    /// Whether a triangle is drawn at a moment: as in the frame nearest to it.
    pub(crate) fn is_shown_at(&self, triangle: usize, frame: f64) -> bool {
        let nearest = self.nearest(frame);
        self.shown[triangle].iter().any(|s| s.contains(&nearest))
    }

    /// Triangles back to front at a moment: as in the frame nearest to it.
    pub(crate) fn order_at(&self, frame: f64) -> &[u32] {
        let nearest = self.nearest(frame);
        let after = self.epochs.partition_point(|e| e.first_frame <= nearest);
        &self.epochs[after.saturating_sub(1)].order
    }

    fn nearest(&self, frame: f64) -> u32 {
        // Halfway belongs to the later frame, as the player rounds.
        (frame + 0.5).floor().clamp(0.0, f64::from(self.frames - 1)) as u32
    }

    /// One moment as a planar clip of a single frame, in which what is painted later is nearer
    /// and what is not drawn has no area: [`crate::planar::reference`] of it is what an ideal
    /// player shows.
    pub(crate) fn painted(&self, frame: f64) -> PlanarClip {
        let moment = self.planar_frame(frame);
        let mut clip = self.planar(vec![PlanarFrame::default()]);
        let order = self.order_at(frame);
        let (albedo, triangles) = (clip.albedo, clip.triangles);
        clip.albedo = Vec::new();
        clip.triangles = Vec::new();
        let mut surface = Vec::new();
        for (rank, t) in order.iter().enumerate() {
            if !self.is_shown_at(*t as usize, frame) {
                continue;
            }
            let first = clip.albedo.len() as u32;
            let to = &mut clip.frames[0];
            for wedge in triangles[*t as usize].map(|w| w as usize) {
                to.xy.push(moment.xy[wedge]);
                to.light.push(moment.light[wedge]);
                to.nearness
                    .push((rank + 1) as f32 / (order.len() + 1) as f32);
                clip.albedo.push(albedo[wedge]);
            }
            clip.triangles.push([first, first + 1, first + 2]);
            surface.push(0);
        }
        clip.part = vec![0; surface.len()];
        clip.surface = surface;
        clip
    }

    pub(super) fn planar(&self, frames: Vec<PlanarFrame>) -> PlanarClip {
        let count = self.triangles.len();
        let levels = |c: &[u8; 3]| c.map(f32::from);
        let (triangles, albedo) = match self.shading {
            Shading::Gouraud => (
                self.triangles.clone(),
                self.colors.iter().map(levels).collect(),
            ),
            Shading::Flat => (
                (0..count as u32)
                    .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
                    .collect(),
                self.colors.iter().flat_map(|c| [levels(c); 3]).collect(),
            ),
        };
        PlanarClip {
            width: self.width,
            height: self.height,
            fps: self.fps,
            frames,
            triangles,
            surface: vec![0; count],
            part: vec![0; count],
            surfaces: vec![PlanarMaterial {
                name: String::new(),
                albedo: None,
            }],
            albedo,
        }
    }

    pub(super) fn planar_frame(&self, frame: f64) -> PlanarFrame {
        let moment = self.moment(frame);
        let (xy, light) = match self.shading {
            Shading::Gouraud => (moment.xy, moment.light),
            Shading::Flat => {
                let corners = self.triangles.iter().flatten();
                let xy: Vec<Vec2> = corners.map(|w| moment.xy[*w as usize]).collect();
                let light = vec![1.0; xy.len()];
                (xy, light)
            }
        };
        PlanarFrame {
            nearness: vec![0.0; xy.len()],
            xy,
            light,
        }
    }
}
